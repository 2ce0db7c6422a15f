# SPDX-License-Identifier: GPL-3.0-or-later
"""Paints skin that is welded to clothes, for the first click: it follows the animation and has no folds. It is painted,
so that the artist can see and change it."""
from __future__ import annotations

import bpy
import numpy as np

from ...core import skin_materials
from ...core.cloth import suggested_follow
from ...core.keep_smooth import SMOOTH
from ...core.wording import UserError
from .. import compat
from . import cloth_defaults, mesh_reader, painted_maps, properties, welded_skin


def paint(obj: bpy.types.Object) -> list[str]:
    """Paint Pinned and Keep Smooth on the skin; what is pinned without the map stays pinned. An existing map is not
    changed. Returns the names of the skin's materials; empty if nothing was painted. Cost: see welded_skin.py."""
    settings = properties.group_of(obj)
    if settings.base_cloth == "OFF" or not (compat.is_editable(obj) and compat.is_editable(obj.data)):
        return []
    both = (painted_maps.find(obj, key) for key in ("follow", SMOOTH))
    maps = [found for found in both if found is not None and not found.exists]
    if not maps or not welded_skin.materials(obj):
        return []
    base = mesh_reader.base_mesh(obj, "REST_POSE", "")
    skin_faces = welded_skin.faces(obj, base)
    if skin_faces is None:
        return []
    skin = skin_materials.vertices_of(base, skin_faces).astype(np.float32)
    try:
        follow = suggested_follow(cloth_defaults.cloth_at_rest(obj).surface(True), settings.up)[:len(skin)]
    except UserError:
        return []  # the build reports this error
    for found in maps:
        weights = skin if found.key == SMOOTH else np.maximum(skin, follow)
        painted_maps.write(obj, found, cloth_defaults.on_own_vertices(obj, cloth_defaults.in_steps(weights)),
                           masked=False)
    return welded_skin.materials_of(obj, base, skin_faces)
