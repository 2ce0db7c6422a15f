# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth: native/include/rumple/base_cloth.h; docs/base_cloth.md has the mathematics."""
from __future__ import annotations

from typing import Any, NamedTuple, Sequence

import numpy as np

from . import c
from .arrays import FLOAT, INT, address, checked, fill, given, lent_all, new, optional
from .handle import Array, Handle, Number
from .library import lib
from .struct import Vector, put
from .surface import Surface, fill_stored, stored_array


class Collider(Handle):
    """Bodies that cloth stays outside of."""

    __slots__ = ()
    POINTER, FREE = c.ColliderPointer, "rumple_collider_free"

    def __init__(self, positions: np.ndarray, triangles: np.ndarray, rest: np.ndarray | None = None,
                 worn_within: float = 0.0) -> None:
        """positions: (b, 3) float32, any pose. triangles: (t, 3) int32, counter-clockwise from outside. rest: (b, 3)
        float32, positions while the cloth is at rest, NaN where not known. A triangle that is then farther than
        worn_within from a place of the cloth is never under that place."""
        self._filled(self, lib.rumple_collider_build, *given(positions, "positions", FLOAT, 3),
                     *given(triangles, "triangles", INT, 3), *optional(rest, "rest", FLOAT, 3), worn_within)

    @property
    def vertex_count(self) -> int:
        """The number of vertices, b."""
        return lib.rumple_collider_vertex_count(self)


def bodies(collider: Collider | None, positions: np.ndarray | None) -> Any:
    """Bodies in the pose of a frame. positions: (b, 3) float32; it must outlive them."""
    out = c.Bodies()
    if collider is not None:
        if positions is None:
            raise ValueError("body_positions: expected an array, got None")
        place, count = given(positions, "body_positions", FLOAT, 3)
        put(out, "collider", collider._as_parameter_)
        put(out, "positions", place)
        put(out, "positions_count", count)
    return out


class BaseClothModel(Handle):
    """Springs and contacts of a coarse mesh. Made by build_base_cloth."""

    __slots__ = ("base",)
    base: Surface
    POINTER, FREE = c.BaseClothPointer, "rumple_base_cloth_free"


def build_base_cloth(surface: Surface) -> BaseClothModel:
    """The springs and contacts of a coarse mesh at rest."""
    model = BaseClothModel.made(lib.rumple_base_cloth_build, surface)
    model.base = surface
    return model


class BaseClothSettings(c.BaseClothSettings):
    """Settings of the base cloth. Stiffness is per mass: object units^2 / s^2. Lengths are object units."""

    __slots__ = ()
    gravity: Any = Vector("three floats, object space, object units / s^2")
    hang: Any = Vector("three floats, object space, length 0 to 1: along it there is no slack")

    def __new__(cls) -> "BaseClothSettings":
        return cls.from_buffer_copy(lib.rumple_base_cloth_settings_default())


class BaseClothSwing(c.BaseClothSwing):
    """The settings that swing_base_cloth needs in addition to BaseClothSettings."""

    __slots__ = ()
    wind: Any = Vector("three floats, object space, object units / s")

    def __new__(cls) -> "BaseClothSwing":
        return cls.from_buffer_copy(lib.rumple_base_cloth_swing_default())

    def place(self, matrix: Sequence[Sequence[float]], shift: Sequence[float]) -> None:
        """Set the transform from the previous frame's object space to this one's: (3, 3), then (3,) object units."""
        self.matrix[:] = [value for row in matrix for value in row]
        self.shift[:] = list(shift)


class VertexForces(NamedTuple):
    """Forces that differ between vertices, in addition to wind and gravity. Object space."""

    air: np.ndarray  # (n, 3) float32: velocity of the air in addition to `wind`, object units / s
    push: np.ndarray  # (n, 3) float32: acceleration, object units / s^2
    resist: np.ndarray  # (n, 2) float32, >= 0: linear drag, 1/s, and quadratic drag, 1/object unit


