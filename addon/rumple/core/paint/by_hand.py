# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes that an artist makes by hand, the same in every system: smooth places, rigid patches, folds along guides.
Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable

import numpy as np

from ...native import kernels
from ..mesh.base_mesh import BaseMesh
from ..mesh.frame_result import FrameResult
from ..mesh.shown_mesh import ShownMesh
from .fold_guides import ALONG, DIRECTION, GUIDES, KIND, GuidedFolds, directions
from .keep_smooth import SMOOTH, left_on_shown, move, share_of_folds
from .painted_rigid import RIGID, PaintedRigid


@dataclass
class ByHand:
    """These changes of one garment, for all frames."""

    smooth: np.ndarray | None = None  # (n,) of the base's vertices; None: not painted, or the system itself applies it
    guides: np.ndarray | None = None  # see fold_guides.py
    rigid: PaintedRigid | None = None
    said: list[str] = field(default_factory=list)  # messages about guides that give directions
    _folds: dict[kernels.ShownMesh, GuidedFolds] = field(default_factory=dict)  # by the native output mesh

    @classmethod
    def taken(cls, paint: dict[str, np.ndarray], base: BaseMesh, height_paint: str, solved: dict[str, np.ndarray],
              where_solved: Callable[[np.ndarray], np.ndarray]) -> "ByHand":
        """From the paint. solved: the paint as the system gets it. This function removes from it what ByHand itself
        applies, and sets the directions of guides and the paint height_paint (see Wrinkles). where_solved: carries
        values of the base's vertices to the vertices that are solved."""
        smooth = base.points(paint[SMOOTH]) if SMOOTH in paint else None
        rigid = PaintedRigid(base.points(paint[RIGID]), base) if RIGID in paint else None
        rigid = rigid if rigid is not None and rigid.count else None
        guides = solved.pop(GUIDES, None)
        said: list[str] = []
        if guides is not None:
            along, said = directions(guides, base.positions, base.polygon_start, base.corner_vertex)
            if along is not None and along.any():
                solved[ALONG] = where_solved(along)
            guides = guides[guides[:, KIND] != DIRECTION]
        solved.pop(RIGID, None)
        if height_paint:
            for left in ([share_of_folds(smooth)] if smooth is not None else []) + ([rigid.left()] if rigid else []):
                solved[height_paint] = solved.get(height_paint, np.float32(1.0)) * left
            smooth = None  # the system itself applies it
        return cls(smooth, guides if guides is not None and len(guides) else None, rigid, said)

    def __bool__(self) -> bool:
        """Whether it changes any result."""
        return self.smooth is not None or self.guides is not None or self.rigid is not None

    def add_to(self, result: FrameResult, mesh: ShownMesh, base: np.ndarray, over: np.ndarray,
               heights: tuple[str, ...]) -> None:
        """Change the result of one frame. mesh: the mesh of the result. base: the positions that it is embedded in.
        over: the same positions on the base cloth, or those of the coarse mesh in place of the base. heights: names of
        the attributes that contain the height of folds."""
        if self.smooth is not None or self.guides is not None:
            self._fold(result, mesh.shown, base, heights)
        if self.rigid is not None:
            self.rigid.add_to(result, mesh, base, over, heights)

    def _fold(self, result: FrameResult, shown: kernels.ShownMesh, base: np.ndarray, heights: tuple[str, ...]) -> None:
        """Remove folds where it is painted smooth, and add the folds along guides."""
        folds = None if self.guides is None else self._folds_on(shown)
        left = np.ones(len(result.positions), np.float32) if self.smooth is None else left_on_shown(self.smooth, shown)
        depths = left if folds is None else left[folds.rows]
        if folds is not None:
            left[folds.rows] = depths * folds.left
        lost = np.flatnonzero(left < 1.0)
        displacements = np.zeros_like(result.positions)
        displacements[lost] = (left[lost, None] - np.float32(1.0)) * result.offset[lost]
        rows = lost
        if folds is not None:
            displacements[folds.rows] += depths[:, None] * folds.displacements(result.positions + displacements)
            rows = np.union1d(lost, folds.rows)
        move(result, rows, displacements[rows], shown, base)
        for name in heights:
            result.attributes[name] = result.attributes[name] * left

    def notes(self, name: str) -> list[str]:
        """Messages for the artist about the guides. name: of the object."""
        notes = [note for folds in list(self._folds.values())[:1] for note in folds.notes]
        return [f"{name}: {note}" for note in self.said + notes]

    def _folds_on(self, shown: kernels.ShownMesh) -> GuidedFolds:
        if shown not in self._folds:
            assert self.guides is not None
            self._folds[shown] = GuidedFolds(self.guides, shown)
        return self._folds[shown]
