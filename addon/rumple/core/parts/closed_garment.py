# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognises garments whose ends are closed where other objects continue, as characters of games wear them: trousers
and jackets in an object of their own without an opening, coats that are open at the collar alone. Never imports bpy.
"""
from __future__ import annotations

import numpy as np

from ..base.vertices import places
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import parts
from .measured_parts import measured

LEAST_SIZE = 0.35  # least diagonal / height of the figure: trousers have 0.55, a boot 0.31, a hat 0.29
# Least height of the figure above it / height of the figure: the head is above a jacket. Hair is above a body by less.
LEAST_ABOVE = 0.1
# Of a garment with one opening: least height of the figure below it / height of the figure. Below a coat are feet; a
# body that is cut off at its neck ends where the figure does.
LEAST_BELOW = 0.03
LEAST_BONES, LEAST_SHARE = 2, 0.05  # it bends: so many bones each move at least this share of its vertices


def is_closed_garment(base: BaseMesh, others: np.ndarray, up: np.ndarray) -> bool:
    """Whether more than half of a mesh at rest is a part that is as large as trousers, has other objects of the figure
    above it, and has no opening, or one in its upper half and objects below it. others: (m, 3) the vertices of these
    objects, in the object space of the mesh. up: (3,) there. Cost: about 0.1 s for 50,000 vertices."""
    if not len(base.triangle_corner) or not len(others):
        return False
    place = places(base.positions)
    part = parts(base, place)
    found = measured(base, part, place)
    main = int(found.area.argmax())
    if len(found.openings[main]) > 1 or found.area[main] <= 0.5 * found.area.sum():
        return False
    own, of_others = base.positions[part == main] @ up, others @ up
    every = np.concatenate([base.positions[base.corner_vertex] @ up, of_others])
    low, high = every.min(), every.max()
    size, height = found.diagonal[main] * float(np.linalg.norm(up)), high - low
    if not (size >= LEAST_SIZE * height and of_others.max() - own.max() >= LEAST_ABOVE * height):
        return False
    return all(own.min() - low >= LEAST_BELOW * height and (base.positions[border] @ up).mean() >= own.mean()
               for border in found.openings[main])


def bends(weights: np.ndarray) -> bool:
    """Whether several bones move a mesh. weights: (n, bones) of its vertices."""
    if not weights.size:
        return False
    bone = weights.argmax(axis=1)[weights.max(axis=1) > 0.0]
    return bool((np.bincount(bone, minlength=1) >= LEAST_SHARE * len(weights)).sum() >= LEAST_BONES)
