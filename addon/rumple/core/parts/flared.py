# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognises garments that hang away from the body: skirts, trousers with loose legs, and sheets such as capes. Never
imports bpy."""
from __future__ import annotations

import numpy as np

from ..base.triangles import area_vectors
from ..base.vertices import lengths, places
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import border_sides, borders, lowest_connected, parts

FLARE = 1.4  # least length of the lower opening / length of the upper one
LEAST_OUTLINE = 0.75  # of a sheet: least outline^2 / outline^2 of a flat disc of the same area; a cap has 0.5
# Of trousers, relative to the height of the figure: least outline of the end of a loose leg (tight ones have 0.15 to
# 0.17, straight ones 0.22 and more); most difference between the heights of both ends; least length.
LOOSE_LEG, ONE_HEIGHT, LONG_LEGS = 0.19, 0.05, 0.35
LEAST_SHEET = 0.25  # least diagonal of a sheet / the wearer's: a mask, an eyebrow or a patch is smaller


def is_flared(base: BaseMesh, up: np.ndarray) -> bool:
    """Whether a mesh has two openings, and the lower one is much wider. Then most of it has no body below. up: (3,) in
    the mesh's space, at rest. Cost: about 10 ms for 50,000 polygons."""
    outlines, heights = _openings(base, up)
    if len(outlines) != 2:
        return False
    lower = int(heights.argmin())
    return bool(outlines[lower] > FLARE * outlines[1 - lower])


def has_loose_legs(base: BaseMesh, up: np.ndarray) -> bool:
    """Whether a mesh is long trousers, alone or with what is worn above them, whose legs stand off the body: its two
    lowest openings are at one height, and wide for its figure. False if the height of the figure is unknown. up: (3,)
    in the mesh's space, at rest. Cost: about 10 ms for 50,000 polygons."""
    outlines, heights = _openings(base, up)
    if len(outlines) < 2:
        return False
    ends = np.argsort(heights, kind="stable")[:2]
    length = float((base.positions @ np.asarray(up)).max() - heights[ends].max())
    # an unknown height is 0, and no difference is less
    return bool(outlines[ends].min() > LOOSE_LEG * base.figure and np.ptp(heights[ends]) < ONE_HEIGHT * base.figure
                and length > LONG_LEGS * base.figure)


def _openings(base: BaseMesh, up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths of the borders, and mean heights of their sides."""
    return base.once("openings", lambda: _measured_openings(base, up), np.asarray(up))


def _measured_openings(base: BaseMesh, up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    place = places(base.positions)
    first, other = border_sides(base, place).T
    label = lowest_connected(np.arange(len(place)), place[first], place[other])
    at = np.unique(label[place[first]], return_inverse=True)[1].ravel()
    ends = base.positions[first], base.positions[other]
    outlines = np.bincount(at, np.sqrt(((ends[0] - ends[1]) ** 2).sum(axis=1)))
    return outlines, np.bincount(at, sum(end @ np.asarray(up) for end in ends)) / 2.0 / np.bincount(at)


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
