# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints skin that is found by the names of materials, for the first click: it follows the animation and has no folds.
It is painted, so that the artist can see and change it."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.base.wording import UserError
from ...core.cloth.base_cloth import suggested_follow
from ...core.paint.keep_smooth import SMOOTH
from ...core.parts import skin_materials
from ...core.parts.cloth_surface import without_rigid_parts
from .. import compat
from ..objects import mesh_reader, painted_maps, properties
from . import named_skin


def paint(obj: bpy.types.Object) -> list[str]:
    """Paint Pinned and Keep Smooth on the skin that is not found by its shape; what is pinned without the map stays
    pinned. An existing map is not changed. Returns the names of the skin's materials; empty if nothing was painted.
    Cost: nothing if no material names skin, otherwise see without_rigid_parts()."""
    settings = properties.group_of(obj)
    if settings.base_cloth == "OFF" or not (compat.is_editable(obj) and compat.is_editable(obj.data)):
        return []
    both = (painted_maps.find(obj, key) for key in ("follow", SMOOTH))
    maps = [found for found in both if found is not None and not found.exists]
    if not maps or not named_skin.materials(obj):
        return []
    try:
        base = mesh_reader.base_mesh(obj, "REST_POSE", "").healed(True)
        cloth = without_rigid_parts(base, True, settings.rigid_parts)
        skin_faces = named_skin.faces(obj, cloth)
        if skin_faces is None:
            return []
        follow = suggested_follow(cloth.only(~skin_faces).surface(True), settings.up)
    except UserError:
        return []  # the build reports this error
    skin, own = skin_materials.vertices_of(cloth, skin_faces).astype(np.float32), base.own_origin().vertex_count
    for found in maps:
        weights = painted_maps.in_steps((skin if found.key == SMOOTH else np.maximum(skin, follow))[:own])
        painted_maps.write(obj, found, painted_maps.on_own_vertices(obj, weights), masked=False)
    return named_skin.materials_of(obj, cloth, skin_faces)
