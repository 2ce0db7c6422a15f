# SPDX-License-Identifier: GPL-3.0-or-later
"""What scripts/bench measures beside truth_measures.py: the waves' length, how steady they are, what goes through what.

NumPy, but for the searches by Blender's mathutils.
"""
from __future__ import annotations

import numpy as np
from truth_measures import Cloth, bands, gradients, heights, vertex_normals

NEAR = 0.04  # metres: a body farther away does not lie under the cloth
DEEP = 0.001  # metres into the body
FLAT = 5e-5  # metres RMS


def mean_wavelength(cloth: Cloth, base: np.ndarray, fine: np.ndarray) -> float:
    """Metres, of what is shorter than 220 mm: 2 pi times the RMS of the height over that of its gradient along the
    cloth at rest, so that what is crushed in an armpit counts as the cloth that it is. A wave of one length has that
    length. nan where the detail is less than FLAT high."""
    height = heights(cloth, base, fine)
    detail = height - bands(cloth, height)[-1]
    slope = np.average((gradients(cloth, cloth.rest, detail) ** 2).sum(1), weights=cloth.rest_area)
    squared = np.average((detail[cloth.triangles] ** 2).mean(1), weights=cloth.rest_area)
    return 2.0 * np.pi * float(np.sqrt(squared / slope)) if squared > FLAT ** 2 else float("nan")


def frames_on(cloth: Cloth, base: np.ndarray) -> np.ndarray:
    """(n, 3, 3): of every vertex of the base (n, 3) a side of the cloth, across it, the normal, as columns."""
    normal = vertex_normals(base, cloth.triangles)
    beside = np.full(len(base), -1)  # a neighbour, whichever
    for a, b in ((0, 1), (1, 0)):
        beside[cloth.edges[:, a]] = cloth.edges[:, b]
    side = base[beside] - base
    side -= (side * normal).sum(1)[:, None] * normal
    side /= np.maximum(np.linalg.norm(side, axis=1), 1e-20)[:, None]
    return np.stack([side, np.cross(normal, side), normal], axis=2)


def offsets_on(cloth: Cloth, base: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """(n, 3) metres from the base to the fine surface, in the base's own turning frames."""
    base = np.asarray(base, np.float64)
    return np.einsum("nji,nj->ni", frames_on(cloth, base), np.asarray(fine, np.float64) - base)


def change(before: np.ndarray, now: np.ndarray) -> float:
    """Metres: 99th percentile over the vertices of how two frames' offsets (n, 3) differ."""
    return float(np.percentile(np.linalg.norm(now - before, axis=1), 99.0))


def through_body(cloth: Cloth, fine: np.ndarray, body: np.ndarray, body_triangles: np.ndarray) -> float:
    """Share of the cloth's area whose vertices (n, 3) lie more than DEEP in the body (m, 3): world space, metres."""
    from mathutils import Vector
    from mathutils.bvhtree import BVHTree
    tree = BVHTree.FromPolygons(body.tolist(), body_triangles.tolist())
    inside = np.zeros(len(fine))
    for vertex, point in enumerate(fine.tolist()):
        hit, normal = tree.find_nearest(point, NEAR)[:2]
        inside[vertex] = hit is not None and (Vector(point) - hit).dot(normal) < -DEEP
    return float((inside * cloth.vertex_area).sum() / cloth.vertex_area.sum())


def crossings(cloth: Cloth, fine: np.ndarray) -> int:
    """Pairs of triangles of the cloth that pass through each other and share no vertex."""
    from mathutils.bvhtree import BVHTree
    tree = BVHTree.FromPolygons(fine.tolist(), cloth.triangles.tolist())
    pairs = np.array(tree.overlap(tree), np.int64).reshape(-1, 2)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    first, second = cloth.triangles[pairs[:, 0]], cloth.triangles[pairs[:, 1]]
    return int((first[:, :, None] != second[:, None, :]).all(axis=(1, 2)).sum())
