# SPDX-License-Identifier: GPL-3.0-or-later
"""Searches on vertices: equal places, nearest vertices, samples of many. Never imports bpy."""
from __future__ import annotations

import numpy as np

PAIRS_AT_ONCE = 200_000  # pairs of points and triangles, or of vertices, that are in memory at once
MOST = 2000  # largest sample of a part's vertices


def places(positions: np.ndarray) -> np.ndarray:
    """(n,) a number for each of (n, 3) vertices. Vertices at the same place have the same number."""
    found = np.arange(len(positions))
    if len(found):
        order = np.lexsort(positions.T)
        moved = (np.diff(positions[order], axis=0) != 0.0).any(1)
        found[order] = np.concatenate([[0], np.cumsum(moved)])
    return found


def nearest_of(points: np.ndarray, positions: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each point (k, 3) the nearest one of the vertices `others` of positions (n, 3), and its distance, float64. Of
    several nearest ones, the first. There must be at least one. Cost: 10 ns for each pair."""
    rows, distances, places = [], [], positions[others]
    for some in np.array_split(points.astype(np.float64), len(points) * len(others) // PAIRS_AT_ONCE + 1):
        # takes a third of the time of row-wise differences
        x, y, z = (some[:, k, None] - places[:, k] for k in range(3))
        squared = x * x + y * y + z * z
        rows.append(squared.argmin(1))
        distances.append(np.sqrt(squared.min(1)))
    return others[np.concatenate(rows)], np.concatenate(distances)


def pair_keys(pairs: np.ndarray, count: int) -> np.ndarray:
    """(k,) int64: a number for each unordered pair, (k, 2), of `count` vertices, for example edges. The order is by the
    lower vertex, then by the higher one."""
    ordered = np.sort(pairs.astype(np.int64), axis=1)
    return ordered[:, 0] * count + ordered[:, 1]


def diagonals(points: np.ndarray, part: np.ndarray, count: int) -> np.ndarray:
    """(count,) float64: diagonals of the bounding boxes of `count` parts of points (n, 3). part: (n,) numbers. A part
    without points has infinity."""
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
    """At most `most` of the rows, evenly spread from the first to the last."""
    return vertices[np.linspace(0, len(vertices) - 1, min(most, len(vertices))).astype(int)]


def lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths (...), float64, of vectors (..., 3)."""
    return np.sqrt((vectors.astype(np.float64) ** 2).sum(-1))
