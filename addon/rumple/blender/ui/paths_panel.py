# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of the Wrinkle Paths. panels.py registers them."""
from __future__ import annotations

import bpy

from ..frame import path_curves
from ..objects import modifier
from ..ui_base import Panel, draw_setting, named_paint, property_column, settings_column
from . import rest_panel


def draw_size(column: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draw width and height of folds, above all panels."""
    row = draw_setting(column, settings, "width")
    row.operator("object.rumple_width_from_height", text="", icon="OUTLINER_OB_ARMATURE")
    draw_setting(column, settings, "height")


class DATA_PT_rumple_folds(Panel, bpy.types.Panel):
    bl_label = "Folds"
    bl_options = {"DEFAULT_CLOSED"}
    method = "PATHS"

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        settings = obj.rumple.paths
        for name in ("threshold", "direction", "profile", "spacing", "seed"):
            column.prop(settings, name)
        column.separator()
        named_paint(column, obj, "mask", "mask")
        column.separator()
        for name in ("source", "detail", "attachment", "weld", "rigid_parts", "gpu_preview"):
            column.prop(settings, name)
        column.prop(obj.rumple, "most_vertices")


class DATA_PT_rumple_persistence(Panel, bpy.types.Panel):
    bl_label = "Persistence"
    bl_options = {"DEFAULT_CLOSED"}
    method = "PATHS"

    def draw(self, context: bpy.types.Context) -> None:
        column, settings = settings_column(self.layout, context.object), context.object.rumple.paths
        rest_panel.draw_reference(column, settings)
        for name in ("smoothing", "alignment", "reach", "growth_limit", "fade", "hem_rings", "stateless"):
            column.prop(settings, name)


class DATA_PT_rumple_show_paths(Panel, bpy.types.Panel):
    bl_label = "Curves & Overlay"
    bl_options = {"DEFAULT_CLOSED"}
    method = "PATHS"

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = property_column(self.layout), context.object
        shown = bool(path_curves.of(obj))
        column.operator(f"object.rumple_curves_{'remove' if shown else 'add'}", icon="CURVE_DATA")
        row = column.row()
        row.active = not modifier.is_baked(modifier.find(obj))  # a clip uses neither of them
        row.prop(obj.rumple.paths, "show_overlay")
        row = column.row()
        row.active = obj.rumple.paths.show_overlay
        row.prop(obj.rumple.paths, "overlay_opacity")


CLASSES = (DATA_PT_rumple_folds, DATA_PT_rumple_persistence, DATA_PT_rumple_show_paths)
