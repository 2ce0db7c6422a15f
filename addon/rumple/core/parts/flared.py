# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognises garments that hang away from the body: skirts, and sheets such as capes. Never imports bpy."""
from __future__ import annotations

import numpy as np

from ..base.triangles import area_vectors
from ..base.vertices import lengths, places
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import border_sides, borders, lowest_connected, parts

FLARE = 1.4  # least length of the lower opening / length of the upper one
LEAST_OUTLINE = 0.75  # of a sheet: least outline^2 / outline^2 of a flat disc of the same area; a cap has 0.5
LEAST_SHEET = 0.25  # least diagonal of a sheet / the wearer's: a mask, an eyebrow or a patch is smaller


def is_flared(base: BaseMesh, up: np.ndarray) -> bool:
    """Whether a mesh has two openings, and the lower one is much wider. Then most of it has no body below. up: (3,) in
    the mesh's space, at rest. Cost: about 10 ms for 50,000 polygons."""
    place = places(base.positions)
    first, other = border_sides(base, place).T
    label = lowest_connected(np.arange(len(place)), place[first], place[other])
    openings, at = np.unique(label[place[first]], return_inverse=True)
    if len(openings) != 2:
        return False
    ends = base.positions[first], base.positions[other]
    outlines = np.bincount(at.ravel(), np.sqrt(((ends[0] - ends[1]) ** 2).sum(axis=1)))
    height = sum(end @ np.asarray(up) for end in ends)
    heights = np.bincount(at.ravel(), height) / np.bincount(at.ravel())
    lower = int(heights.argmin())
    return bool(outlines[lower] > FLARE * outlines[1 - lower])


def is_sheet(base: BaseMesh, wearer: np.ndarray) -> bool:
    """Whether more than half of a mesh is one part with a single border, its outline. This is true for a cape or a
    scarf, not for a glove, a hat, a head or hair cards. wearer: (m, 3) positions, in the object's space."""
    place = places(base.positions)
    part = parts(base, place)
    area = np.bincount(part[base.triangles[:, 0]], lengths(area_vectors(base.positions, base.triangles)))
    main = int(area.argmax()) if len(area) else -1
    if main < 0 or area[main] <= 0.5 * area.sum():
        return False
    sides = border_sides(base, place)
    first, other = sides[part[sides[:, 0]] == main].T
    if sum(part[border[0]] == main for border in borders(base, place)) != 1:
        return False
    outline = float(np.linalg.norm(base.positions[first] - base.positions[other], axis=1).sum())
    size, least = (np.linalg.norm(np.ptp(points, axis=0)) for points in (base.positions[part == main], wearer))
    return bool(outline**2 >= LEAST_OUTLINE * 4.0 * np.pi * area[main] and size >= LEAST_SHEET * least)
