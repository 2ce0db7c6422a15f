# SPDX-License-Identifier: GPL-3.0-or-later
"""What lives from frame to frame for every wrinkled object, outside the file.

Nothing here is stored in ID properties: handlers run in a render thread too, where writing them is
forbidden. Messages are kept here and the panel reads them.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable

import bpy
import numpy as np

from ...core import engine
from ...core.body import Body
from ...core.surroundings import Surroundings
from .. import compat
from .messages import Messages


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
    body: Body | None = None
    surroundings: Surroundings = Surroundings()  # read where the cloth swings

    def same_as(self, other: "Inputs | None") -> bool:
        return (other is not None and self.frame == other.frame and self.settings == other.settings
                and (self.frame_rate, self.uses_proxy) == (other.frame_rate, other.uses_proxy)
                and self.surroundings == other.surroundings
                and (other.body is None if self.body is None else self.body.same_as(other.body))
                and self.paint.keys() == other.paint.keys()
                and all(np.array_equal(self.paint[key], other.paint[key]) for key in self.paint)
                and np.array_equal(self.positions, other.positions)
                and np.array_equal(self.world_from_object, other.world_from_object))


@dataclass
class Runtime(Messages):
    """One wrinkled object."""

    evaluator: engine.Wrinkles | None = None
    shape: str = ""  # fingerprint of what `evaluator` was made from
    refused: str = ""  # fingerprint of what could not be made: not tried again until it changes
    stale: bool = True  # base, settings or output object may have changed: check before the next structural step
    paint: dict[str, np.ndarray] | None = None  # None: read again
    groups: list[str] | None = None  # names of the vertex groups when the output object was last checked
    inputs: Inputs | None = None
    picture: engine.Picture | engine.Sketch | None = None  # what the output object holds
    output_key: int = 0  # ... which output object
    analyzing: bool = False  # a bake plays the clip through to see it: frames are read, not solved ...
    analyzed: Inputs | None = None  # ... and this is what was read
    asked_for_proxy: bool = False  # by the preview, last
    bake_note: str = ""  # what is wrong with the baked clip, whatever the frame
    curve_points: int = 0  # the most points that its curves had no room for
    pose: np.ndarray | None = None  # coarse positions read before a rebuild, for the solve right after it

    def invalidate_output(self) -> None:
        """The output object may hold something else now: write the next picture whatever it is."""
        self.inputs = self.picture = None
        self.output_key = 0


_runtimes: dict[int, Runtime] = {}


def of(obj: bpy.types.Object) -> Runtime:
    """The runtime of an original (not evaluated) object, made where there is none."""
    return _runtimes.setdefault(compat.session_key(obj), Runtime())


def known(obj: bpy.types.Object) -> Runtime | None:
    """The runtime of an object, or None."""
    return _runtimes.get(compat.session_key(obj))


def forget(obj: bpy.types.Object) -> None:
    _runtimes.pop(compat.session_key(obj), None)


def forget_all() -> None:
    _runtimes.clear()


def forget_all_but(objects: Iterable[bpy.types.Object]) -> None:
    """Deleted objects leave nothing behind; their address may be taken over by others."""
    keep = {compat.session_key(obj) for obj in objects}
    for key in [key for key in _runtimes if key not in keep]:
        del _runtimes[key]


def invalidate_all() -> None:
    """After undo and redo: stored frames stay, but everything in the file may be another version of itself."""
    for entry in _runtimes.values():
        entry.stale = True
        entry.paint = None
        entry.invalidate_output()


def message(obj: bpy.types.Object) -> str:
    """What is wrong with an object, in words; empty when nothing is."""
    entry = known(obj)
    return "" if entry is None else entry.refusal or entry.message