class BaseClothPaint(Handle):
    """Painted factors."""

    __slots__ = ()
    POINTER, FREE = c.BaseClothPaintPointer, "rumple_base_cloth_paint_free"

    def __init__(self, model: BaseClothModel, painted: dict[str, np.ndarray] | None = None) -> None:
        """painted: follow, room -> (n,) float32, 0..1; other names are ignored."""
        values = c.BaseClothPainted()
        for name in ("follow", "room"):
            fill(values, name, (painted or {}).get(name), FLOAT)
        self._filled(self, lib.rumple_base_cloth_paint_build, model, values)


class BaseClothState(Handle):
    """A solved frame, and the values that the next frame starts from. w welded vertices."""

    __slots__ = ()
    POINTER, FREE = c.BaseClothStatePointer, "rumple_base_cloth_state_free"
    VIEW, LOOK = c.BaseClothStateView, "rumple_base_cloth_state_get_view"

    positions = Array("(n, 3) float32: the cloth, object space", FLOAT, "vertex_count", 3)
    gap = Array("(n,) float32: its height above what is worn under it, object units", FLOAT, "vertex_count")
    body_hint = Array("(n,) int32: a triangle of the collider near every vertex or -1; (0,) without one", INT,
                      "body_hint_count")
    offset = Array("(w, 3) float32, in the tangent frame of the animated vertex", FLOAT, "offset_count", 3)
    clearance = Array("(w,) float32: how far each may go inwards, object units", FLOAT, "clearance_count")
    velocity = Array("(w, 3) float32, object units / s; (0, 3) where it does not swing", FLOAT, "velocity_count", 3)
    nbytes = Number("memory of what lives on", "bytes")

    ARRAYS = {"offset": (FLOAT, 3), "length": (FLOAT, 0), "clearance": (FLOAT, 0), "ahead_height": (FLOAT, 0),
              "body_hint": (INT, 0), "contact_hint": (INT, 0), "position": (FLOAT, 3), "velocity": (FLOAT, 3),
              "animated": (FLOAT, 3), "animated_before": (FLOAT, 3), "air": (FLOAT, 3), "push": (FLOAT, 3)}
    NUMBERS, VECTORS = ("moved", "seconds", "fastest"), ("gravity", "wind")

    @property
    def arrays(self) -> dict[str, Any]:
        """The values for the next frame as plain arrays. A state that of() makes from them continues with the same
        bits, but has no positions."""
        kept = c.BaseClothKept()
        lib.rumple_base_cloth_state_get_kept(self, kept)
        return {**{name: np.float32(getattr(kept, name)) for name in self.NUMBERS},
                **{name: np.array(getattr(kept, name), FLOAT) for name in self.VECTORS},
                **lent_all(self, kept, self.ARRAYS)}

    @classmethod
    def of(cls, model: BaseClothModel, arrays: dict[str, Any]) -> "BaseClothState":
        """The state from the plain arrays of `arrays`."""
        kept = c.BaseClothKept()
        fill_stored(kept, arrays, cls.ARRAYS)
        for name in cls.NUMBERS:
            put(kept, name, float(stored_array(arrays, name)))
        for name in cls.VECTORS:
            getattr(kept, name)[:] = checked(stored_array(arrays, name), name, FLOAT).tolist()
        return cls.made(lib.rumple_base_cloth_state_build, model, kept)

    def activated(self) -> "BaseClothState":
        """A copy in which no vertex is asleep, for a solve with other settings. Only for cloth with inertia."""
        return BaseClothState.made(lib.rumple_base_cloth_state_activated, self)


class BaseClothReport(c.BaseClothReport):
    """The report on a solve."""

    __slots__ = ()


Solved = tuple[np.ndarray, np.ndarray, np.ndarray, BaseClothState, BaseClothReport]


def _solved(solve: Any, arguments: tuple[Any, ...], positions: np.ndarray, collider: Collider | None,
            body_positions: np.ndarray | None, state: BaseClothState | None) -> Solved:
    report = BaseClothReport()
    out = BaseClothState.made(solve, *arguments, *given(positions, "positions", FLOAT, 3),
                              bodies(collider, body_positions), state, report)
    return out.positions, out.gap, out.body_hint, out, report


