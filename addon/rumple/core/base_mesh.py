# SPDX-License-Identifier: GPL-3.0-or-later
"""A coarse mesh at rest, checked. Never imports bpy."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..native import kernels


class UserError(ValueError):
    """Bad input, in a sentence for the artist that names the object and the first bad element."""


@dataclass
class BaseMesh:
    """A polygon mesh at rest, object space. float32 and int32, C-contiguous."""

    name: str
    positions: np.ndarray  # (n, 3) float32
    polygon_start: np.ndarray  # (p + 1,) int32
    corner_vertex: np.ndarray  # (c,) int32
    triangle_corner: np.ndarray  # (t, 3) int32, corner indices
    uv: np.ndarray | None = None  # (c, 2) float32 of the UV map that renders use

    def surface(self, weld: bool) -> kernels.Surface:
        """The checked native surface. Raises UserError."""
        try:
            return kernels.build_surface(self.positions, self.polygon_start, self.corner_vertex,
                                         self.triangle_corner, weld)
        except ValueError as error:
            raise UserError(f"{self.name}: {error}") from error

    def mean_edge(self) -> float:
        """Mean length of the polygons' sides, object units."""
        following = np.arange(1, len(self.corner_vertex) + 1)
        following[self.polygon_start[1:] - 1] = self.polygon_start[:-1]
        sides = self.positions[self.corner_vertex[following]] - self.positions[self.corner_vertex]
        return float(np.linalg.norm(sides, axis=1).mean()) if len(sides) else 0.0

    def diagonal(self) -> float:
        """Of the bounding box, object units."""
        return float(np.linalg.norm(np.ptp(self.positions, axis=0))) if len(self.positions) else 0.0


def checked_surface(base: BaseMesh, weld: bool, unit_scale: float) -> tuple[kernels.Surface, list[str]]:
    """The native surface of a base and its warnings. unit_scale: metres per object unit. Raises UserError."""
    if not math.isfinite(unit_scale) or unit_scale <= 0.0:
        raise UserError(f"{base.name}: its scale is zero, so lengths in metres have no meaning")
    surface = base.surface(weld)
    return surface, [f"{base.name}: {warning}" for warning in surface.warnings]
