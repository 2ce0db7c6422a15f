# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth steps between 0 and 1. Never imports bpy."""
from __future__ import annotations

import numpy as np


def smoothstep(share: np.ndarray) -> np.ndarray:
    """3 t^2 - 2 t^3, with t clamped to 0..1: flat at both ends."""
    share = np.clip(share, 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)
