# SPDX-License-Identifier: GPL-3.0-or-later
"""The connected parts of a mesh in numbers: what skin, solid things and small parts are told by. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .base_mesh import BaseMesh
from .connected import border_sides, borders
from .triangles import area_vectors
from .vertices import diagonals, lengths

OPENING = 1.0 / 110.0  # radius over the diagonal of the mesh: smaller borders are of eyes, mouths and eyelets
NEAR = 0.05  # of that diagonal: what is so near lies on another part, or under it


@dataclass
class MeasuredParts:
    """Of every connected part; object units at rest."""

    whole: float  # diagonal of all faces
    diagonal: np.ndarray  # (parts,)
    area: np.ndarray  # (parts,)
    flat: np.ndarray  # (parts,) 0 to 1: length of the sum of its faces' areas, as vectors, over its area
    thick: np.ndarray  # (parts,) volume over area^1.5, its last opening closed
    closed: np.ndarray  # (parts,) bool: it has no border
    openings: list[list[np.ndarray]]  # vertices of each open border that is no eyelet


def measured(base: BaseMesh, part: np.ndarray, place: np.ndarray) -> MeasuredParts:
    """Of a mesh with faces. part, place: (n,) of the vertices, as connected.py has them. Cost: about 0.1 s for 50,000
    vertices."""
    whole, count = float(lengths(np.ptp(base.positions[base.corner_vertex], axis=0)[None])[0]), int(part.max()) + 1
    half = area_vectors(base.positions, base.triangles)
    of = part[base.triangles[:, 0]]
    area = np.bincount(of, lengths(half), count)
    closed = np.ones(count, bool)
    closed[part[border_sides(base, place)[:, 0]]] = False
    openings: list[list[np.ndarray]] = [[] for _ in range(count)]
    middle = np.zeros((count, 3))
    for border in borders(base, place):
        points = base.positions[border].astype(np.float64)
        centre = points.mean(0)
        if lengths(points - centre).mean() >= OPENING * whole:
            openings[part[border[0]]].append(border)
            middle[part[border[0]]] = centre
    volume = np.bincount(of, ((base.positions[base.triangles[:, 0]] - middle[of]) * half).sum(1) / 3.0, count)
    some = np.maximum(area, 1e-30)
    one_way = np.stack([np.bincount(of, half[:, k], count) for k in range(3)], axis=1)
    return MeasuredParts(whole, diagonals(base.positions, part, count), area, lengths(one_way) / some,
                         np.abs(volume) / some ** 1.5, closed, openings)
