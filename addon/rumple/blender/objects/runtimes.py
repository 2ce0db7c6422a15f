# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept from frame to frame for every wrinkled object, outside the file."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core import engine
from ...core.body import Body
from ...core.surroundings import Surroundings
from .. import scheduler
from .building import Building
from .runtime_table import RuntimeBase, RuntimeTable


@dataclass
class Inputs:
    """What the last picture was solved from: equal inputs need no new one."""

    frame: float
    settings: Any  # of the system
    positions: np.ndarray
    world_from_object: np.ndarray
    paint: dict[str, np.ndarray]
    frame_rate: float  # frames a second
    uses_proxy: bool = False  # the mesh is a proxy for depth and clicks: the viewport draws the folds (preview.py)
    in_viewport: bool = False  # for the mesh of viewports (viewport_mesh.py)
    shows_coarse: bool = False  # in place of the folds, for tools of Weight Paint (weight_paint.py)
    body: Body | None = None
    surroundings: Surroundings = Surroundings()  # read where the cloth swings

    def same_as(self, other: "Inputs | None") -> bool:
        return (other is not None and self.frame == other.frame and self.settings == other.settings
                and (self.frame_rate, self.uses_proxy, self.in_viewport, self.shows_coarse) == (
                    other.frame_rate, other.uses_proxy, other.in_viewport, other.shows_coarse)
                and self.surroundings == other.surroundings
                and (other.body is None if self.body is None else self.body.same_as(other.body))
                and self.paint.keys() == other.paint.keys()
                and all(np.array_equal(self.paint[key], other.paint[key]) for key in self.paint)
                and np.array_equal(self.positions, other.positions)
                and np.array_equal(self.world_from_object, other.world_from_object))


@dataclass
class Runtime(RuntimeBase):
    """One wrinkled object."""

    evaluator: engine.Wrinkles | None = None
    shape: tuple[str, int, int] | None = None  # fingerprint of what `evaluator` was made from, and its limits
    refused: tuple[str, int, int, int] | None = None  # of what could not be made: not tried again until it changes
    building: Building | None = None  # what takes the evaluator's place when it is ready
    scale: str = ""  # of an object unit in metres, when the fine mesh was last looked at
    plain_scales: tuple = ()  # what that was made of when it was last compared
    just_added: bool = False  # by a click, and nothing of it is there yet
    built_with: dict[str, Any] = field(default_factory=dict)  # the properties that `evaluator` was made with
    paint: dict[str, np.ndarray] | None = None  # None: read again
    painted_steps: tuple[tuple[int, str, str], np.ndarray] | None = None  # of what: weight_paint.py
    shows_coarse: bool = False  # what the mesh of output_key shows in place of the folds
    asked_for_coarse: bool = False  # by a redraw, last
    measured: tuple[dict, dict[str, tuple[float, float]]] | None = None  # of what was read: painted_maps.py
    stack: str = ""  # fingerprint of the modifiers in front when the incoming mesh was last made
    empty_at: float | None = None  # the last frame in which it showed nothing, though its modifier is on
    tried: int = -1  # vertices that arrived, and did not fit, when it was last made anew for that reason
    guides: list[str] = field(default_factory=list)  # names of the guides when they were last looked for
    groups: list[str] | None = None  # names of the vertex groups when the output object was last checked
    inputs: Inputs | None = None
    result: engine.FrameResult | engine.PreviewFrame | None = None  # what the mesh of output_key holds
    fitting: tuple[int, ...] = ()  # the output meshes that were compared with what is solved
    written_at: tuple[int, float] | None = None  # the scene and its frame that wrote the output object last
    written_for: dict[int, Inputs] = field(default_factory=dict)  # what each of the scenes in windows wrote it from
    moved_in: int = 0  # the scene whose last frame wrote the output object: its next one will
    analyzing: bool = False  # a bake plays the clip through to see it: frames are read, not solved ...
    analyzed: Inputs | None = None  # ... and this is what was read
    asked_for_proxy: bool = False  # by the preview, last
    bake_note: str = ""  # what is wrong with the baked clip, whatever the frame
    curve_points: int = 0  # the most points that its curves had no room for
    solving: float = 0.0  # seconds, of what was solved in this call
    frame_seconds: float = 0.0  # that the last frame took which was solved anew, with what comes before; 0: none was
    pose: np.ndarray | None = None  # coarse positions read before a rebuild, for the solve right after it

    def forget_inputs(self) -> None:
        """What was solved from them is by another evaluator, or not shown: the next update solves."""
        self.inputs = None
        self.written_for.clear()

    def invalidate_output(self) -> None:
        self.forget_inputs()
        self.result = None
        self.fitting = ()
        super().invalidate_output()

    def invalidate(self) -> None:
        self.paint = None
        self.stop_building()
        super().invalidate()

    def stop_building(self) -> None:
        """What a thread makes for it is not wanted any more."""
        building, self.building = self.building, None
        if building is not None:
            building.drop()
            scheduler.drop(building)

    def end(self) -> None:
        self.stop_building()


_TABLE = RuntimeTable(Runtime)
of, known, message = _TABLE.of, _TABLE.known, _TABLE.message
forget, forget_all, forget_all_but = _TABLE.forget, _TABLE.forget_all, _TABLE.forget_all_but
invalidate_outputs, invalidate_all = _TABLE.invalidate_outputs, _TABLE.invalidate_all
