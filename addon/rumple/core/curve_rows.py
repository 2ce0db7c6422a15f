# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves as points of a mesh that never changes its topology: what handlers may write at any time, and what Blender's
own Mesh Cache can play.

With room for n points there are 4 n rows of three numbers. Rows i, n + i, 2 n + i and 3 n + i say about point i:

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

from .healing import Origin

ROWS = 4
LEAST_ROOM, MOST_ROOM = 1 << 10, 1 << 18


@dataclass(frozen=True)
class CurvePoints:
    """Curves that ride on any pose of the coarse mesh. c curves, p points."""

    start: np.ndarray  # (c + 1,) first point of every curve, then p
    id: np.ndarray  # (c,)
    corners: np.ndarray  # (p, 3) vertices of the coarse mesh
    weights: np.ndarray  # (p, 2) of the second and the third
    local_offset: np.ndarray  # (p, 3) in the frame of the deformed triangle
    width: np.ndarray  # (p,) object units
    height: np.ndarray  # (p,) object units
    positions: np.ndarray  # (p, 3) object space, on the mesh as it was solved

    @classmethod
    def none(cls) -> "CurvePoints":
        """Of a frame in which nothing is solved."""
        one, two, three = (np.zeros((0, count), np.float32) for count in (1, 2, 3))
        return cls(np.zeros(1, np.int32), np.zeros(0, np.int32), three, two, three, one[:, 0], one[:, 0], three)

    @classmethod
    def of(cls, riding: Any, origin: Origin | None) -> "CurvePoints":
        """riding: native. origin: of the base that it rides on."""
        corners = riding.corners if origin is None else origin.vertex[riding.corners]
        return cls(riding.start, riding.id, corners, riding.weights, riding.local_offset, riding.width, riding.height,
                   riding.positions)


def capacity_for(points: float) -> int:
    """A power of two of points, for so many and some more."""
    return int(min(max(2 ** np.ceil(np.log2(max(points, 1.0))), LEAST_ROOM), MOST_ROOM))


def rows_of(curves: CurvePoints, capacity: int) -> tuple[np.ndarray, int]:
    """(4 room, 3) float32, and how many curves at the end found no room."""
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
