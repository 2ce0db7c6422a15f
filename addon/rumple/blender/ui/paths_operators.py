# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the Wrinkle Paths.

bpy.ops.object.rumple_width_from_height(percent=1.0), rumple_curves_add(), rumple_curves_remove().
"""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...core.systems.wrinkle_paths import PERCENT_OF_HEIGHT, width_of_height
from .. import ui_base
from ..frame import path_curves
from ..objects import mesh_reader, modifier, properties
from ..translation import said


class OnPaths(ui_base.OnWrinkled):
    """Operators for an object with Wrinkle Paths."""

    method, other_method = "PATHS", "Only for Wrinkle Paths"


class OBJECT_OT_rumple_width_from_height(OnPaths, bpy.types.Operator):
    """Set the width of the tightest folds from the height of the character: its armature, its parent or itself"""

    bl_idname = "object.rumple_width_from_height"
    bl_label = "Width from Height"

    percent: bpy.props.FloatProperty(name="Percent of Height", default=PERCENT_OF_HEIGHT, min=0.01, max=20.0,
                                     soft_min=0.25, soft_max=4.0, description="Width of the tightest folds, in percent "
                                     "of the character's height")

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        found = character_height(obj)
        if found is None:
            return ui_base.refuse(self, f"{obj.name}: no height to go by: it is flat, and has neither an armature "
                                  "with deforming bones nor a mesh that it is parented to")
        character, height = found
        metres = height * context.scene.unit_settings.scale_length
        width = width_of_height(metres, self.percent)
        properties.apply_values(obj, context.scene, dict(width=width))
        self.report({"INFO"}, said(f"Width {1e3 * width:.3g} mm: {self.percent:g} % of the height of {character.name}, "
                                   f"{metres:.3g} m"))
        return {"FINISHED"}


def character_height(obj: bpy.types.Object) -> tuple[bpy.types.Object, float] | None:
    """The object whose height is used for a garment, and this height: vertical in the world, at rest, scene units."""
    for character in (obj.find_armature(), obj.parent, obj):
        height = _rest_height(character) if character is not None else 0.0
        if height > 0.0:
            return character, height
    return None


def _rest_height(obj: bpy.types.Object) -> float:
    """0 if there is none."""
    if obj.type == "ARMATURE":
        points: Any = [end for bone in obj.data.bones if bone.use_deform for end in (bone.head_local, bone.tail_local)]
    elif obj.type == "MESH":
        points = mesh_reader.rest_positions(obj, "REST_POSE", "")
    else:
        return 0.0
    if not len(points):
        return 0.0
    up = np.array(obj.matrix_world, np.float32)[2]
    return float(np.ptp((np.array(points, np.float32) * up[:3]).sum(1)))


class OBJECT_OT_rumple_curves_add(OnPaths, bpy.types.Operator):
    """Add a child object that shows the paths as curves, with their number, height and width as attributes"""

    bl_idname = "object.rumple_curves_add"
    bl_label = "Add Curves"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        why = ""
        if path_curves.of(context.object):
            why = "There are curves already"
        elif modifier.is_baked(modifier.find(context.object)):
            why = "The folds are baked: free the bake, add the curves, bake again"
        return ui_base.may_run(cls, why)

    def execute(self, context: bpy.types.Context) -> set[str]:
        child = path_curves.add(context.object)
        self.report({"INFO"}, said(f"{child.name} shows the paths"))
        return {"FINISHED"}


class OBJECT_OT_rumple_curves_remove(OnPaths, bpy.types.Operator):
    """Remove the curves of this object's paths, and what was made of them by modifiers"""

    bl_idname = "object.rumple_curves_remove"
    bl_label = "Remove Curves"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        return ui_base.may_run(cls, "" if path_curves.of(context.object) else "There are no curves")

    def execute(self, context: bpy.types.Context) -> set[str]:
        for child in path_curves.of(context.object):
            path_curves.remove(child)
        return {"FINISHED"}


CLASSES = (OBJECT_OT_rumple_width_from_height, OBJECT_OT_rumple_curves_add, OBJECT_OT_rumple_curves_remove)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
