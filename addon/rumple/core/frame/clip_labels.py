# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels for adaptive rest shapes, computed by a graph cut over a whole clip before its frames are solved. Never
imports bpy."""
from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...native import kernels
from ..base.digests import digest_of


class ClipLabels:
    """The labels of the clip that was analysed last; empty at first."""

    def __init__(self) -> None:
        self._by_frame: dict[float, tuple[bytes, np.ndarray]] = {}  # digest of the positions, labels
        self.pose_mismatches: set[float] = set()  # frames whose positions differ from the analysed ones

    @classmethod
    def of(cls, model: Any, native_settings: Any, clip: dict[float, np.ndarray], frame_rate: float) -> "ClipLabels":
        """Analyse a clip. clip: (n, 3) float32 positions of the base by whole frame, ascending. Raises ValueError."""
        times = np.array([frame / frame_rate for frame in clip], np.float64)
        cut = kernels.label_clip(model, native_settings, times, np.concatenate(list(clip.values())))
        labels = cls()
        labels._by_frame = {frame: (digest_of(b"", positions), row)
                            for (frame, positions), row in zip(clip.items(), cut)}
        return labels

    def at(self, frame: float, positions: np.ndarray) -> np.ndarray | None:
        """The labels of a frame, (t,) uint8; None if it was not analysed, or its positions differ. A subframe has the
        labels of the next whole frame."""
        digest, labels = self._by_frame.get(float(math.ceil(frame)), (b"", None))
        if labels is None or frame != math.ceil(frame):
            return labels
        if digest != digest_of(b"", positions):
            self.pose_mismatches.add(frame)
            return None
        # an object that follows another has its final positions only in a second pass
        self.pose_mismatches.discard(frame)
        return labels
