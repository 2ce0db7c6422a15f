# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth steps for the demo's figure and garments and for scripts/ground_truth. Pure NumPy, no Blender."""
from __future__ import annotations

from typing import Any

import numpy as np


def smoothstep(x: Any) -> Any:
    """Cubic step from 0 (x <= 0) to 1 (x >= 1), of a number or an array."""
    t = np.clip(x, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
