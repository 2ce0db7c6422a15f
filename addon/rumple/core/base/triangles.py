# SPDX-License-Identifier: GPL-3.0-or-later
"""Normals and frames of triangles, and interpolation in them, row by row in NumPy. Never imports bpy."""
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .vertices import pair_keys


def cross(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """(m, 3): the same bits as numpy.cross, in less time."""
    turns = ((1, 2), (2, 0), (0, 1))
    return np.stack([one[:, j] * two[:, k] - one[:, k] * two[:, j] for j, k in turns], axis=1)


def unit(vectors: np.ndarray) -> np.ndarray:
    """(m, 3) of length 1; zero stays zero."""
    x, y, z = (vectors[:, k] for k in range(3))
    lengths = np.sqrt(x * x + y * y + z * z)[:, None]  # not einsum: its order of additions depends on the processor
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0)


def area_vectors(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(t, 3) float64: normals of the triangles (t, 3), with the area as length."""
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    return 0.5 * cross(b - a, c - a)


def vertex_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(n, 3) float64: the sums of the area vectors of the triangles around each vertex."""
    normals = np.zeros((len(positions), 3))
    np.add.at(normals, triangles, area_vectors(positions, triangles)[:, None])
    return normals


def at_border(triangles: np.ndarray) -> np.ndarray:
    """(t,) bool: whether a corner of the triangle is on an open border. triangles: (t, 3)."""
    sides, count = np.concatenate([triangles[:, (k, (k + 1) % 3)] for k in range(3)]), int(triangles.max(initial=0)) + 1
    edges, uses = np.unique(pair_keys(sides, count), return_counts=True)
    border = np.zeros(count, bool)
    border[edges[uses == 1] // count] = border[edges[uses == 1] % count] = True
    return border[triangles].any(axis=1)


# ---------------------------------------------------------------- frames
def frames_of(positions: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(m, 3, 3) float32: rows t, b, n of triangles, as in the node tree; zeros if a triangle has no area. positions:
    (n, 3) float32; corners: (m, 3) of them."""
    origin = positions[corners[:, 0]]
    side = positions[corners[:, 1]] - origin
    t, n = unit(side), unit(cross(side, positions[corners[:, 2]] - origin))
    return np.stack([t, cross(n, t), n], 1)


def rowwise(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(m, 3): M x. Not with `@`: its bits depend on the processor."""
    return (matrices * vectors[:, None, :]).sum(2)


def columnwise(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(m, 3): the transposed M times x."""
    return (matrices * vectors[:, :, None]).sum(1)


# ---------------------------------------------------------------- embedded values
def corner_weights(mesh: Any) -> np.ndarray:
    """(d, 3) float32: weights of the three base vertices that each vertex of a shown mesh is embedded in. mesh: native,
    or a ShownMesh."""
    others = mesh.barycentric
    return np.concatenate([1.0 - others.sum(1, keepdims=True), others], 1)


class Embedding(NamedTuple):
    """How some vertices of a shown mesh are embedded in the base: as on a native mesh or a ShownMesh."""

    triangle_vertex: np.ndarray  # (d, 3) int32
    barycentric: np.ndarray  # (d, 2) float32


def on_shown(values: np.ndarray, mesh: Any) -> np.ndarray:
    """(n, ...) float32 values of the base's vertices -> (d, ...) of a shown mesh. mesh: native, a ShownMesh,
    or an Embedding."""
    # Not with corner_weights(), which rounds differently: stored and shown values must keep their bits.
    weight_1, weight_2 = (mesh.barycentric[:, k].reshape(-1, *[1] * (values.ndim - 1)) for k in (0, 1))
    corner_0, corner_1, corner_2 = (values[mesh.triangle_vertex[:, k]] for k in range(3))
    return (np.float32(1.0) - weight_1 - weight_2) * corner_0 + weight_1 * corner_1 + weight_2 * corner_2
