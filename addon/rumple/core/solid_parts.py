# SPDX-License-Identifier: GPL-3.0-or-later
"""Solid things in the mesh of clothes that are too large for small parts: helmets, pouches, shoes, rolls. They are no
cloth: those that lie on cloth ride on it, the others stay where they are animated. Never imports bpy.
"""
from __future__ import annotations

import numpy as np

from .base_mesh import BaseMesh
from .measured_parts import NEAR, MeasuredParts
from .vertices import nearest_of, sample_of, samples_of

SOLID = 0.04  # least volume over area^1.5: a cube has 0.068, a flat pouch 0.043, a body 0.03, a padded jacket 0.008
MOST_SIZE = 0.45  # of the diagonal of the mesh
MOST_AREA = 0.5  # of the mesh: where more of it is solid, that is what it is made of
LYING = 0.4  # of the vertices of what lies on cloth: they are near to it
SAMPLES, OF_CLOTH = 64, 4000  # vertices at most of each part, and of all cloth, that are looked at


def find_solid(found: MeasuredParts, others: np.ndarray) -> np.ndarray:
    """(parts,) bool: closed parts, and those with one opening, that hold much for their surface. others: (parts,) bool
    of those that are something else already."""
    openings = np.array([len(borders) for borders in found.openings])
    counts = (found.area > 0.0) & ~others
    solid = counts & (openings < 2) & (found.thick >= SOLID) & (found.diagonal <= MOST_SIZE * found.whole)
    return solid if found.area[solid].sum() <= MOST_AREA * found.area.sum() else np.zeros(len(others), bool)


def lies_on_cloth(base: BaseMesh, found: MeasuredParts, part: np.ndarray, solid: np.ndarray,
                  rigid: np.ndarray) -> np.ndarray:
    """(parts,) bool: the solid ones that many of their vertices lie on cloth with, as a pouch does, and no helmet.
    part: (n,) of the vertices. rigid: (parts,) bool of all that is no cloth."""
    lying = np.zeros(len(solid), bool)
    has_faces = np.unique(base.corner_vertex)
    cloth = sample_of(has_faces[~rigid[part[has_faces]]], OF_CLOTH)
    for number, vertices in samples_of(part, solid).items():
        distance = nearest_of(base.positions[sample_of(vertices, SAMPLES)], base.positions, cloth)[1]
        lying[number] = (distance <= NEAR * found.whole).mean() >= LYING
    return lying
