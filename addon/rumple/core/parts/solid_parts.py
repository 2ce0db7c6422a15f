# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds solid things in a mesh of clothes that are too large to be small parts: helmets, pouches, shoes, rolls. They
are not cloth. Those that lie on cloth follow it, the others follow the animation only. Never imports bpy.
"""
from __future__ import annotations

import numpy as np

from ..base.vertices import nearest_of, sample_of, samples_of
from ..mesh.base_mesh import BaseMesh
from .measured_parts import NEAR, MeasuredParts

SOLID = 0.04  # least volume / area^1.5: a cube has 0.068, a flat pouch 0.043, a body 0.03, a padded jacket 0.008
MOST_SIZE = 0.45  # largest diagonal / the mesh's
MOST_AREA = 0.5  # largest share of the mesh's area: if more is solid, the garment itself is made of such parts
LYING = 0.4  # least share of vertices near cloth, for a part that lies on cloth
SAMPLES, OF_CLOTH = 64, 4000  # largest numbers of tested vertices of each part, and of all cloth


def find_solid(found: MeasuredParts, others: np.ndarray) -> np.ndarray:
    """(parts,) bool: parts with at most one opening and a large volume for their area. others: (parts,) bool of parts
    that are already classified."""
    openings = np.array([len(borders) for borders in found.openings])
    counts = (found.area > 0.0) & ~others
    solid = counts & (openings < 2) & (found.thick >= SOLID) & (found.diagonal <= MOST_SIZE * found.whole)
    return solid if found.area[solid].sum() <= MOST_AREA * found.area.sum() else np.zeros(len(others), bool)


def lies_on_cloth(base: BaseMesh, found: MeasuredParts, part: np.ndarray, solid: np.ndarray,
                  rigid: np.ndarray) -> np.ndarray:
    """(parts,) bool: solid parts that lie on cloth with many of their vertices, like a pouch, unlike a helmet. part:
    (n,) the part of each vertex. rigid: (parts,) bool of all parts that are not cloth."""
    lying = np.zeros(len(solid), bool)
    has_faces = np.unique(base.corner_vertex)
    cloth = sample_of(has_faces[~rigid[part[has_faces]]], OF_CLOTH)
    for number, vertices in samples_of(part, solid).items():
        distance = nearest_of(base.positions[sample_of(vertices, SAMPLES)], base.positions, cloth)[1]
        lying[number] = (distance <= NEAR * found.whole).mean() >= LYING
    return lying
