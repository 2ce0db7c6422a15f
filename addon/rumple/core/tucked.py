# SPDX-License-Identifier: GPL-3.0-or-later
"""Hems that are tucked in: a shirt in trousers, a leg in a boot. They are held as a cuff is. Never imports bpy."""
from __future__ import annotations

import numpy as np

from .paint_maps import smoothstep
from .vertices import nearest_of, sample_of

FADE = 0.07  # of the garment's diagonal: over this distance the hold fades out, as that of a cuff (native/.../pins.cpp)
MOST = 500  # vertices that are tucked in that the others are measured from
HELD = 0.9  # of a hem that follows so firmly nothing comes out
LEAST_SHARE = 0.3  # of a border: with less it is only touched by what lies over it


def held(follow: np.ndarray, positions: np.ndarray, tucked: np.ndarray, diagonal: float) -> np.ndarray:
    """(n,) float32: how firmly each vertex follows the animation, 1 where it is tucked in. follow: (n,), before.
    positions: (n, 3) at rest; tucked: vertices, at least one. diagonal: of the cloth. Cost: 5 us for each vertex near
    them."""
    fade = FADE * diagonal
    low, high = positions[tucked].min(axis=0) - fade, positions[tucked].max(axis=0) + fade
    near = np.flatnonzero(((positions >= low) & (positions <= high)).all(axis=1))
    share = np.zeros(len(positions))
    share[near] = 1.0 - nearest_of(positions[near], positions, sample_of(tucked, MOST))[1] / max(fade, 1e-30)
    share[tucked] = 1.0
    return np.maximum(follow, smoothstep(share)).astype(np.float32)
