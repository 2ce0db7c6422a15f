# SPDX-License-Identifier: GPL-3.0-or-later
"""Connected parts and open borders of a mesh. Never imports bpy."""
from __future__ import annotations

import numpy as np

from ..base.vertices import pair_keys
from .base_mesh import BaseMesh


def spokes(base: BaseMesh) -> tuple[np.ndarray, np.ndarray]:
    """(c,) and (c,) vertices: for each corner the first vertex of its polygon, and its own vertex."""
    return (base.corner_vertex[np.repeat(base.polygon_start[:-1], np.diff(base.polygon_start))], base.corner_vertex)


def lowest_connected(label: np.ndarray, first: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(n,) for each element the lowest number in its connected set. label: (n,) arange. first, other: (k,) pairs.

    The method of Shiloach and Vishkin 1982. Each set is a tree whose root is its lowest number. If a pair connects two
    trees, the higher root becomes a child of the lower one. If several pairs have the same higher root, any of them may
    win. Then every element is attached directly to its root. The pairs are swapped in every round. Without that, a star
    whose centre has the highest number would take one round for each of its ends.
    """
    label = label.copy()
    while True:
        first, other = label[first], label[other]
        apart = first != other
        if not apart.any():
            return label
        first, other = first[apart][::-1], other[apart][::-1]
        label[np.maximum(first, other)] = np.minimum(first, other)
        while (label[label] != label).any():
            label = label[label]


def parts(base: BaseMesh, place: np.ndarray) -> np.ndarray:
    """(n,) int32: for every vertex the number of its connected part, counted from 0. A loose vertex is a part of its
    own. place: see places(); (n,) arange: vertices at the same place are not connected."""
    first, other = spokes(base)
    label = lowest_connected(np.arange(len(base.positions)), place[first], place[other])
    return np.unique(label[place], return_inverse=True)[1].ravel().astype(np.int32)


def border_sides(base: BaseMesh, place: np.ndarray) -> np.ndarray:
    """(k, 2) int32: the vertices of the sides that belong to only one polygon. place: see places()."""
    sides = base.sides()
    _, first, uses = np.unique(pair_keys(place[sides], len(place)), return_index=True, return_counts=True)
    return sides[first[uses == 1]]


def borders(base: BaseMesh, place: np.ndarray) -> list[np.ndarray]:
    """The vertices of every open border, ascending. place: see places()."""
    border = border_sides(base, place)
    if not len(border):
        return []
    loop = lowest_connected(np.arange(int(place.max()) + 1), place[border[:, 0]], place[border[:, 1]])
    vertices = np.unique(border)
    of = loop[place[vertices]]
    order = np.argsort(of, kind="stable")
    return np.split(vertices[order], np.flatnonzero(np.diff(of[order])) + 1)
