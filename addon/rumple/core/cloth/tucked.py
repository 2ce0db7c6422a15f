# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds hems that are tucked in, like a shirt in trousers or a trouser leg in a boot, as firmly as a cuff. Never
imports bpy."""
from __future__ import annotations

import numpy as np

from ..base.interpolation import smoothstep
from ..base.vertices import nearest_of, sample_of

FADE = 0.07  # distance / the garment's diagonal over which the hold fades out, as for a cuff (native/.../pins.cpp)
MOST = 500  # how many tucked vertices the distances are measured from
HELD = 0.9  # a hem that follows the animation at least this firmly cannot slip out
LEAST_SHARE = 0.3  # least share of a border that is covered: with less, other cloth only touches it


def held(follow: np.ndarray, positions: np.ndarray, tucked: np.ndarray, diagonal: float) -> np.ndarray:
    """(n,) float32: how firmly each vertex follows the animation, 1 where it is tucked in. follow: (n,), without this.
    positions: (n, 3) at rest. tucked: vertices, at least one. diagonal: of the cloth. Cost: 5 us for each vertex near
    the tucked ones."""
    fade = FADE * diagonal
    low, high = positions[tucked].min(axis=0) - fade, positions[tucked].max(axis=0) + fade
    near = np.flatnonzero(((positions >= low) & (positions <= high)).all(axis=1))
    share = np.zeros(len(positions))
    share[near] = 1.0 - nearest_of(positions[near], positions, sample_of(tucked, MOST))[1] / max(fade, 1e-30)
    share[tucked] = 1.0
    return np.maximum(follow, smoothstep(share)).astype(np.float32)
