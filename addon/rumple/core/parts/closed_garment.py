# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognises garments without an opening, as characters of games wear them: trousers and jackets in an object of their
own whose ends are closed where other objects continue. Never imports bpy."""
from __future__ import annotations

import numpy as np

from ..base.vertices import places
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import parts
from .measured_parts import measured

LEAST_SIZE = 0.35  # least diagonal / height of the figure: trousers have 0.55, a boot 0.31, a hat 0.29
# Least height of the figure above it / height of the figure: the head is above a jacket. Hair is above a body by less.
LEAST_ABOVE = 0.1
LEAST_BONES, LEAST_SHARE = 2, 0.05  # it bends: so many bones each move at least this share of its vertices


def is_closed_garment(base: BaseMesh, others: np.ndarray, up: np.ndarray) -> bool:
    """Whether more than half of a mesh at rest is a part without an opening that is as large as trousers and has other
    objects of the figure above it. others: (m, 3) the vertices of these objects, in the object space of the mesh. up:
    (3,) there. Cost: about 0.1 s for 50,000 vertices."""
    if not len(base.triangle_corner) or not len(others):
        return False
    place = places(base.positions)
    part = parts(base, place)
    found = measured(base, part, place)
    main = int(found.area.argmax())
    if found.openings[main] or found.area[main] <= 0.5 * found.area.sum():
        return False
    own, of_others = base.positions[part == main] @ up, others @ up
    height = max(own.max(), of_others.max()) - min(own.min(), of_others.min())
    size = found.diagonal[main] * float(np.linalg.norm(up))
    return bool(size >= LEAST_SIZE * height and of_others.max() - own.max() >= LEAST_ABOVE * height)


def bends(weights: np.ndarray) -> bool:
    """Whether several bones move a mesh. weights: (n, bones) of its vertices."""
    if not weights.size:
        return False
    bone = weights.argmax(axis=1)[weights.max(axis=1) > 0.0]
    return bool((np.bincount(bone, minlength=1) >= LEAST_SHARE * len(weights)).sum() >= LEAST_BONES)
