# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that hang free of the body, as skirts do. Never imports bpy."""
from __future__ import annotations

import numpy as np

from .base_mesh import BaseMesh
from .connected import lowest_connected, places

FLARE = 1.4  # length of the lower opening over that of the upper one


def is_flared(base: BaseMesh, world_from_object: np.ndarray) -> bool:
    """Whether a mesh has two openings, and the lower one is far wider: there is no body below most of it.
    world_from_object: (3, 3), as it stands at rest."""
    first, other = _border_sides(base)
    label = lowest_connected(np.arange(len(base.positions)), first, other)
    openings, at = np.unique(label[first], return_inverse=True)
    if len(openings) != 2:
        return False
    ends = base.positions[first], base.positions[other]
    lengths = np.bincount(at.ravel(), np.sqrt(((ends[0] - ends[1]) ** 2).sum(axis=1)))
    height = sum(end @ np.asarray(world_from_object)[2] for end in ends)
    heights = np.bincount(at.ravel(), height) / np.bincount(at.ravel())
    lower = int(heights.argmin())
    return bool(lengths[lower] > FLARE * lengths[1 - lower])


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
