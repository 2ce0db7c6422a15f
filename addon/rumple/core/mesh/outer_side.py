# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments with modelled thickness: only the outer side is solved as cloth, the inner side and the rims move with it.
Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...native import kernels
from ..base.wording import UserError
from .base_mesh import BaseMesh
from .body import volume_share

THIN = 0.015  # most volume_share() of a mesh that may have an inner side: a body has twice that, a padded jacket 0.008


@dataclass(frozen=True)
class OuterSide:
    """The outer side of a mesh. Parts without an inner side belong to it as a whole."""

    mesh: BaseMesh  # these polygons, with all vertices of the mesh
    surface: Any  # native surface of these polygons
    thickness: float  # object units: how far the inner side is below it

    def line(self, unit_scale: float) -> str:
        """For the artist. unit_scale: metres per object unit."""
        return f"Thickness of {1000.0 * unit_scale * self.thickness:.1f} mm: the inner side moves with the outer one"


def find(base: BaseMesh, surface: Any, weld: bool) -> OuterSide | None:
    """None if no thickness is modelled. base: healed; surface: native, of it. Cost: 1 ms for 10,000 triangles if the
    mesh is not thin, otherwise about 1 ms for 1,000 polygons."""
    if not _is_thin(base):
        return None
    polygons, thickness = base.once(f"outer_side {weld}",
                                    lambda: kernels.outer_side(surface, len(base.polygon_start) - 1),
                                    base.crease_edge, base.crease_sharpness)
    if not thickness:
        return None
    mesh = base.only(polygons)
    try:
        return OuterSide(mesh, mesh.surface(weld), thickness)
    except UserError:
        return None  # for example, sides that meet at a vertex


def without_inner_side(base: BaseMesh) -> BaseMesh:
    """The outer side of an artist's mesh at rest. It is the mesh itself if no thickness is modelled, or if this cannot
    be decided. Cost: see find(); for a thin mesh also the cost of healing."""
    if not _is_thin(base):
        return base
    try:
        healed = base.healed(True)
        outer = find(healed, healed.surface(True), True)
    except UserError:
        return base  # the build reports what is wrong with it
    return base if outer is None else outer.mesh


def triangles_of(base: BaseMesh) -> np.ndarray:
    """(t, 3) triangles of without_inner_side(), as the artist's vertices."""
    outer = without_inner_side(base)
    return outer.triangles if outer.origin is None else outer.origin.vertex[outer.triangles]


def _is_thin(base: BaseMesh) -> bool:
    return volume_share(base.positions, base.triangles) < THIN
