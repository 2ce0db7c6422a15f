# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth of a dense or thick garment under a Wrinkle Field or Wrinkle Paths. It is solved on a coarse mesh and
carried to all vertices, as a Wrinkle Mesh carries its folds. Never imports bpy."""
from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...native import kernels
from ..base.triangles import Embedding, corner_weights, on_shown
from ..mesh.outer_side import OuterSide
from .base_cloth import ClothFrame
from .drape import Drape, corner_of

NO_LIMIT = 2**30  # of shown vertices: they are those of the garment itself
SMOOTHINGS = 2  # of the cloth on an even mesh, see smoothed()


class ClothMesh(NamedTuple):
    """The mesh that is solved in place of a dense or thick garment."""

    coarse: Any  # native
    outer: OuterSide | None  # set if the garment has modelled thickness: then it stands for the outer side


class CarriedCloth:
    """Carries the cloth of one garment. It has no state. n: vertices of the garment, m: of the coarse mesh."""

    def __init__(self, surface: Any, coarse: Any, drape: Drape) -> None:
        """surface: native, of the garment at rest. coarse: native, made for it. drape: on the coarse mesh."""
        self.coarse, self._count = coarse, surface.vertex_count
        self._transfer = kernels.build_wrinkle_transfer(surface, coarse, drape.model, 0, most_vertices=NO_LIMIT)
        self._vertex = corner_of(self._transfer.shown)  # loose vertices are not shown
        near = kernels.build_wrinkle_mesh(coarse.surface, source="OBJECT", own=surface, attachment="LINEAR",
                                          display_steps=0, most_vertices=NO_LIMIT).shown
        self._near = Embedding(near.triangle_vertex.copy(), near.barycentric.copy())  # the coarse triangles below
        corner = corner_weights(self._near).argmax(axis=1)
        self._nearest = self._near.triangle_vertex[np.arange(len(corner)), corner]
        self._painted: tuple[dict[str, np.ndarray], dict[str, np.ndarray]] = {}, {}
        self._edges = drape.model.shown.edge_sources.copy() if coarse.spacing is not None else None

    def paint(self, paint: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Paint (n,) -> (m,). The same result for the same dictionary as in the last call."""
        if self._painted[0] is not paint:
            self._painted = paint, {name: painted_on(self.coarse, values) for name, values in paint.items()}
        return self._painted[1]

    def smoothed(self, positions: np.ndarray, animated: np.ndarray, follow: np.ndarray) -> np.ndarray:
        """The cloth (m, 3) float32 on an even mesh without what alternates from vertex to vertex: its triangles are
        irregular, so it is compressed in patches, each of which would get a short path. Of every displacement from the
        animation half becomes the mean of the neighbours', less where it is pinned. Other meshes stay. animated:
        (m, 3). follow: (m,), 1: pinned."""
        if self._edges is None:
            return positions
        a, b = self._edges.T
        count, offset = len(positions), (positions - animated).astype(np.float64)
        neighbours = np.maximum(np.bincount(self._edges.ravel(), minlength=count), 1)
        share = 0.5 * (1.0 - np.clip(follow, 0.0, 1.0))
        for _ in range(SMOOTHINGS):
            mean = np.stack([np.bincount(a, axis[b], count) + np.bincount(b, axis[a], count) for axis in offset.T])
            offset += share[:, None] * (mean.T / neighbours[:, None] - offset)
        return (animated + offset).astype(np.float32)

    def carried(self, frame: ClothFrame, drape: kernels.WrinkleLayersState, animated: np.ndarray) -> ClothFrame:
        """The frame of the garment. frame: of the coarse mesh. Other arguments as in positions(). Raises ValueError."""
        gap = np.zeros(self._count, np.float32)
        gap[self._vertex] = np.clip(on_shown(frame.gap, self._near), 0.0, frame.gap.max(initial=0.0))  # it is rounded
        hint = np.full(self._count if len(frame.body_hint) else 0, -1, np.int32)
        if len(hint):
            hint[self._vertex] = frame.body_hint[self._nearest]
        return replace(frame, positions=self.positions(drape, animated), gap=gap, body_hint=hint, drape=drape,
                       solved=frame.positions)

    def positions(self, drape: kernels.WrinkleLayersState, animated: np.ndarray) -> np.ndarray:
        """(n, 3) float32 of the cloth of a frame, object space. drape: state of the wide folds on it. animated: (n, 3)
        float32, object space. Loose vertices stay as they are animated. Raises ValueError."""
        positions = animated.copy()
        positions[self._vertex] = kernels.show_wrinkle_transfer(self._transfer, animated, drape).positions
        return positions


def painted_on(coarse: Any, values: np.ndarray) -> np.ndarray:
    """Values (n,) of the vertices of a dense mesh -> (m,) float32 of the coarse mesh in its place."""
    return coarse.paint(np.ascontiguousarray(values, np.float32))
