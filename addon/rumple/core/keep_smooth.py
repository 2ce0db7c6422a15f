# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep Smooth: where it is painted, the bare surface is shown, of the base cloth where there is one. Never imports bpy.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from .frame_result import FrameResult

SMOOTH = "smooth"  # the paint: 1 where no fold may be, 0 as if nothing were painted


def share_of_folds(smooth: np.ndarray) -> np.ndarray:
    """(n,) float32 in 0..1: how much of the folds is left. An attribute may hold anything: what is no number is 0."""
    return np.float32(1.0) - np.clip(np.nan_to_num(smooth, nan=0.0), 0.0, 1.0).astype(np.float32)


def on_shown(values: np.ndarray, shown: Any) -> np.ndarray:
    """(n,) values of the base's vertices -> (d,) of a native shown mesh that is embedded in it."""
    weight_1, weight_2 = shown.barycentric[:, 0], shown.barycentric[:, 1]
    corner_0, corner_1, corner_2 = (values[shown.triangle_vertex[:, k]] for k in range(3))
    return (np.float32(1.0) - weight_1 - weight_2) * corner_0 + weight_1 * corner_1 + weight_2 * corner_2


def move(result: FrameResult, rows: np.ndarray, ways: np.ndarray, shown: Any, base: np.ndarray) -> None:
    """Move some vertices of a result, with all that says where they are. ways: (rows, 3) object space. base: (n, 3)
    positions that the mesh is embedded in."""
    result.positions = _plus(result.positions, rows, ways)
    result.attributes["rumple_offset"] = _plus(result.offset, rows, ways)
    result.local_offset = _plus(result.local_offset, rows, _in_triangles(ways, base[shown.triangle_vertex[rows]]))


def left_on_shown(smooth: np.ndarray, shown: Any) -> np.ndarray:
    """(n,) paint of the base's vertices -> (d,) share of the folds that is left."""
    return np.float32(1.0) - np.clip(on_shown(np.float32(1.0) - share_of_folds(smooth), shown), 0.0, 1.0)


def _plus(values: np.ndarray, rows: np.ndarray, more: np.ndarray) -> np.ndarray:
    moved = np.array(values)  # it may be a view of what the library holds
    moved[rows] += more
    return moved


def _in_triangles(ways: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(m, 3) object space -> the frame of the triangle (m, 3, 3) that each is embedded in, as the node group has it.
    """
    side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    tangent, normal = unit(side), unit(cross(side, other))
    axes = (tangent, cross(normal, tangent), normal)
    return np.stack([np.einsum("ij,ij->i", axis, ways) for axis in axes], axis=1).astype(np.float32)


def cross(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Row by row, many times as fast as NumPy's."""
    turns = ((1, 2), (2, 0), (0, 1))
    return np.stack([one[:, j] * two[:, k] - one[:, k] * two[:, j] for j, k in turns], axis=1)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Of length 1; zero stays zero."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))[:, None]
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0.0)
