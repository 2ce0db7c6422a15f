# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of every wrinkled object from frame to frame, which is not stored in the file."""
from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ...core.frame import engine
from ...core.frame.frame_input import FrameRequest
from ...core.mesh.body import Body
from ...core.mesh.frame_result import FrameResult, PreviewFrame
from .. import scheduler
from .building import Building
from .runtime_table import RuntimeBase, RuntimeTable


@dataclass(frozen=True, eq=False)
class Inputs(FrameRequest):
    """The inputs of the last result. Equal inputs need no new solve. for_preview: the mesh is a proxy for depth and
    clicks, and preview.py draws the folds."""

    settings: Any  # of the system
    shows_coarse: bool = False  # instead of the folds, for Weight Paint tools (weight_paint.py)

    def goes_on_from(self, before: "Inputs") -> bool:
        """Whether the engine solves this frame from that one, as far as frames decide it."""
        return (not self.settings.stateless and before.start == self.start and self.frame.is_integer()
                and self.frame == before.frame + 1.0 > self.start)

    def same_as(self, other: "Inputs | None") -> bool:
        """Whether all but the start is equal."""
        return other is not None and all(_same(getattr(self, one.name), getattr(other, one.name))
                                         for one in fields(self) if one.name != "start")


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, Body):
        return one.same_as(other)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    return np.array_equal(one, other) if np.ndarray in (type(one), type(other)) else bool(one == other)


@dataclass
class Paint:
    """What is painted for an object, as it was read last."""

    values: dict[str, np.ndarray] | None = None  # by what they are for; None: must be read again
    weights: dict[str, np.ndarray] | None = None  # those of its vertex groups, by name; None: likewise
    in_use: set[str] = field(default_factory=set)  # names of the maps that were read last ...
    groups: list[str] = field(default_factory=list)  # ... and of all vertex groups at that time
    lost: dict[str, str] = field(default_factory=dict)  # see lost_maps.py: name -> new name, or an empty text
    steps: tuple[tuple[int, str, str], np.ndarray] | None = None  # see weight_paint.py
    measured: tuple[dict, dict[str, tuple[float, float]]] | None = None  # see painted_maps.py

    def forget(self) -> None:
        """Everything must be read again."""
        self.values = self.weights = None

    def invalidate(self) -> None:
        """All data of the file may have changed."""
        self.forget()
        self.in_use = set()  # undo may take paint back
        self.lost = {name: new for name, new in self.lost.items() if new}


@dataclass
class Build:
    """What `evaluator` was built from, and the build that is running."""

    shape: tuple[str, int, int] | None = None  # fingerprint of the inputs of `evaluator`, and its limits
    properties: dict[str, Any] = field(default_factory=dict)  # those for which `evaluator` was built
    refused: tuple[str, int, int, int] | None = None  # a shape that failed: not tried again until it changes
    running: Building | None = None  # will replace `evaluator` when it is ready
    just_added: bool = False  # by a click, and nothing is visible yet

    def stop(self) -> None:
        """Discard the result of a running build."""
        running, self.running = self.running, None
        if running is not None:
            running.drop()
            scheduler.remove_build(running)


@dataclass
class Seen:
    """What was seen at the last checks, to notice changes that Blender does not report."""

    scale: str = ""  # metres per object unit, at the last check of the fine mesh
    plain_scales: tuple = ()  # the values that `scale` depends on, at the last comparison
    own_vertices: int = -1  # of the artist's mesh, when the incoming mesh was last made
    stack: str = ""  # fingerprint of the modifiers in front, when the incoming mesh was last made
    groups: list[str] | None = None  # names of the vertex groups at the last check of the output object
    guides: list[str] = field(default_factory=list)  # names of the guides at the last search
    tried: int = -1  # number of incoming vertices at the last rebuild because of a wrong number
    empty_at: float | None = None  # the last frame in which it showed nothing although its modifier is on


@dataclass
class Runtime(RuntimeBase):
    """The state of one wrinkled object."""

    evaluator: engine.Wrinkles | None = None
    build: Build = field(default_factory=Build)
    paint: Paint = field(default_factory=Paint)
    seen: Seen = field(default_factory=Seen)
    shows_coarse: bool = False  # the mesh of output_key shows the coarse mesh, not the folds
    asked_for_coarse: bool = False  # by the last redraw
    inputs: Inputs | None = None
    current: Inputs | None = None  # in a call of solve.process(): of the frame that is found, for garments over it
    result: FrameResult | PreviewFrame | None = None  # content of the mesh of output_key
    fitting: tuple[int, ...] = ()  # output meshes that were compared with the solved mesh
    written_at: tuple[int, float] | None = None  # the scene and its frame that last wrote the output object
    written_for: dict[int, Inputs] = field(default_factory=dict)  # inputs of the last write, for each scene in a window
    moved_in: int = 0  # the scene that wrote the output object in its last frame, and will again
    analyzing: bool = False  # a bake analyses the clip: frames are only read, not solved ...
    analyzed: Inputs | None = None  # ... and these are the last inputs
    asked_for_proxy: bool = False  # by the last redraw of the preview
    bake_note: str = ""  # the error of the baked clip, in any frame
    lost_bound: list[tuple[str, str]] = field(default_factory=list)  # see held_by_others.py
    curve_points: int = 0  # the largest number of points that did not fit into its curves
    solving: float = 0.0  # seconds spent on solving in this call
    frame_seconds: float = 0.0  # duration of the last solved frame, including what comes before; 0: none
    pose: np.ndarray | None = None  # coarse positions read before a rebuild, for the next solve

    def forget_inputs(self) -> None:
        """The last result is of another evaluator or not visible, so the next update must solve."""
        self.inputs = None
        self.written_for.clear()

    def invalidate_output(self) -> None:
        self.forget_inputs()
        self.result = None
        self.fitting = ()
        super().invalidate_output()

    def invalidate(self) -> None:
        self.paint.invalidate()
        self.build.stop()
        super().invalidate()

    def end(self) -> None:
        self.build.stop()


_TABLE = RuntimeTable(Runtime)
of, known, message = _TABLE.of, _TABLE.known, _TABLE.message
forget, forget_all, forget_all_but = _TABLE.forget, _TABLE.forget_all, _TABLE.forget_all_but
invalidate_outputs, invalidate_all = _TABLE.invalidate_outputs, _TABLE.invalidate_all
