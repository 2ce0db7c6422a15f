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
    changed. Returns the names of the materials; empty if nothing was painted. Cost: see welded_skin."""
    settings = properties.group_of(obj)
    if settings.base_cloth == "OFF" or not (compat.is_editable(obj) and compat.is_editable(obj.data)):
        return []
    both = (painted_maps.find(obj, key) for key in ("follow", SMOOTH))
    maps = [found for found in both if found is not None and not found.exists]
    skin, follow = _skin_and_follow(obj, settings.up) if maps else (None, None)
    if skin is None:
        return []
    for found in maps:
        weights = skin if found.key == SMOOTH else np.maximum(skin, follow)
        painted_maps.write(obj, found, cloth_defaults.on_own_vertices(obj, cloth_defaults.in_steps(weights)),
                           masked=False)
    return welded_skin.materials(obj)


def _skin_and_follow(obj: bpy.types.Object, up: str) -> tuple[np.ndarray | None, np.ndarray | None]:
    """(n,) float32 each, per vertex of the incoming mesh: 1 on skin and its border; and how firmly cloth follows the
    animation without a map. None if there is no skin, or if the build reports an error."""
    base = mesh_reader.base_mesh(obj, "REST_POSE", "")
    found = welded_skin.faces(obj, base)
    if found is None:
        return None, None
    try:
        cloth = cloth_defaults.cloth_at_rest(obj)
        follow = suggested_follow(cloth.surface(True), up)
    except UserError:
        return None, None
    skin = skin_materials.vertices_of(base, found).astype(np.float32)
    return skin, follow[:len(skin)]
