# SPDX-License-Identifier: GPL-3.0-or-later
"""The paint Keep Smooth: painted places have no folds, but follow the base cloth, if there is one. Never imports bpy.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from ..base.triangles import frames_of, on_shown, rowwise
from ..mesh.frame_result import FrameResult

SMOOTH = "smooth"  # the paint: 1: no folds, 0: as without paint


def share_of_folds(smooth: np.ndarray) -> np.ndarray:
    """(n,) float32 in 0..1: the share of folds that is left. NaN in the paint, which an attribute may have, counts as
    0."""
    return np.float32(1.0) - np.clip(np.nan_to_num(smooth, nan=0.0), 0.0, 1.0).astype(np.float32)


def move(result: FrameResult, rows: np.ndarray, displacements: np.ndarray, shown: Any, base: np.ndarray) -> None:
    """Move some vertices of a result, and update all its arrays of positions and offsets. displacements: (rows, 3)
    object space. base: (n, 3) positions that the mesh is embedded in."""
    frames = frames_of(base, shown.triangle_vertex[rows])
    result.positions = _plus(result.positions, rows, displacements)
    result.attributes["rumple_offset"] = _plus(result.offset, rows, displacements)
    result.local_offset = _plus(result.local_offset, rows, rowwise(frames, displacements))


def left_on_shown(smooth: np.ndarray, shown: Any) -> np.ndarray:
    """(n,) paint of the base's vertices -> (d,) share of the folds that is left."""
    return np.float32(1.0) - np.clip(on_shown(np.float32(1.0) - share_of_folds(smooth), shown), 0.0, 1.0)


def _plus(values: np.ndarray, rows: np.ndarray, more: np.ndarray) -> np.ndarray:
    moved = np.array(values)  # a copy: it may be a view of memory that the library owns
    moved[rows] += more
    return moved
