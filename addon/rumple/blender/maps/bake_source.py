# SPDX-License-Identifier: GPL-3.0-or-later
"""Which wrinkles are baked to Wrinkle Maps where the artist has not chosen any: those of skin, or of a garment."""
from __future__ import annotations

from dataclasses import fields
from typing import Any

import bpy

from ...core.settings.presets import SKIN_OF_MAPS
from ...core.systems.all_systems import SYSTEMS
from ...core.systems.wrinkle_field import skin_wavelength
from ..first_click import set_up
from ..objects import mesh_reader, rig_scale
from . import rig as maps_rig


def suggested(obj: bpy.types.Object, scene: bpy.types.Scene) -> str:
    """The system to bake from: that of the object, else the Wrinkle Field for skin and the Wrinkle Mesh for garments.
    Cost: that of becomes_cloth()."""
    if obj.rumple.method in SYSTEMS:
        return obj.rumple.method
    return "FIELD" if _is_untouched(obj, "MESH") and not _is_garment(obj, scene) else "MESH"


def skin_settings(obj: bpy.types.Object, scene: bpy.types.Scene, source: str) -> dict[str, Any]:
    """Settings of skin for a system; none if the artist has set this system up, or the object is a garment. Lengths in
    metres."""
    if source not in SKIN_OF_MAPS or not _is_untouched(obj, source) or _is_garment(obj, scene):
        return {}
    values = SKIN_OF_MAPS[source]
    if source != "FIELD":
        return values
    base = mesh_reader.base_mesh(obj, "REST_POSE", "")
    return values | {"wavelength": skin_wavelength(base, rig_scale.metres_at_rest(obj, scene))}


def _is_untouched(obj: bpy.types.Object, source: str) -> bool:
    """Whether nobody has changed a setting of a system."""
    settings = getattr(obj.rumple, SYSTEMS[source].group)
    return not any(settings.is_property_set(one.name) for one in fields(SYSTEMS[source].settings))


def _is_garment(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether the first click would make it cloth. A head with open eye sockets has as many openings as a shirt, but
    bones of a face."""
    return not maps_rig.is_face(obj) and set_up.becomes_cloth(obj, scene)
