# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels "Cloth" and "Body": settings of the cloth that carries the wrinkles. panels.py registers them."""
from __future__ import annotations

import bpy

from ...core.paint.hangs_free import FREE
from ..objects import mesh_reader, properties, units
from ..ui_base import Panel, draw_note, draw_setting, labelled_row, settings_column


class DATA_PT_rumple_cloth(Panel, bpy.types.Panel):
    bl_label = "Cloth"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        settings = properties.group_of(obj)
        if obj.rumple.method == "MESH":
            _draw_layers(column, obj)
            column.separator()
        column.prop(settings, "base_cloth")
        if settings.base_cloth == "OFF":
            return
        if settings.base_cloth == "SWING":
            _draw_swing(column, settings)
        if obj.rumple.method != "MESH":
            column.prop(settings, "drape")
        for name in ("slack", "bending_length", "gravity"):
            draw_setting(column, settings, name)
        painted(column, obj, "room")
        draw_setting(column, settings, "slide_room")
        draw_setting(column, settings, "free_room")
        paint_only(column, obj, FREE, "Hangs Free")
        paint_only(column, obj, "follow", "Pinned to the animation")
        if mesh_reader.MESH_GROUPS["follow"] not in obj.vertex_groups:
            column.prop(settings, "up")


def _draw_layers(column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """Draw the layers of the Wrinkle Mesh. Their amounts are above: panels.py."""
    settings = obj.rumple.mesh
    column.prop(settings, "layers")
    if settings.layers == "CLOTH" and not properties.settings_of(obj, units.scene_of(obj)).layered:
        draw_note(column, "Layers need Fine Mesh Subdivision, and a Rest Shape that is not Adaptive")


def _draw_swing(column: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    if settings.stateless:
        draw_note(column, "With Independent Frames on, cloth does not swing")
        return
    for name in ("mass", "swing_damping", "substeps", "locomotion", "drag"):
        column.prop(settings, name)
    column.separator()


class DATA_PT_rumple_body(Panel, bpy.types.Panel):
    bl_label = "Body"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = settings_column(self.layout, context.object)
        column.prop(context.object.rumple, "body")
        column.prop(context.object.rumple, "body_collection")
        for name in ("thickness", "friction"):
            draw_setting(column, properties.group_of(context.object), name)


def painted(column: bpy.types.UILayout, obj: bpy.types.Object, name: str) -> None:
    """Draw a setting, and the button that paints where it acts."""
    paint_button(draw_setting(column, properties.group_of(obj), name), obj, name)


def paint_only(column: bpy.types.UILayout, obj: bpy.types.Object, name: str, label: str) -> None:
    """Draw a row for a map without a setting, with label and button in the same columns as other rows."""
    paint_button(labelled_row(column, label), obj, name)


def paint_button(row: bpy.types.UILayout, obj: bpy.types.Object, name: str) -> None:
    """A button that paints a vertex group of the Wrinkle Mesh or of the base cloth."""
    exists = mesh_reader.MESH_GROUPS[name] in obj.vertex_groups
    row.operator("object.rumple_paint", text="", icon="WPAINT_HLT" if exists else "BRUSH_DATA").group = name
