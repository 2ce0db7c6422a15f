# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes made with NumPy for the tests without Blender."""
from __future__ import annotations

import numpy as np

from rumple.core.frame.engine import BaseMesh


def sheet(columns: int, rows: int, size: float = 1.0) -> BaseMesh:
    """A flat sheet of columns x rows quads in the xy plane, size metres wide."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    positions = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3) * (size / columns)
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    quads = np.stack([first, first + 1, first + columns + 2, first + columns + 1], 1)
    return quad_mesh("Sheet", positions, quads)


def tube(around: int, along: int, radius: float = 0.05, length: float = 0.3) -> BaseMesh:
    """An open tube along z, its normals outward."""
    angle = 2 * np.pi * np.arange(around) / around
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
    positions = np.concatenate([np.c_[ring, np.full(around, length * k / along)] for k in range(along + 1)])
    a = (np.arange(along)[:, None] * around + np.arange(around)).ravel()
    b = (np.arange(along)[:, None] * around + (np.arange(around) + 1) % around).ravel()
    return quad_mesh("Tube", positions, np.stack([a, b, b + around, a + around], 1))


def thick_tube(around: int, along: int, radius: float, length: float, thickness: float) -> BaseMesh:
    """A tube along z, and another one in it, turned, joined at both ends. The vertices of the outer one come first."""
    outer = tube(around, along, radius, length)
    inner = outer.positions * np.array(((radius - thickness) / radius,) * 2 + (1.0,))
    quads, count = outer.corner_vertex.reshape(-1, 4), len(outer.positions)
    first = np.arange(around)
    following, last = np.roll(first, -1), count - around
    rims = (np.stack([following, first, first + count, following + count], 1),
            np.stack([first + last, following + last, following + last + count, first + last + count], 1))
    return quad_mesh("Thick Tube", np.concatenate([outer.positions, inner]),
                     np.concatenate([quads, quads[:, ::-1] + count, *rims]))


def quad_mesh(name: str, positions: np.ndarray, quads: np.ndarray) -> BaseMesh:
    """A mesh of quads, each cut along its first diagonal."""
    corner = 4 * np.arange(len(quads))[:, None]
    triangles = np.concatenate([corner + [0, 1, 2], corner + [0, 2, 3]], 1).reshape(-1, 3)
    return BaseMesh(name, np.ascontiguousarray(positions, np.float32),
                    np.arange(0, 4 * len(quads) + 1, 4, dtype=np.int32),
                    np.ascontiguousarray(quads.ravel(), np.int32), np.ascontiguousarray(triangles, np.int32))


def compressed(positions: np.ndarray, factor: float, axis: int = 2) -> np.ndarray:
    """The positions squeezed along one axis."""
    out = positions.copy()
    out[:, axis] *= factor
    return out


def rotated(positions: np.ndarray, degrees: float) -> np.ndarray:
    """The positions turned about an oblique axis, and moved."""
    angle = np.radians(degrees)
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    cross = np.cross(np.eye(3), -axis)
    matrix = np.eye(3) * np.cos(angle) + np.sin(angle) * cross + (1 - np.cos(angle)) * np.outer(axis, axis)
    return np.ascontiguousarray(positions @ matrix.T + [0.3, -0.2, 0.1], np.float32)
