# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the connected parts of a mesh, so that skin, solid things and small parts can be recognised. Never imports
bpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.triangles import area_vectors
from ..base.vertices import diagonals, lengths
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import border_sides, borders

OPENING = 1.0 / 110.0  # radius of a border / diagonal of the mesh: smaller borders belong to eyes, mouths and eyelets
NEAR = 0.05  # distance / this diagonal: a nearer part lies on another part, or under it


@dataclass
class MeasuredParts:
    """Measures of every connected part; object units at rest."""

    whole: float  # diagonal of all faces
    diagonal: np.ndarray  # (parts,)
    area: np.ndarray  # (parts,)
    flat: np.ndarray  # (parts,) 0 to 1: length of the sum of its faces' area vectors / its area
    thick: np.ndarray  # (parts,) volume / area^1.5, with its last opening closed
    closed: np.ndarray  # (parts,) bool: it has no border
    openings: list[list[np.ndarray]]  # vertices of each open border that is not an eyelet


def measured(base: BaseMesh, part: np.ndarray, place: np.ndarray) -> MeasuredParts:
    """The measures of a mesh with faces. part, place: (n,) of the vertices, see connected.py. Cost: about 0.1 s for
    50,000 vertices."""
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
