# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices are at one place, which are near, and some that stand for many. Never imports bpy."""
from __future__ import annotations

import numpy as np

PAIRS_AT_ONCE = 200_000  # of points and triangles, or vertices, that are held in memory
MOST = 2000  # vertices of a part that stand for it


def places(positions: np.ndarray) -> np.ndarray:
    """(n,) a number for each of (n, 3) vertices, the same for those at one place."""
    found = np.arange(len(positions))
    if len(found):
        order = np.lexsort(positions.T)
        moved = (np.diff(positions[order], axis=0) != 0.0).any(1)
        found[order] = np.concatenate([[0], np.cumsum(moved)])
    return found


def nearest_of(points: np.ndarray, positions: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each point (k, 3) the nearest of some vertices of positions (n, 3), at least one, the lowest of several; and
    how far away it is, float64. Cost: 10 ns for each pair."""
    rows, distances, places = [], [], positions[others]
    for some in np.array_split(points.astype(np.float64), len(points) * len(others) // PAIRS_AT_ONCE + 1):
        x, y, z = (some[:, k, None] - places[:, k] for k in range(3))  # a third of the time of differences in rows
        squared = x * x + y * y + z * z
        rows.append(squared.argmin(1))
        distances.append(np.sqrt(squared.min(1)))
    return others[np.concatenate(rows)], np.concatenate(distances)


def pair_keys(pairs: np.ndarray, count: int) -> np.ndarray:
    """(k,) int64: one number for each unordered pair, (k, 2), of `count` vertices, edges above all; they rise with the
    lower vertex, then with the higher one."""
    ordered = np.sort(pairs.astype(np.int64), axis=1)
    return ordered[:, 0] * count + ordered[:, 1]


def diagonals(points: np.ndarray, part: np.ndarray, count: int) -> np.ndarray:
    """(count,) float64: of the boxes around `count` parts of points (n, 3). part: (n,) numbers. Of a part without a
    point: infinite."""
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, part, points)
    np.maximum.at(high, part, points)
    return lengths(high - low)


def samples_of(part: np.ndarray, chosen: np.ndarray) -> dict[int, np.ndarray]:
    """Vertices of each of the chosen parts, by its number."""
    order = np.flatnonzero(chosen[part])
    order = order[np.argsort(part[order], kind="stable")]
    numbers, first = np.unique(part[order], return_index=True)
    return {int(number): sample_of(own, MOST) for number, own in zip(numbers, np.split(order, first[1:]))}


def sample_of(vertices: np.ndarray, most: int) -> np.ndarray:
    """At most so many of the rows, evenly spread from the first to the last."""
    return vertices[np.linspace(0, len(vertices) - 1, min(most, len(vertices))).astype(int)]


def lengths(vectors: np.ndarray) -> np.ndarray:
    """(...) float64 of (..., 3)."""
    return np.sqrt((vectors.astype(np.float64) ** 2).sum(-1))
