# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting of rest-pose wrinkles on plain arrays: the path of the stroke, and the surface under it. Never imports bpy.

A painted value is a tangent vector of the rest pose, across the folds, shorter than 1; v and -v mean the same.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...native import kernels
from ..base.wording import user_error
from .wrinkle_field import WrinkleField

SPACING = 0.25  # of the brush's radius, from dab to dab
LEAST_SPACING = 8.0  # pixels: the mouse moves by whole pixels, so a shorter step has an inexact direction
DEFAULT_LENGTH = 0.7
LONGEST = kernels.LONGEST_PAINTED


@dataclass(frozen=True)
class Place:
    """One dab: its place in pixels, the unit direction of the stroke there, and the pressure (0..1)."""

    x: float
    y: float
    dx: float
    dy: float
    pressure: float


class Hand:
    """Turns the events of a stroke into places at even distances, so that the number of events does not matter."""

    def __init__(self, spacing: float) -> None:
        """spacing: pixels from place to place."""
        self.spacing = max(spacing, LEAST_SPACING)
        self._last: Place | None = None
        self._moved = False

    def press(self, x: float, y: float, pressure: float) -> Place:
        """Begin a stroke. The returned place has no direction yet. The first move() returns the same place again, with
        its direction."""
        self._last = Place(x, y, 0.0, 0.0, pressure)
        return self._last

    def move(self, x: float, y: float, pressure: float) -> list[Place]:
        """The places between the last place and this point."""
        last = self._last
        assert last is not None, "move() before press()"
        distance = math.hypot(x - last.x, y - last.y)
        count = int(distance / self.spacing)
        if count == 0:
            return []
        dx, dy = (x - last.x) / distance, (y - last.y) / distance
        places = [] if self._moved else [Place(last.x, last.y, dx, dy, last.pressure)]
        for step in range(1, count + 1):
            way = step * self.spacing
            places.append(Place(last.x + way * dx, last.y + way * dy, dx, dy,
                                last.pressure + (pressure - last.pressure) * way / distance))
        self._moved, self._last = True, places[-1]
        return places


class Easel:
    """The surface of a Wrinkle Field while it is painted on, in one pose at a time.

    Positions and all other values in space are in world space. So angles are the visible ones, whatever the object's
    scale. Painted values are (n, 3) float32, per vertex of the coarse mesh, in rest space.
    """

    def __init__(self, field: WrinkleField) -> None:
        self.field = field
        self.name = field.base.name
        self.positions: np.ndarray | None = None  # (n, 3) float32: the field's base in this pose
        self._canvas: Any = None
        self._twins: Any = None

    def triangles(self) -> np.ndarray:
        """(t, 3): the triangles, as rows of `positions`."""
        return self.field.base.triangles

    def pose(self, positions: np.ndarray) -> bool:
        """Set the pose, (n, 3). Returns whether it differs from the last one. Raises UserError."""
        positions = np.ascontiguousarray(positions, np.float32)
        if self.positions is not None and np.array_equal(positions, self.positions):
            return False
        self._canvas = self._checked(kernels.lay_out_canvas, self.field.model, positions)
        self.positions = positions
        return True

    def dab(self, painted: np.ndarray, mirror: bool, **how: Any) -> np.ndarray:
        """The painted values after one dab. how: see kernels.apply_dab. Raises UserError."""
        if mirror and self._twins is None:
            self._twins = kernels.find_twins(self.field.model)
        before = np.ascontiguousarray(self.field.base.points(painted))
        after = self._checked(kernels.apply_dab, self.field.model, self._canvas, before,
                              twins=self._twins if mirror else None, **how)
        return after[:len(painted)]  # healing may have cut the mesh: the copied vertices are at the end

    def lines(self, painted: np.ndarray, across: bool) -> tuple[np.ndarray, np.ndarray]:
        """Lines for an overlay: ends (2 m, 3) and strengths (m,). See kernels.draw_rest_wrinkles. Raises UserError."""
        return self._checked(kernels.draw_rest_wrinkles, self.field.model, self._canvas,
                             np.ascontiguousarray(self.field.base.points(painted)), across)

    def scatter(self, seed: int, density: float, size: float, length: float) -> np.ndarray:
        """Random wrinkles. size: metres. See kernels.scatter_rest_wrinkles. Raises UserError."""
        return self._checked(kernels.scatter_rest_wrinkles, self.field.model, seed, density,
                             size / self.field.unit_scale, length)[:self.field.coarse_count]

    def _checked(self, function: Any, *arguments: Any, **keywords: Any) -> Any:
        try:
            return function(*arguments, **keywords)
        except ValueError as error:
            raise user_error(self.name, error) from error
