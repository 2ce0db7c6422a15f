# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth for whoever has arrays: the coarse mesh becomes cloth around its animation. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import native
from .body import Body
from .settings import ClothSettings

GRAVITY = 9.81  # m/s^2
DOLL, GIANT = 0.4, 3.0  # metres, diagonal of a garment: smaller and larger ones hang as these do, to scale


def size_factor(diagonal: float, unit_scale: float) -> float:
    """By how much lengths of cloth differ from those on a person. diagonal: of the garment's bounding box, object
    units."""
    size = diagonal * unit_scale
    return size / min(max(size, DOLL), GIANT) if size > 0.0 else 1.0


@dataclass
class ClothFrame:
    """The base cloth of one frame: what lies on it is solved over this."""

    positions: np.ndarray  # (n, 3) float32, object space
    gap: np.ndarray  # (n,) float32: height above what is worn under it, object units
    body_hint: np.ndarray  # (n,) int32: a triangle of the body near it, or -1; (0,) without a body
    state: Any
    report: Any

    @property
    def nbytes(self) -> int:
        return self.positions.nbytes + self.gap.nbytes + self.body_hint.nbytes + self.state.nbytes


class BaseCloth:
    """A garment's cloth and the collider of its body. No state: frames are handed in and out."""

    def __init__(self, surface: Any, diagonal: float, unit_scale: float) -> None:
        """surface: native, at rest. diagonal: of its bounding box, object units. unit_scale: metres per object unit."""
        self.surface, self.unit_scale = surface, unit_scale
        self.model = native.load().build_base_cloth(surface)
        self.size_factor = size_factor(diagonal, unit_scale)
        self._collider: tuple[np.ndarray, Any] | None = None
        self._paint: Any = None
        self._painted: dict[str, np.ndarray] | None = None
        self._up = ""

    def solve(self, positions: np.ndarray, settings: ClothSettings, paint: dict[str, np.ndarray],
              object_from_world: np.ndarray, body: Body | None, before: ClothFrame | None) -> ClothFrame:
        """One frame. positions: (n, 3) float32, animated, object space. object_from_world: (3, 3) float64, for the
        direction of gravity. before: the frame before, or None. Raises ValueError."""
        if paint is not self._painted or settings.up != self._up:
            self._take_paint(paint, settings.up)
        collider = self.collider(body)
        return ClothFrame(*native.load().solve_base_cloth(
            self.model, self._native_settings(settings, object_from_world), self._paint, positions, collider,
            body.positions if body is not None else None, before.state if before is not None else None))

    def collider(self, body: Body | None) -> Any:
        """The native collider of a body, built once for its triangles; None for none."""
        if body is None or not len(body.triangles):
            return None
        if self._collider is None or not np.array_equal(self._collider[0], body.triangles):
            self._collider = body.triangles, native.load().Collider(body.positions, body.triangles)
        return self._collider[1]

    def follow(self, up: str) -> np.ndarray:
        """(n,) float32: how firmly every vertex follows the animation where nothing is painted. up: of settings."""
        direction = np.zeros(3)
        direction["XYZ".index(up[-1])] = -1.0 if up[0] == "-" else 1.0
        return native.load().suggest_follow(self.surface, tuple(direction))

    def thickness(self, settings: ClothSettings) -> float:
        """Of the cloth, object units."""
        return settings.thickness / self.unit_scale

    def _take_paint(self, paint: dict[str, np.ndarray], up: str) -> None:
        values = paint if "follow" in paint else {**paint, "follow": self.follow(up)}
        self._paint, self._painted, self._up = native.load().BaseClothPaint(self.model, values), paint, up

    def _native_settings(self, settings: ClothSettings, object_from_world: np.ndarray) -> Any:
        """Metres into object units. A doll's cloth, and a giant's, hang as a person's do: lengths to scale."""
        options = native.load().BaseClothSettings()
        to_scale = self.size_factor / self.unit_scale
        for name in ("stretch", "shear", "compression", "folded", "smoothing"):
            setattr(options, name, getattr(options, name) * to_scale**2)
        for name in ("unknown", "reach", "depth", "spread"):
            setattr(options, name, getattr(options, name) * to_scale)
        down = object_from_world @ np.array((0.0, 0.0, -1.0))
        length = float(np.linalg.norm(down))
        gravity = GRAVITY * settings.gravity * to_scale * (down / length if length > 0.0 else down)
        options.gravity = tuple(float(g) for g in gravity)
        options.slack, options.room = settings.slack, settings.room / self.unit_scale
        options.thickness = self.thickness(settings)
        return options
