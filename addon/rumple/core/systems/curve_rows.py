# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs curves into the points of a mesh whose topology never changes. Handlers may write such a mesh at any time, and
Blender's own Mesh Cache can play it.

With a capacity of n points there are 4 n rows of three numbers. Rows i, n + i, 2 n + i and 3 n + i describe point i:

    vertices of the coarse mesh, i0 i1 i2      float32 has whole numbers up to 2^24
    u, v, number of the curve
    local offset, o.x o.y o.z                  position = p0 + u (p1 - p0) + v (p2 - p0) + t o.x + b o.y + n o.z
    width, height, 1 where point i + 1 is the next one of the same curve, else 0

Never imports bpy.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..mesh.healing import Origin

ROWS = 4
LEAST_ROOM, MOST_ROOM = 1 << 10, 1 << 18


@dataclass(frozen=True)
class CurvePoints:
    """Curves that are bound to the coarse mesh, so that they move with any pose of it. c curves, p points."""

    start: np.ndarray  # (c + 1,) the first point of every curve, then p
    id: np.ndarray  # (c,)
    corners: np.ndarray  # (p, 3) vertices of the coarse mesh
    weights: np.ndarray  # (p, 2) barycentric weights of the second and the third corner
    local_offset: np.ndarray  # (p, 3) in the frame of the deformed triangle
    width: np.ndarray  # (p,) object units
    height: np.ndarray  # (p,) object units
    positions: np.ndarray  # (p, 3) object space, on the mesh as it was solved

    @classmethod
    def none(cls) -> "CurvePoints":
        """No curves, for a frame in which nothing is solved."""
        one, two, three = (np.zeros((0, count), np.float32) for count in (1, 2, 3))
        return cls(np.zeros(1, np.int32), np.zeros(0, np.int32), three, two, three, one[:, 0], one[:, 0], three)

    @classmethod
    def of(cls, riding: Any, origin: Origin | None) -> "CurvePoints":
        """riding: the native curves. origin: of the base that they are bound to."""
        corners = riding.corners if origin is None else origin.vertex[riding.corners]
        return cls(riding.start, riding.id, corners, riding.weights, riding.local_offset, riding.width, riding.height,
                   riding.positions)


def capacity_for(points: float) -> int:
    """A capacity for at least this number of points: a power of two, within bounds."""
    return int(min(max(2 ** np.ceil(np.log2(max(points, 1.0))), LEAST_ROOM), MOST_ROOM))


def rows_of(curves: CurvePoints, capacity: int) -> tuple[np.ndarray, int]:
    """(4 capacity, 3) float32, and how many curves at the end did not fit."""
    rows = np.zeros((ROWS, capacity, 3), np.float32)
    whole = int(np.searchsorted(curves.start, capacity, side="right")) - 1  # curves that fit
    starts = curves.start[:whole + 1]
    points = int(starts[-1])
    rows[0, :points] = curves.corners[:points]
    rows[1, :points, :2] = curves.weights[:points]
    rows[1, :points, 2] = np.repeat(curves.id[:whole], np.diff(starts))
    rows[2, :points] = curves.local_offset[:points]
    rows[3, :points, 0], rows[3, :points, 1] = curves.width[:points], curves.height[:points]
    rows[3, :points, 2] = 1.0
    rows[3, starts[1:] - 1, 2] = 0.0
    return rows.reshape(-1, 3), len(curves.id) - whole
