# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the cloth in a mesh: heals the mesh, checks it, and removes its rigid parts. Never imports bpy."""
from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...native import kernels
from ..base.vertices import places as places_of
from ..base.wording import UserError
from ..mesh.base_mesh import BaseMesh
from ..mesh.body import OwnSkin
from ..mesh.connected import parts as connected_parts
from ..mesh.healing import CUT
from ..mesh.rigid_parts import RigidParts
from . import capped_parts, skin_parts, solid_parts
from .measured_parts import MeasuredParts, measured

# largest diagonal of a small part, as a share of the largest part's: open parts, and closed ones
SMALL, SMALL_AND_CLOSED = 0.05, 0.12
MOST_AREA = 0.25  # share of the mesh. If small parts have more, the garment consists of them (mail, scales, patches)


class Checked(NamedTuple):
    """The cloth of a mesh."""

    base: BaseMesh  # healed if necessary (see Origin.notes()), without its rigid parts
    surface: kernels.Surface  # native, of it
    warnings: list[str]  # for the artist


def checked_surface(base: BaseMesh, weld: bool, rigid_parts: bool, unit_scale: float) -> Checked:
    """Finds the cloth of a mesh. rigid_parts: small parts and skin are rigid too, not only painted parts. unit_scale:
    metres per object unit. Raises UserError."""
    if not math.isfinite(unit_scale) or unit_scale <= 0.0:
        raise UserError(f"{base.name}: its scale is zero, so lengths in metres have no meaning: give it one")
    base = base.healed(weld)
    surface = base.surface(weld)
    warnings = [f"{base.name}: {warning}" for warning in surface.warnings]
    cloth = without_rigid_parts(base, weld, rigid_parts)
    return Checked(cloth, surface if cloth is base else cloth.surface(weld), warnings)


def without_rigid_parts(base: BaseMesh, weld: bool, small: bool = True) -> BaseMesh:
    """The healed mesh without the faces of its rigid parts, which are stored in `rigid`. The vertices of these faces
    stay. weld: vertices at the same place are one. small: beside painted parts, small parts, solid parts and skin in
    the mesh of its clothes are rigid. Cost: about 0.3 s for 50,000 vertices."""
    if not small and base.painted_rigid is None:
        return base
    places = places_of(base.positions) if weld else np.arange(len(base.positions))
    parts = connected_parts(base, _cut_apart(base, places))
    kinds = skin_parts.Kinds.none(int(parts.max(initial=-1)) + 1)
    chosen = skin = stays = kinds.skin
    if small and len(np.unique(parts[base.corner_vertex])) > 1:
        found = measured(base, parts, places)
        chosen = _small(found)
        kinds = skin_parts.find_skin(base, found, parts, chosen)
        skin, known = kinds.skin, kinds.skin | kinds.shoes | kinds.capped
        solid = kinds.shoes | solid_parts.find_solid(found, chosen | known)
        chosen |= skin | solid
        stays = skin | (solid & ~solid_parts.lies_on_cloth(base, found, parts, solid, chosen))
    painted = _painted(base, parts, chosen)
    chosen, skin, stays = chosen | painted, skin & ~painted, stays & ~painted
    part_of_polygon = parts[base.corner_vertex[base.polygon_start[:-1]]]
    for doubled in base.own_origin().copies:  # a doubled button: better solved as cloth than shown only once
        chosen[part_of_polygon[doubled.lies_on]] = False
    if not chosen.any():
        return base
    is_rigid = chosen[part_of_polygon]
    caps = capped_parts.find_caps(base, parts, places, kinds.garments & ~chosen, kinds.limbs | kinds.garments)
    for doubled in base.own_origin().copies:  # the same for caps
        caps[np.isin(caps, caps[doubled.lies_on])] = 0
    if caps.any():  # caps become parts of their own, which move with the cloth
        corner_cap = np.repeat(caps, np.diff(base.polygon_start))
        parts, skin, stays = parts.copy(), *(np.append(of, np.zeros(caps.max(), bool)) for of in (skin, stays))
        parts[base.corner_vertex[corner_cap > 0]] = len(chosen) + corner_cap[corner_cap > 0] - 1
        is_rigid |= caps > 0
    corner_is_rigid = np.repeat(is_rigid, np.diff(base.polygon_start))
    return replace(base.only(~is_rigid), rigid=_taken(base, parts, skin, stays, is_rigid, corner_is_rigid))


def _cut_apart(base: BaseMesh, places: np.ndarray) -> np.ndarray:
    """The places of vertices, where vertices on edges that healing cut are at separate places. So a flap that was cut
    there is a part of its own."""
    if base.origin is None or not len(base.origin.elements[CUT]):
        return places
    at_cut = np.isin(base.origin.vertex, base.origin.elements[CUT])
    apart = np.where(at_cut, len(places) + np.arange(len(places)), places)
    return np.unique(apart, return_inverse=True)[1].ravel()


def _small(found: MeasuredParts) -> np.ndarray:
    """(parts,) bool: which parts are small, by the constants above."""
    limit = np.where(found.closed, SMALL_AND_CLOSED, SMALL) * found.diagonal.max(initial=0.0)
    chosen = (found.diagonal <= limit) & (found.area > 0.0)
    return chosen if found.area[chosen].sum() <= MOST_AREA * found.area.sum() else np.zeros(len(chosen), bool)


def _painted(base: BaseMesh, parts: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """(parts,) bool: the completely painted parts. None if, with the chosen parts, no cloth would be left."""
    if base.painted_rigid is None:
        return np.zeros(len(chosen), bool)
    has_faces = np.zeros(len(chosen), bool)
    has_faces[parts[base.corner_vertex]] = True
    painted = has_faces.copy()
    painted[parts[~base.points(base.painted_rigid)]] = False
    return painted if (has_faces & ~chosen & ~painted).any() else np.zeros(len(chosen), bool)


def _taken(base: BaseMesh, parts: np.ndarray, skin: np.ndarray, stays: np.ndarray, is_rigid: np.ndarray,
           corner_is_rigid: np.ndarray) -> RigidParts:
    origin, corner_vertex = base.own_origin(), base.corner_vertex[corner_is_rigid]
    vertex, rows = np.unique(corner_vertex, return_inverse=True)
    sides = np.unique(np.sort(base.sides()[corner_is_rigid], axis=1), axis=0)
    triangles = base.triangles[corner_is_rigid[base.triangle_corner[:, 0]]]
    turned = np.concatenate([np.roll(triangles, -k, axis=1) for k in range(3)])
    place = np.unique(turned[:, 0], return_index=True)[1]  # every vertex of a polygon is in one of its triangles
    numbers, part = np.unique(parts[vertex], return_inverse=True)
    own_skin = OwnSkin(triangles[skin[parts[triangles[:, 0]]]])
    return RigidParts(part.ravel().astype(np.int32), skin[numbers], stays[numbers], own_skin,
                      vertex.astype(np.int32), turned[place].astype(np.int32),
                      np.searchsorted(vertex, sides).astype(np.int32),
                      origin.polygon[is_rigid], np.diff(base.polygon_start)[is_rigid],
                      origin.corner[corner_is_rigid], rows.ravel().astype(np.int32))
