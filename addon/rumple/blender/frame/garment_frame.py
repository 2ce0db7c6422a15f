# SPDX-License-Identifier: GPL-3.0-or-later
"""One garment in one frame: what was read of Blender, the solve, and what is shown.

Garments that are not worn over one another are solved at the same time. Reading and writing Blender's data stays in the
thread that Blender calls; other threads use arrays only.
"""
from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Sequence

import bpy
import numpy as np

from ...core.base.at_once import call_at_once
from ...core.frame.found_frame import FoundFrame
from ...core.mesh.frame_result import FrameResult, PreviewFrame
from .. import compat
from ..objects import messages, output_mesh
from ..objects.runtimes import Inputs, Runtime
from . import first_pass, path_curves


@dataclass(eq=False)
class GarmentFrame:
    """A frame of a garment from its lookup to its writing: solve_all(), then show()."""

    obj: bpy.types.Object
    nodes_mod: bpy.types.NodesModifier
    output_obj: bpy.types.Object  # the one to be written
    runtime: Runtime
    inputs: Inputs
    scene: bpy.types.Scene
    mode: str  # of the depsgraph
    clip_fault: str  # the error of its baked clip
    found: FoundFrame
    _result: FrameResult | PreviewFrame | None = None
    _error: Exception | None = None
    _seconds: float = 0.0

    def solve(self) -> None:
        """Never raises. Any thread may call it, because it does not use Blender."""
        began = time.perf_counter()
        try:
            self._result = self.runtime.evaluator.finish_frame(self.found)
        except Exception as error:  # show() raises it again
            self._error = error
        self._seconds = time.perf_counter() - began

    def show(self) -> bool:
        """Returns whether the output object was written. Never raises."""
        with messages.frame_errors(self.obj, self.runtime):
            return self._show()
        return False

    def _show(self) -> bool:
        runtime, inputs, result = self.runtime, self.inputs, self._result
        if self._error is not None:
            raise self._error
        if isinstance(result, FrameResult) and not result.replayed:
            runtime.solving = self.found.seconds + self._seconds
        runtime.inputs = runtime.current = inputs
        messages.set_frame_error(runtime, self.clip_fault)
        unplayed = runtime.evaluator.unplayed_message(inputs.frame, inputs.start) if result.unplayed else ""
        messages.note_unplayed(runtime, unplayed, self.mode == "RENDER")
        if not first_pass.shows_fine_mesh(self.nodes_mod):
            runtime.result = result
            return False
        if runtime.evaluator.HAS_CURVES:
            path_curves.write(self.obj, runtime)
        written = _write(self.output_obj, runtime, result, self.mode == "VIEWPORT")
        if written:
            runtime.written_at = compat.session_key(self.scene), inputs.frame
        return written


def solve_all(frames: Sequence[GarmentFrame]) -> None:
    """Solve garments of which none is worn over another. What is quickly made is made in this thread."""
    to_be_solved = [frame for frame in frames if frame.found.must_be_solved]
    for frame in frames:
        if frame not in to_be_solved:
            frame.solve()
    call_at_once([frame.solve for frame in to_be_solved])


def _write(output_obj: bpy.types.Object, runtime: Runtime, result: FrameResult | PreviewFrame,
           in_viewport: bool) -> bool:
    """Write the result, unless it is already written, because a write tags the mesh and costs another evaluation."""
    key = compat.session_key(output_obj.data)
    shows_coarse = runtime.inputs is not None and runtime.inputs.shows_coarse
    last, showed_coarse = runtime.result, runtime.shows_coarse
    runtime.result, runtime.shows_coarse = result, shows_coarse
    if isinstance(result, PreviewFrame) and result.proxy_offset is None:
        runtime.output_key = key  # nobody reads its attributes, so they are not updated
        return False
    if (last is not None and runtime.output_key == key and showed_coarse == shows_coarse
            and last.shows_the_same(result)):
        return False
    if isinstance(result, PreviewFrame):
        output_mesh.write_proxy(output_obj.data, result.proxy_offset)
    else:
        output_mesh.write_result(output_obj.data, result, runtime.evaluator.ATTRIBUTES)
        if in_viewport:
            output_mesh.write_proxy(output_obj.data, np.zeros((0, 3), np.float32) if shows_coarse else None)
    runtime.output_key = key
    return True
