# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preview of a Wrinkle Field computed on the graphics card. Each waits for it."""
from __future__ import annotations

import numpy as np
from rumple.blender.viewport.gpu_arrays import read
from rumple.blender.viewport.preview_field import GpuField


def phases(waves: GpuField) -> np.ndarray:
    """(w,) radians."""
    return read(waves.phases, waves.vertex_count)[:, 0]


def estimated(waves: GpuField) -> tuple[np.ndarray, np.ndarray]:
    """(w, 4) wave vector and h; (w, 4) k, fullness, r."""
    return waves._waves[0].read(0), waves._waves[0].read(1)


def drawn(waves: GpuField) -> np.ndarray:
    """(w, 4) wave vector and h as they are drawn."""
    return read(waves.arrays()["waves"], waves.vertex_count)


def uv_slopes(waves: GpuField) -> tuple[np.ndarray, np.ndarray]:
    """(fans, 4) du/dx' and dv/dx'."""
    return waves._fans.read(0), waves._fans.read(1)
