# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist asks for by hand, of every system alike: smooth places, and folds along guides. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .fold_guides import GuidedFolds
from .frame_result import FrameResult
from .keep_smooth import left_on_shown, move, share_of_folds


@dataclass
class ByHand:
    """Of one garment, for all of its frames."""

    smooth: np.ndarray | None = None  # (n,) of the base's vertices; None: none, or the system sees itself to it
    guides: np.ndarray | None = None  # as fold_guides.py has them
    _folds: dict[int, tuple[Any, GuidedFolds]] = field(default_factory=dict)  # by native mesh that is shown

    @classmethod
    def of(cls, smooth: np.ndarray | None, guides: np.ndarray | None, height_paint: str,
           paint: dict[str, np.ndarray]) -> "ByHand":
        """height_paint: of the system, as Wrinkles has it; it is set in paint."""
        if smooth is not None and height_paint:
            paint[height_paint] = paint.get(height_paint, np.float32(1.0)) * share_of_folds(smooth)
            smooth = None
        return cls(smooth, guides if guides is not None and len(guides) else None)

    def __bool__(self) -> bool:
        """Whether results are changed."""
        return self.smooth is not None or self.guides is not None

    def add_to(self, result: FrameResult, shown: Any, base: np.ndarray, heights: tuple[str, ...]) -> None:
        """shown: native, of the result. base: positions that it is embedded in. heights: attributes that say how high
        folds are."""
        if not self:
            return
        folds = None if self.guides is None else self._folds_on(shown)
        left = np.ones(len(result.positions), np.float32) if self.smooth is None else left_on_shown(self.smooth, shown)
        depths = left if folds is None else left[folds.rows]
        if folds is not None:
            left[folds.rows] = depths * folds.left
        lost = np.flatnonzero(left < 1.0)
        ways = np.zeros_like(result.positions)
        ways[lost] = (left[lost, None] - np.float32(1.0)) * result.offset[lost]
        rows = lost
        if folds is not None:
            ways[folds.rows] += depths[:, None] * folds.ways(result.positions + ways)
            rows = np.union1d(lost, folds.rows)
        move(result, rows, ways[rows], shown, base)
        for name in heights:
            result.attributes[name] = result.attributes[name] * left

    def notes(self, name: str) -> list[str]:
        """What is to be said of the guides, for the artist. name: of the object."""
        return [f"{name}: {note}" for _, folds in list(self._folds.values())[:1] for note in folds.notes]

    def _folds_on(self, shown: Any) -> GuidedFolds:
        known = self._folds.get(id(shown))
        if known is None or known[0] is not shown:
            assert self.guides is not None
            known = self._folds[id(shown)] = (shown, GuidedFolds(self.guides, shown))
        return known[1]
