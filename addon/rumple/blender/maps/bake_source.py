# SPDX-License-Identifier: GPL-3.0-or-later
"""Which wrinkles are baked to Wrinkle Maps where the artist has not chosen any: those of skin, or of a garment."""
from __future__ import annotations

import bpy

from ...core.settings.presets import SKIN_OF_MAPS
from ...core.systems.wrinkle_field import skin_wavelength
from ..first_click import cloth_defaults
from ..objects import mesh_reader, properties, rig_scale


def suggested(obj: bpy.types.Object, scene: bpy.types.Scene) -> str:
    """The system to bake from: that of the object, else the Wrinkle Field for skin and the Wrinkle Mesh for garments.
    Cost: reads the mesh at rest."""
    if obj.rumple.method in properties.SYSTEMS:
        return obj.rumple.method
    return "FIELD" if _is_bare_skin(obj, scene) else "MESH"


def make_skin(obj: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """Give an object settings of skin, unless the artist has set up its system, or it is a garment. Its system is the
    Wrinkle Field or the Wrinkle Mesh."""
    if not _is_bare_skin(obj, scene):
        return
    values = SKIN_OF_MAPS[obj.rumple.method]
    if obj.rumple.method == "FIELD":
        base = mesh_reader.base_mesh(obj, "REST_POSE", "")
        values = values | {"wavelength": skin_wavelength(base, rig_scale.metres_at_rest(obj, scene))}
    properties.apply_values(obj, scene, values)


def _is_bare_skin(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether nobody has changed a setting of the object's system (without one: of the Wrinkle Mesh), and it is no
    garment."""
    settings = properties.group_of(obj)
    untouched = not any(settings.is_property_set(name) for name in properties.fields_of(obj))
    return untouched and not cloth_defaults.defaults(obj, scene)
