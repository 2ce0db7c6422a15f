# SPDX-License-Identifier: GPL-3.0-or-later
"""What a garment is worn over. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Body:
    """The surfaces that cloth stays outside of, as they stand in a frame; all bodies of a garment in one."""

    positions: np.ndarray  # (b, 3) float32, object space of the garment
    triangles: np.ndarray  # (t, 3) int32, into positions; counter-clockwise seen from outside

    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """All that it is, for digests."""
        return self.positions, self.triangles

    def same_as(self, other: "Body | None") -> bool:
        """Whether both are the same surfaces at the same places, to the bit."""
        return (other is not None and np.array_equal(self.positions, other.positions)
                and np.array_equal(self.triangles, other.triangles))
