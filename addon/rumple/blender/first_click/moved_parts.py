# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints parts of a garment's mesh that are no cloth by the bones that move them, for the first click: plates, buckles
and belts as Rigid, bare hands as Pinned and Keep Smooth. It is painted, so that the artist can see and change it."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.base.vertices import places
from ...core.base.wording import UserError
from ...core.cloth.base_cloth import suggested_follow
from ...core.mesh.base_mesh import BaseMesh
from ...core.mesh.connected import parts
from ...core.paint.keep_smooth import SMOOTH
from ...core.paint.painted_rigid import RIGID
from ...core.parts.cloth_surface import without_rigid_parts
from ...core.parts.measured_parts import measured
from ...core.parts.moved_parts import Moved, find_moved
from .. import compat
from ..objects import bodies_at_rest, incoming_mesh, mesh_reader, painted_maps, properties


def paint(obj: bpy.types.Object) -> None:
    """Paint the maps that do not exist. Cost: nothing for a mesh of one part, otherwise that of
    without_rigid_parts(), of find_moved(), and 1 ms for 1,000 vertices."""
    settings = properties.group_of(obj)
    if settings.base_cloth == "OFF" or not settings.rigid_parts:
        return
    if not compat.is_editable(obj) or not compat.is_editable(obj.data):
        return
    try:
        base = mesh_reader.base_mesh(obj, "REST_POSE", "").healed(True)
        part = parts(base, places(base.positions))
        if len(np.unique(part[base.corner_vertex])) < 2:
            return
        cloth = without_rigid_parts(base, True)
        found = _found(obj, base, part, cloth)
        if not found.any:
            return
        hands = found.hands[part]
        follow = suggested_follow(cloth.surface(True), settings.up) if hands.any() else np.zeros(len(part), np.float32)
    except UserError:
        return  # the build reports this error
    _write(obj, base, RIGID, found.rigid[part].astype(np.float32))
    if hands.any():
        _write(obj, base, SMOOTH, hands.astype(np.float32))
        _write(obj, base, "follow", np.maximum(hands, follow).astype(np.float32))


def _found(obj: bpy.types.Object, base: BaseMesh, part: np.ndarray, cloth: BaseMesh) -> Moved:
    bones = [bone for rig in sorted(bodies_at_rest.armatures(obj), key=lambda rig: rig.name_full)
             for bone in rig.data.bones if bone.name in obj.vertex_groups]
    names = [bone.name for bone in bones]
    weights = base.points(mesh_reader.group_weights(obj, incoming_mesh.of(obj), names))
    below = np.array([[one == other or one in other.parent_recursive for other in bones] for one in bones], bool)
    known = np.zeros(int(part.max()) + 1, bool)
    if cloth.rigid is not None:
        known[part[cloth.rigid.vertex]] = True
    return find_moved(base, measured(base, part, places(base.positions)), part, known, weights, below)


def _write(obj: bpy.types.Object, base: BaseMesh, key: str, values: np.ndarray) -> None:
    painted = painted_maps.find(obj, key)
    if painted is None or painted.exists or not values.any():
        return
    own = painted_maps.in_steps(values[:base.own_origin().vertex_count])
    painted_maps.write(obj, painted, painted_maps.on_own_vertices(obj, own), masked=False)
