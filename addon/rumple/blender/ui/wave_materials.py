# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators for the materials that draw a Wrinkle Field: bpy.ops.object.rumple_shade(), rumple_unshade()."""
from __future__ import annotations

import bpy

from .. import scheduler, ui_base
from ..nodes import field_shader
from ..objects import runtimes
from ..translation import said


def unshaded(obj: bpy.types.Object) -> list[str]:
    """A message about the first material that should draw the waves but cannot."""
    return [f"{obj.name}: the material \"{material.name}\" shows no waves, for its shader is inside of a node group: "
            "connect a shader outside of it, or set Output to Geometry" if field_shader.has_shader_groups(material) else
            f"{obj.name}: the material \"{material.name}\" shows no waves, for it has no shader that takes a normal: "
            "connect a Principled BSDF, or set Output to Geometry"
            for material in field_shader.materials_of(obj) if not field_shader.shows_waves(material)][:1]


class _OnWaves(ui_base.OnWrinkled):
    """Operators for the materials of an object with a Wrinkle Field."""

    method, other_method = "FIELD", "Only the Wrinkle Field is drawn by materials"


class OBJECT_OT_rumple_shade(_OnWaves, bpy.types.Operator):
    """Let the materials of the object draw the waves, by a node group in front of their normals and textures"""

    bl_idname = "object.rumple_shade"
    bl_label = "Add to Materials"

    def execute(self, context: bpy.types.Context) -> set[str]:
        field_shader.shade_object(context.object)
        materials = field_shader.materials_of(context.object)
        runtimes.of(context.object).stale = True  # the output object needs the new slots
        scheduler.sync_all()
        if not materials:
            return ui_base.refuse(self, f"{context.object.name}: its materials are linked from another file")
        for note in unshaded(context.object):
            self.report({"WARNING"}, said(note))
        count = sum(map(field_shader.shows_waves, materials))
        self.report({"INFO"}, said(f"{count} material(s) show the waves"))
        return {"FINISHED"}


class OBJECT_OT_rumple_unshade(_OnWaves, bpy.types.Operator):
    """Take the waves out of the materials of the object again"""

    bl_idname = "object.rumple_unshade"
    bl_label = "Remove from Materials"

    def execute(self, context: bpy.types.Context) -> set[str]:
        field_shader.unshade_object(context.object, [])
        return {"FINISHED"}


CLASSES = (OBJECT_OT_rumple_shade, OBJECT_OT_rumple_unshade)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
