# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a mesh hangs together. Never imports bpy."""
from __future__ import annotations

import numpy as np

from .base_mesh import BaseMesh
from .vertices import pair_keys


def spokes(base: BaseMesh) -> tuple[np.ndarray, np.ndarray]:
    """(c,) and (c,) vertices: the first one of every polygon, and each of its corners."""
    return (base.corner_vertex[np.repeat(base.polygon_start[:-1], np.diff(base.polygon_start))], base.corner_vertex)


def lowest_connected(label: np.ndarray, first: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(n,) the lowest number of all that each is connected with. label: (n,) arange. first, other: (k,) pairs.

    Shiloach and Vishkin 1982: trees whose roots are their lowest numbers; of two that a pair joins the higher root goes
    below the lower one (below which, where several pairs ask, does not matter), and all then stand below their roots.
    In every round the pairs are turned round: else a star whose middle has the highest number takes a round for each of
    its ends.
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
    """(n,) int32: for every vertex the number of its connected part, counted from 0; loose vertices have their own.
    place: as places() has them; (n,) arange: what is at one place is not one."""
    first, other = spokes(base)
    label = lowest_connected(np.arange(len(base.positions)), place[first], place[other])
    return np.unique(label[place], return_inverse=True)[1].ravel().astype(np.int32)


def border_sides(base: BaseMesh, place: np.ndarray) -> np.ndarray:
    """(k, 2) int32: the vertices of the sides that one polygon has. place: as places() has them."""
    sides = base.sides()
    _, first, uses = np.unique(pair_keys(place[sides], len(place)), return_index=True, return_counts=True)
    return sides[first[uses == 1]]


def borders(base: BaseMesh, place: np.ndarray) -> list[np.ndarray]:
    """The vertices of every open border, ascending. place: as places() has them."""
    border = border_sides(base, place)
    if not len(border):
        return []
    loop = lowest_connected(np.arange(int(place.max()) + 1), place[border[:, 0]], place[border[:, 1]])
    vertices = np.unique(border)
    of = loop[place[vertices]]
    order = np.argsort(of, kind="stable")
    return np.split(vertices[order], np.flatnonzero(np.diff(of[order])) + 1)
