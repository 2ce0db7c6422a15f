# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that hang free of the body: skirts, and sheets as capes are. Never imports bpy."""
from __future__ import annotations

import numpy as np

from .base_mesh import BaseMesh
from .connected import lowest_connected, parts
from .vertices import places

FLARE = 1.4  # length of the lower opening over that of the upper one
LEAST_OUTLINE = 0.75  # of a sheet: its outline squared over that of a flat disc of its area; a cap has a half
LEAST_SHEET = 0.25  # of the wearer's diagonal: a mask, an eyebrow or a patch is smaller


def is_flared(base: BaseMesh, up: np.ndarray) -> bool:
    """Whether a mesh has two openings, and the lower one is far wider: there is no body below most of it. up: (3,) in
    its space, at rest. Cost: about 10 ms for 50,000 polygons."""
    first, other = _border_sides(base)
    label = lowest_connected(np.arange(len(base.positions)), first, other)
    openings, at = np.unique(label[first], return_inverse=True)
    if len(openings) != 2:
        return False
    ends = base.positions[first], base.positions[other]
    lengths = np.bincount(at.ravel(), np.sqrt(((ends[0] - ends[1]) ** 2).sum(axis=1)))
    height = sum(end @ np.asarray(up) for end in ends)
    heights = np.bincount(at.ravel(), height) / np.bincount(at.ravel())
    lower = int(heights.argmin())
    return bool(lengths[lower] > FLARE * lengths[1 - lower])


def is_sheet(base: BaseMesh, wearer: np.ndarray) -> bool:
    """Whether more than half of a mesh is one part with one border, an outline: a cape or a scarf is, and no glove, no
    hat, no head, no cards of hair. wearer: (m, 3) positions, in the object's space."""
    place = places(base.positions)
    part = parts(base, place)
    corners = base.positions[base.triangles].astype(np.float64)
    areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    area = np.bincount(part[base.triangles[:, 0]], areas)
    main = int(area.argmax()) if len(area) else -1
    if main < 0 or area[main] <= 0.5 * area.sum():
        return False
    first, other = (ends[part[ends] == main] for ends in _border_sides(base))
    if not len(first) or len(np.unique(lowest_connected(np.arange(len(place)), first, other)[first])) != 1:
        return False
    outline = float(np.linalg.norm(base.positions[first] - base.positions[other], axis=1).sum())
    size, least = (np.linalg.norm(np.ptp(points, axis=0)) for points in (base.positions[part == main], wearer))
    return bool(outline**2 >= LEAST_OUTLINE * 4.0 * np.pi * area[main] and size >= LEAST_SHEET * least)


def _border_sides(base: BaseMesh) -> tuple[np.ndarray, np.ndarray]:
    """(k,) and (k,) vertices: the ends of the edges that one polygon has, where seams are joined."""
    following = np.arange(1, len(base.corner_vertex) + 1)
    following[base.polygon_start[1:] - 1] = base.polygon_start[:-1]
    place = places(base.positions)
    of_place = np.zeros(len(place), np.int64)
    of_place[place[::-1]] = np.arange(len(place))[::-1]  # the lowest of those at one place
    ends = of_place[place[base.corner_vertex]], of_place[place[base.corner_vertex[following]]]
    key = np.minimum(*ends) * np.int64(len(place)) + np.maximum(*ends)
    once, uses = np.unique(key, return_counts=True)
    once = once[uses == 1]
    return once // len(place), once % len(place)
