# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments whose thickness was modelled: their outer side is the cloth, and the inner one and the rims move with it.
Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..native import kernels
from .base_mesh import BaseMesh
from .body import volume_share
from .wording import UserError

THIN = 0.015  # volume_share() of what may have an inner side: of a body it is twice that, of a padded jacket 0.008


@dataclass(frozen=True)
class OuterSide:
    """Of a mesh: the polygons of its outer side, and all of parts without an inner one."""

    mesh: BaseMesh  # these polygons, with all vertices of the mesh
    surface: Any  # native, of these
    thickness: float  # object units: how far the inner side is below it


def find(base: BaseMesh, surface: Any, weld: bool) -> OuterSide | None:
    """None where no thickness is modelled. base: healed; surface: native, of it. Cost: 1 ms for 10,000 triangles of
    what is not thin, else about 1 ms for 1,000 polygons."""
    if not _is_thin(base):
        return None
    polygons, thickness = kernels.outer_side(surface, len(base.polygon_start) - 1)
    if not thickness:
        return None
    mesh = base.only(polygons)
    try:
        return OuterSide(mesh, mesh.surface(weld), thickness)
    except UserError:
        return None  # sides that meet at a vertex, for one


def without_inner_side(base: BaseMesh) -> BaseMesh:
    """Of a mesh at rest, as the artist has it, what is cloth; the mesh itself where no thickness is modelled, or it
    cannot be told. Cost: as find(), and where it may have one that of healing it."""
    if not _is_thin(base):
        return base
    try:
        healed = base.healed(True)
        outer = find(healed, healed.surface(True), True)
    except UserError:
        return base  # what is wrong with it is said where it is built
    return base if outer is None else outer.mesh


def triangles_of(base: BaseMesh) -> np.ndarray:
    """(t, 3) of without_inner_side(), vertices as the artist has them."""
    outer = without_inner_side(base)
    return outer.triangles if outer.origin is None else outer.origin.vertex[outer.triangles]


def _is_thin(base: BaseMesh) -> bool:
    return volume_share(base.positions, base.triangles) < THIN
