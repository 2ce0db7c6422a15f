# SPDX-License-Identifier: GPL-3.0-or-later
"""What cloth that swings meets in the world: where it stands, and the wind there. Never imports bpy.

Blender's Python tells no effector's force, so what its Wind does is done here: it blows along its axis, as fast as its
strength says, less with the distance from the garment's origin as its Falloff says. One velocity for the whole garment.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterable

import numpy as np

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Surroundings:
    """Of a garment in one frame."""

    location: Vector = (0.0, 0.0, 0.0)  # of the object's origin, world space, Blender's units
    wind: Vector = (0.0, 0.0, 0.0)  # velocity of the air, world space, m/s

    def array(self) -> np.ndarray:
        """All that it is, for digests."""
        return np.array((self.location, self.wind), np.float64)


@dataclass(frozen=True)
class Wind:
    """One that blows, as an effector of Blender's type Wind has it. Lengths in Blender's units, world space."""

    location: Vector
    axis: Vector  # along which it blows, of any length
    strength: float  # m/s where nothing is lost; below 0 it blows against its axis
    power: float = 0.0  # of the falloff, >= 0; 0: as fast everywhere
    min_distance: float | None = None  # up to which nothing is lost
    max_distance: float | None = None  # beyond which nothing is left

    def share(self, distance: float) -> float:
        """Of the strength that is left that far away, 0..1, as Blender counts it for the shape Sphere
        (falloff_func() in its effect.c)."""
        if self.max_distance is not None and distance > self.max_distance:
            return 0.0
        return (1.0 + max(distance - (self.min_distance or 0.0), 0.0)) ** -self.power

    def velocity(self, at: Vector) -> np.ndarray:
        """(3,) float64 of the air at a place, m/s. 0 for what has no axis or is not finite."""
        length = math.hypot(*self.axis)
        numbers = (*at, *self.location, length, self.strength, self.power, self.min_distance or 0.0)
        if length == 0.0 or not all(map(math.isfinite, numbers)):
            return np.zeros(3)
        return self.strength * self.share(math.dist(at, self.location)) / length * np.array(self.axis)


def air_velocity(at: Vector, winds: Iterable[Wind]) -> Vector:
    """Of all winds together at a place in the world, m/s."""
    x, y, z = sum((wind.velocity(at) for wind in winds), np.zeros(3)).tolist()
    return x, y, z
