# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays an object through a range of frames, so that each frame is solved from the one before it."""
from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

import bpy
import numpy as np

from ...core.base.wording import UserError
from ...core.mesh.frame_result import FrameResult
from .. import compat, scheduler
from ..frame import baking, clip_status
from ..objects import incoming_mesh, mesh_reader, modifier, runtimes, units, viewport_mesh, visibility


MOST_FRAME = 1_048_574  # Blender's limit, positive and negative: later frames cannot be reached


class BakeError(RuntimeError):
    """Why a bake cannot be made or continued: a message for the artist."""


class Playback:
    """Plays an object through a range of frames and returns the results."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, start: int, end: int, samples: int) -> None:
        for frame in (start, end):
            if abs(frame) > MOST_FRAME:
                raise BakeError(f"{obj.name}: Blender has no frame {frame}: change the first or the last frame")
        if end < start:
            raise BakeError(f"{obj.name}: the last frame ({end}) is before the first ({start}): change one of them")
        old, new = context.scene.render.frame_map_old, context.scene.render.frame_map_new
        if old != new:
            raise BakeError(f"{obj.name}: Time Stretching is on ({old} to {new}): bake with both the same; the clip is "
                            "stretched when it is on again")
        self.scene, self.obj, self.name, self.file = context.scene, obj, obj.name, scheduler.file_number()
        self.start, self.end, self.samples = start, end, samples
        self.now = self.scene.frame_current, self.scene.frame_subframe
        self.pre_roll = range(min(units.first_frame(obj, self.scene), start), start)
        self.seen = range(self.pre_roll.start, end + 1)  # frames that an analysis of the whole clip reads
        self.is_part = False
        self._held: tuple[FrameResult, np.ndarray] | None = None  # the last result
        self.analyzes = obj.rumple.bake_whole_clip and clip_status.sees_ahead(obj, context.scene)
        self._count_steps()
        nodes_mod = modifier.find(obj)
        # in the first pass, the object that it depends on is solved
        self.passes = 2 if modifier.depends_on_wrinkled(obj) else 1
        self.was_baked = modifier.is_baked(nodes_mod)
        if self.was_baked:
            modifier.set_baked(nodes_mod, False)
            runtimes.of(obj).stale = True
        try:
            scheduler.sync_all()
            baking.begin(obj)
        except BaseException:
            self.end_playback(restore_bake=True)
            raise

    def _count_steps(self) -> None:
        self.count = len(self.pre_roll) + self.sample_count + len(self.seen) * self.analyzes

    def keep_to(self, start: int, end: int, pre_roll: range) -> None:
        """Solve only a part of the frames, after the pre-roll. An analysis still reads the whole clip.
        """
        self.start, self.end, self.pre_roll, self.is_part = start, end, pre_roll, True
        self._count_steps()

    @property
    def is_independent(self) -> bool:
        """Whether a frame is solved without the frames before it."""
        return clip_status.is_independent(self.obj, self.scene)

    @property
    def sample_count(self) -> int:
        return (self.end - self.start) * self.samples + 1

    def solve_sample(self, sample: int) -> tuple[FrameResult, np.ndarray]:
        """(result, coarse positions) of one sample."""
        whole, part = divmod(sample, self.samples)
        return self.solve_at(self.start + whole, part / self.samples)

    def samples_in_order(self) -> Iterator[tuple[bool, FrameResult | None, np.ndarray | None]]:
        """(wanted, result, coarse positions) of every sample. Samples of the pre-roll are not wanted. Frames of an
        analysis are not wanted either, and have no result."""
        if self.analyzes:
            for _ in self.analyze():
                yield False, None, None
        if self.is_part:  # a part must not continue from other stored frames
            runtime = runtimes.of(self.obj)
            if runtime.evaluator is not None:
                runtime.evaluator.frame_cache.clear()
            runtime.invalidate_output()
        for frame in self.pre_roll:
            yield False, *self.solve_at(frame, 0.0)
        for sample in range(self.sample_count):
            yield True, *self.solve_sample(sample)

    @contextmanager
    def unsolved(self) -> Iterator[None]:
        """A context in which frames are evaluated up to the wrinkles, but not solved."""
        runtime = runtimes.of(self.obj)
        runtime.analyzing = True
        try:
            yield
        finally:
            runtime.analyzing, runtime.analyzed = False, None

    def analyze(self) -> Iterator[None]:
        """Read the pose of every whole frame, so that the solver can analyse the clip. Memory: 12 bytes per vertex and
        frame."""
        runtime, clip = runtimes.of(self.obj), {}
        runtime.analyzing = True
        for frame in self.seen:
            self.visit(frame, 0.0)
            if not self._is_skipped():
                if runtime.analyzed is None or runtime.analyzed.frame != frame:
                    raise BakeError(f"{self.obj.name}: nothing is seen at frame {frame}: "
                                    "see whether its modifier is on")
                clip[float(frame)] = runtime.analyzed.positions
            yield
        runtime.analyzing = False
        if not clip:
            return
        try:
            runtime.evaluator.analyze_clip(clip, runtime.analyzed.settings, frame_rate=runtime.analyzed.frame_rate)
        except UserError as error:
            raise BakeError(str(error)) from error
        runtime.invalidate_output()  # the shown result was solved without the analysis

    def _is_gone(self) -> bool:
        """Whether another file was opened. Then the scene must not be used: Blender 4.3 would crash."""
        return self.file != scheduler.file_number()

    def visit(self, frame: int, subframe: float = 0.0) -> runtimes.Runtime:
        """Let Blender evaluate a frame. Raises BakeError."""
        if self._is_gone():
            raise BakeError(f"{self.name}: another file was opened while it was baked: bake again")
        with viewport_mesh.paused():
            for _ in range(self.passes):
                self.scene.frame_set(frame, subframe=subframe)
        runtime = runtimes.of(self.obj)
        if runtime.refusal or runtime.message:
            raise BakeError(f"frame {frame + subframe:g}: {runtime.refusal or runtime.message}")
        return runtime

    def solve_at(self, frame: int, subframe: float) -> tuple[FrameResult, np.ndarray]:
        """(result, coarse positions) at any time. If keyed visibility hides the object: the last result, or at first
        the rest shape."""
        runtime = self.visit(frame, subframe)
        if self._is_skipped() and runtime.evaluator is not None:
            return self._held or self._at_rest(runtime)
        if (not isinstance(runtime.result, FrameResult) or runtime.inputs is None
                or abs(runtime.inputs.frame - frame - subframe) > 1e-3):
            if not self.obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).is_evaluated:
                raise BakeError(f"{self.name}: nothing is solved at frame {frame + subframe:g}, it is hidden: show it")
            if mesh_reader.is_busy(self.obj):
                raise BakeError(f"{self.obj.name}: nothing is solved while its mesh is edited: leave Sculpt Mode, or "
                                "Edit Mode of another object with this mesh")
            raise BakeError(f"{self.obj.name}: nothing is solved at frame {frame + subframe:g}: "
                            "see whether its modifier is on")
        self._held = runtime.result, runtime.inputs.positions
        return self._held

    def _is_skipped(self) -> bool:
        """Whether keyed visibility hides the object in this frame."""
        return visibility.is_keyed(self.obj) and visibility.is_skipped(self.obj, bpy.context.evaluated_depsgraph_get())

    def _at_rest(self, runtime: runtimes.Runtime) -> tuple[FrameResult, np.ndarray]:
        """(result, coarse positions) of a frame in which nothing is solved."""
        runtime.invalidate_output()  # results from before the bake are not part of it
        evaluator = runtime.evaluator
        rest = np.ascontiguousarray(evaluator.positions_rest, np.float32)
        return (FrameResult.at_rest(rest, len(evaluator.corner_vertex), evaluator.ATTRIBUTES),
                compat.positions(incoming_mesh.of(self.obj)))

    def note(self) -> str:
        """A warning about the solved frames, for the report; empty if there is none."""
        evaluator = runtimes.of(self.obj).evaluator
        others = sorted(evaluator.pose_mismatches) if evaluator is not None else []
        return (f". {len(others)} frames have another pose than the analysis of the clip saw (first: {others[0]:g}): "
                "they were solved as in playback") if others else ""

    def end_playback(self, restore_bake: bool) -> None:
        """Restore the state before the playback, as far as possible: the object or the file may be gone."""
        baking.end()
        if self._is_gone():
            return
        try:
            self._end_of_object(restore_bake)
        except ReferenceError:
            pass
        self.scene.frame_set(self.now[0], subframe=self.now[1])

    def _end_of_object(self, restore_bake: bool) -> None:
        runtime = runtimes.of(self.obj)
        if self.analyzes and runtime.evaluator is not None:
            runtime.analyzing, runtime.analyzed = False, None
            runtime.evaluator.analyze_clip({}, None)
            runtime.invalidate_output()
        if restore_bake and self.was_baked:
            nodes_mod = modifier.find(self.obj)
            if nodes_mod is not None and modifier.cache_object(nodes_mod) is not None:
                modifier.set_baked(nodes_mod, True)
                runtime.stale = True