def solve_base_cloth(model: BaseClothModel, settings: BaseClothSettings, paint: BaseClothPaint, positions: np.ndarray,
                     collider: Collider | None = None, body_positions: np.ndarray | None = None,
                     state: BaseClothState | None = None) -> Solved:
    """Solve one frame; returns (positions, gap, body_hint, state, report). positions: (n, 3) float32 of the cloth,
    object space. gap: (n,) float32, height above the body, object units. body_hint: (n,) int32, a triangle of the
    collider near each vertex, or -1; (0,) without a collider.

    positions: (n, 3) float32, animated. body_positions: (b, 3) float32 of the collider in this pose. state: of the
    frame before, or None. Mueller and Chentanez 2010, section 4.3.
    """
    return _solved(lib.rumple_base_cloth_solve, (model, settings, paint), positions, collider, body_positions, state)


def swing_base_cloth(model: BaseClothModel, settings: BaseClothSettings, swing: BaseClothSwing, paint: BaseClothPaint,
                     positions: np.ndarray, collider: Collider | None = None, body_positions: np.ndarray | None = None,
                     state: BaseClothState | None = None, forces: VertexForces | None = None) -> Solved:
    """Solve one frame of cloth with inertia (Baraff and Witkin 1998). Arguments and results as in solve_base_cloth.
    Without a state with inertia it returns the equilibrium, with zero velocity. forces: of force fields, or None."""
    if forces is not None:
        swing = type(swing).from_buffer_copy(swing)
        for name, array in forces._asdict().items():
            fill(swing, name, array, FLOAT, array.shape[-1])
    return _solved(lib.rumple_base_cloth_swing_solve, (model, settings, swing, paint), positions, collider,
                   body_positions, state)


class ClothCover(Handle):
    """Points of a smooth surface that are kept off bodies. Made by build_cloth_cover."""

    __slots__ = ()
    POINTER, FREE = c.ClothCoverPointer, "rumple_cloth_cover_free"


def build_cloth_cover(surface: Surface) -> ClothCover:
    """The points of a coarse mesh's smooth surface that are kept off bodies."""
    return ClothCover.made(lib.rumple_cloth_cover_build, surface)


def cover_bodies(cover: ClothCover, collider: Collider, body_positions: np.ndarray, positions: np.ndarray,
                 hints: np.ndarray, thickness: float, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) float32: how far every vertex must move outwards to keep the smooth surface off the bodies; (n,) float32,
    object units: how far folds around it may go inwards then, 0 where it was lifted, 1e8 where no body is near.

    positions: (n, 3) float32 of the cloth, object space. hints: (n,) int32, a triangle of the collider near it or -1.
    thickness, depth: object units; cloth deeper inside than depth is not pushed out.
    """
    settings = lib.rumple_cloth_cover_settings_default()
    settings.thickness, settings.depth = thickness, depth
    place, count = given(positions, "positions", FLOAT, 3)
    lifts, room = new(FLOAT, count, 3), new(FLOAT, count)
    lib.rumple_cloth_cover_lift(cover, settings, bodies(collider, body_positions), place, count,
                                *given(hints, "hints", INT), address(lifts), count, address(room), count)
    return lifts, room


def untangle_cloth(surface: Surface, animated: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """(n, 3) float32: positions without triangles that are turned over there and not in the animation. animated,
    positions: (n, 3) float32, object space."""
    place, count = given(positions, "positions", FLOAT, 3)
    out = new(FLOAT, count, 3)
    lib.rumple_cloth_untangle(surface, *given(animated, "animated", FLOAT, 3), place, count, address(out), count)
    return out


__all__ = ["BaseClothModel", "BaseClothPaint", "BaseClothReport", "BaseClothSettings", "BaseClothState",
           "BaseClothSwing", "ClothCover", "Collider", "VertexForces", "build_base_cloth", "build_cloth_cover",
           "cover_bodies", "solve_base_cloth", "swing_base_cloth", "untangle_cloth"]
