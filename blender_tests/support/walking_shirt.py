# SPDX-License-Identifier: GPL-3.0-or-later
"""The walking shirt of the real scenes as plain arrays, for tests of the graphics card against the library."""
from __future__ import annotations

import os
import unittest
from pathlib import Path
from typing import Any

import numpy as np
import rumple_native as native


def surface_and_frames() -> tuple[Any, np.ndarray]:
    """(surface at rest, (f, n, 3) positions of all frames). Skips the test where the real scenes are not here."""
    path = Path(os.environ["RUMPLE_DATA"]) / "S1_walk_shirt.npz"
    if not path.exists():
        raise unittest.SkipTest("the real scenes are not here")
    clip = np.load(path)
    starts = np.append(clip["poly_start"], len(clip["poly_verts"])).astype(np.int32)
    surface = native.build_surface(clip["rest"], starts, clip["poly_verts"].astype(np.int32),
                                   clip["tri_loops"].astype(np.int32))
    return surface, clip["frames"]
