# SPDX-License-Identifier: GPL-3.0-or-later
"""Wide folds under a Wrinkle Field or Wrinkle Paths: the first layer of a Wrinkle Mesh, over their base cloth. Never
imports bpy."""
from __future__ import annotations

from typing import Any

import numpy as np

from ...native import kernels
from ..base.triangles import corner_weights
from ..paint.keep_smooth import share_of_folds
from ..settings.system_settings import MeshSettings
from .base_cloth import BaseCloth, ClothFrame, bend_radius
from .layers import layer_settings


class Drape:
    """The layer of one garment. It has no state: ClothFrame.drape is the state of a frame."""

    def __init__(self, cloth: BaseCloth) -> None:
        """cloth: of the garment."""
        self.metre = cloth.size_factor / cloth.unit_scale  # one metre of a person's clothes, object units
        self.model = kernels.build_wrinkle_layers(cloth.surface, 0, display_steps=0)
        self._vertex = corner_of(self.model.shown)

    def add_to(self, frame: ClothFrame, settings: Any, world_from_object: np.ndarray | None, before: Any,
               contact: dict[str, Any], smooth: np.ndarray | None = None) -> None:
        """Add the wide folds to the base cloth of a frame. settings: of a Wrinkle Field or Wrinkle Paths. before: the
        layer's state in the previous frame, or None. contact: collision arguments of solve_wrinkle_layers(). smooth:
        (n,) paint, see keep_smooth.py. Raises ValueError."""
        frame.drape = self.solve(frame, settings, world_from_object, before, contact)
        shown = kernels.show_wrinkle_layers(self.model, frame.positions, frame.positions, frame.drape)
        draped = frame.positions.copy()  # loose vertices are not in the layer
        draped[self._vertex] = shown.positions
        frame.positions = draped if smooth is None else frame.positions + (
            share_of_folds(smooth)[:, None] * (draped - frame.positions))

    def solve(self, frame: ClothFrame, settings: Any, world_from_object: np.ndarray | None, before: Any,
              contact: dict[str, Any]) -> kernels.WrinkleLayersState:
        """The state of the layer, solved over the base cloth of a frame. Arguments as in add_to()."""
        mesh = _mesh_settings(settings)
        options = layer_settings(mesh, 1, world_from_object=world_from_object,
                                 bend=bend_radius(mesh, mesh.wavelength, 1.0 / self.metre))
        state, _ = kernels.solve_wrinkle_layers(self.model, options, None, frame.positions, state=before, **contact)
        return state


def corner_of(shown: Any) -> np.ndarray:
    """(d,) the base vertex of every vertex of a shown mesh. shown: native, without subdivisions: then every vertex is a
    corner of its triangle."""
    corner = corner_weights(shown).argmax(axis=1)
    return shown.triangle_vertex[np.arange(len(corner)), corner]


def _mesh_settings(settings: Any) -> MeshSettings:
    """Settings of a Wrinkle Mesh on the same cloth, whose only layer is as strong as the drape."""
    same = {name: getattr(settings, name) for name in ("base_cloth", "slack", "gravity", "bending_length")}
    return MeshSettings(detail=settings.drape, hem_rings=0, **same)
