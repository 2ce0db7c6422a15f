# SPDX-License-Identifier: GPL-3.0-or-later
"""What cloth that swings meets in the world. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Surroundings:
    """Of a garment in one frame."""

    location: Vector = (0.0, 0.0, 0.0)  # of the object's origin, world space, Blender's units
    wind: Vector = (0.0, 0.0, 0.0)  # velocity of the air, world space, m/s

    def array(self) -> np.ndarray:
        """All that it is, for digests."""
        return np.array((self.location, self.wind), np.float64)
