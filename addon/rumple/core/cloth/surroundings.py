# SPDX-License-Identifier: GPL-3.0-or-later
"""The surroundings of swinging cloth: the place of its object, and the force fields. Never imports bpy.

Blender's Python API does not give the force of a force field. So the library computes it as Blender's effect.c does. A
wind that is the same everywhere is one velocity for the whole garment. All other fields act on every vertex.
"""
from __future__ import annotations

import math
from dataclasses import astuple, dataclass
from typing import Iterable

import numpy as np

from ...native import kernels

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Field:
    """A force field, with the names of the library's struct. Lengths in Blender's units, world space."""

    kind: str  # WIND, FORCE, VORTEX, HARMONIC, DRAG, TURBULENCE
    location: Vector
    axis: Vector  # Z axis of its object, any length
    strength: float = 1.0  # WIND: m/s; negative: against its axis
    shape: str = "POINT"
    falloff: str = "SPHERE"
    side: str = "BOTH"
    damping: float = 0.0
    size: float = 0.0
    flow: float = 0.0
    noise: float = 0.0
    seed: int = 0
    power: float = 0.0
    least: float = 0.0
    most: float | None = None  # None: no end
    radial_power: float = 0.0
    radial_least: float = 0.0
    radial_most: float | None = None
    inverse_square: bool = False
    in_world: bool = False

    @property
    def acts(self) -> bool:
        """Whether it has an effect: it needs a direction, and all numbers must be finite."""
        numbers = [value for value in (*self.location, *self.axis, *astuple(self)) if isinstance(value, (int, float))]
        return any(self.axis) and all(map(math.isfinite, numbers))

    @property
    def is_uniform(self) -> bool:
        """Whether it is a wind that is the same everywhere and at all times."""
        limits = (self.power, self.noise, self.falloff != "SPHERE" and self.radial_power)
        ends = self.most is not None or (self.falloff != "SPHERE" and self.radial_most is not None)
        return self.kind == "WIND" and self.side == "BOTH" and not any(limits) and not ends

    def array(self) -> np.ndarray:
        """All its values, for digests."""
        names = (self.kind, self.shape, self.falloff, self.side)
        numbers = [-1.0 if value is None else float(value) for value in astuple(self)[3:]
                   if not isinstance(value, str)]
        return np.frombuffer("/".join(names).encode() + np.array((*self.location, *self.axis, *numbers)).tobytes(),
                             np.uint8)

    def native(self) -> kernels.ForceField:
        """As a struct of the library."""
        out = kernels.ForceField()
        for name in ("kind", "shape", "falloff", "side", "location", "axis", "strength", "damping", "size", "flow",
                     "noise", "seed", "power", "least", "radial_power", "radial_least", "inverse_square",
                     "in_world"):
            value = getattr(self, name)
            setattr(out, name, tuple(map(_bounded, value)) if isinstance(value, tuple) else
                    _bounded(value) if isinstance(value, float) else value)
        out.ends, out.radial_ends = self.most is not None, self.radial_most is not None
        out.most, out.radial_most = _bounded(self.most or 0.0), _bounded(self.radial_most or 0.0)
        return out


@dataclass(frozen=True)
class Surroundings:
    """The surroundings of a garment in one frame."""

    location: Vector = (0.0, 0.0, 0.0)  # of the object's origin, world space, Blender's units
    wind: Vector = (0.0, 0.0, 0.0)  # velocity of the air by uniform winds, world space, m/s
    fields: tuple[Field, ...] = ()  # all other fields
    frame: int = 0  # frame number, if noise changes the fields from frame to frame
    not_felt: tuple[str, ...] = ()  # names of objects with fields that do not act on cloth, for the panel

    def array(self) -> np.ndarray:
        """All its values, for digests."""
        place = np.array((self.location, self.wind), np.float64)
        if not self.fields:
            return place
        return np.concatenate([place.view(np.uint8).ravel(), np.array([self.frame], np.int64).view(np.uint8),
                               *(field.array() for field in self.fields)])

    def effects(self, positions: np.ndarray) -> kernels.FieldEffects:
        """The effects of the fields at points. positions: (p, 3) float32, world space, Blender's units."""
        return kernels.evaluate_force_fields([field.native() for field in self.fields], self.frame, positions)


def surroundings_of(location: Vector, frame: int, fields: Iterable[Field], drag: float,
                    not_felt: tuple[str, ...] = ()) -> Surroundings:
    """The surroundings of a garment at a place. drag: of the cloth's settings; if it is 0, winds have no effect."""
    fields = [field for field in fields if field.acts and not (field.kind == "WIND" and drag == 0.0)]
    others = tuple(field for field in fields if not field.is_uniform)
    return Surroundings(location, air_velocity(field for field in fields if field.is_uniform), others,
                        frame if any(field.noise > 0.0 for field in others) else 0, not_felt)


def _bounded(number: float) -> float:
    """The number, limited to what the library accepts."""
    return min(max(number, -1e9), 1e9)


def air_velocity(winds: Iterable[Field]) -> Vector:
    """The sum of uniform winds, m/s."""
    x, y, z = sum((wind.strength / math.hypot(*wind.axis) * np.array(wind.axis) for wind in winds),
                  np.zeros(3)).tolist()
    return x, y, z
