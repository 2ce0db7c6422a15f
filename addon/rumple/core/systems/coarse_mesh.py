# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a Wrinkle Mesh, or the base cloth of another system, is solved on another mesh in place of the base, and on
which. Never imports bpy."""
from __future__ import annotations

import math
from typing import Any

from ...native import kernels
from ..base.wording import UserError
from ..cloth.carried_cloth import ClothMesh
from ..mesh.base_mesh import BaseMesh
from ..mesh.figure_size import size_of
from ..mesh.outer_side import OuterSide
from ..mesh.outer_side import find as find_outer_side
from ..parts.flared import is_flared
from ..settings.cloth_settings import direction_of
from ..settings.system_settings import MeshSettings
from .fold_density import halvings

COARSE_SPACING = 0.033  # metres: distance of the coarse mesh's vertices in an adult's garment of cotton
MEAN_EDGE = 32.0 / 33.0  # mean edge of a coarse mesh / distance of its vertices: its widest folds have five edges
SPACING_RANGE = math.sqrt(2.0)  # distance of coarse vertices / COARSE_SPACING: at most this, at least 1 / this
WIDE = 0.1  # metres: if the finest folds are this wide, and for every skirt, the coarse edges are twice as long
DENSE = 20.0 / 33.0  # relative to COARSE_SPACING: a base with shorter edges or narrower faces is not solved itself
LEAST_VERTICES = 3.0  # vertices of a dense garment / those of the coarse mesh that its base cloth is solved on
LONG = 2.0  # relative to COARSE_SPACING: nor is one with longer edges, which could not hang in folds


def fitting_spacing(usual: float, wavelength: float) -> float:
    """Metres: the distance of coarse vertices nearest to the usual one for which the finest layer has folds of exactly
    this wavelength, so that every fabric has its own fold width. At most SPACING_RANGE times the usual one."""
    count = halvings(MEAN_EDGE * usual, wavelength)
    return usual * min(2.0 ** round(max(round(count), 0) - count, 6), SPACING_RANGE)  # six digits are float32's


def coarse_mesh(base: BaseMesh, settings: MeshSettings, surface: Any, unit_scale: float,
                outer: OuterSide | None = None) -> Any:
    """The native mesh that is solved in place of a base: as it was modelled, if its edges are too short for wide folds,
    or it has triangles; subdivided, if they are too long; or else an even one, if they are too short, or of the outer
    side of a base with an inner side. Without parts that are sewn on others. None: the base itself."""
    size = size_of(base, unit_scale)
    by_wavelength, cloth = settings.density == "WAVELENGTH", base if outer is None else outer.mesh
    wide = by_wavelength and (settings.wavelength >= WIDE * size or is_flared(cloth, direction_of(settings.up)))
    spacing = COARSE_SPACING * size * (2.0 if wide else 1.0)
    least, most = DENSE * spacing / unit_scale, LONG * spacing / unit_scale
    spacing = fitting_spacing(spacing, settings.wavelength) if by_wavelength else spacing
    dense = _is_dense(base, surface, least)
    may_change = by_wavelength and settings.base_cloth != "OFF"
    whole = surface if outer is None else outer.surface
    part = _without_sewn_on(cloth, whole, settings) if may_change else whole
    try:
        if may_change and (dense or cloth.is_of_triangles() or base.mean_edge() > most or part is not whole):
            return kernels.as_modelled(surface, least, most, part)
    except ValueError:
        pass  # it was modelled so, or with narrow faces
    try:
        if outer is not None or part is not whole or (may_change and dense):
            return kernels.build_coarse(surface, spacing / unit_scale, part)
    except ValueError:
        pass  # it is too small
    return None


def cloth_mesh(base: BaseMesh, surface: Any, weld: bool, up: str, unit_scale: float) -> ClothMesh | None:
    """The mesh that the base cloth of a garment is solved on under a Wrinkle Field or Wrinkle Paths if it is dense or
    has a modelled thickness: that of a Wrinkle Mesh of cotton. None: it is solved on all vertices; a dense one too, if
    they are no more than LEAST_VERTICES times as many. surface: native, of the base. weld, up: as in the settings.
    Cost: about 10 us for each vertex of such a garment."""
    size, outer = size_of(base, unit_scale), find_outer_side(base, surface, weld)
    if outer is None and not _is_dense(base, surface, DENSE * COARSE_SPACING * size / unit_scale):
        return None
    settings = MeshSettings(base_cloth="HANG", wavelength=MeshSettings.wavelength * size, weld=weld, up=up)
    coarse = coarse_mesh(base, settings, surface, unit_scale, outer)
    if coarse is None or (outer is None and LEAST_VERTICES * coarse.surface.vertex_count > surface.vertex_count):
        return None
    return ClothMesh(coarse, outer)


def _is_dense(base: BaseMesh, surface: Any, least: float) -> bool:
    """Whether its edges are too short, or its faces too narrow, for wide folds. least: length, object units."""
    return base.mean_edge() < least or kernels.is_uneven(surface, least)


def _without_sewn_on(cloth: BaseMesh, surface: Any, settings: MeshSettings) -> Any:
    """The native surface of the parts that no other part holds. What is sewn on them, as a pocket is, moves along."""
    sewn = kernels.sewn_on(surface, tuple(direction_of(settings.up)), len(cloth.polygon_start) - 1)
    try:
        return cloth.only(~sewn).surface(settings.weld) if sewn.any() else surface
    except UserError:
        return surface  # for example, sides that meet at a vertex
