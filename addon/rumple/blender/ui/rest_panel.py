# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Rest Shape": the shape without wrinkles. panels.py registers it."""
from __future__ import annotations

import bpy

from ...core.settings.system_settings import reference_settings
from ..objects import properties
from ..ui_base import Panel, settings_column


class DATA_PT_rumple_rest(Panel, bpy.types.Panel):
    bl_label = "Rest Shape"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        settings = properties.group_of(obj)
        column.prop(settings, "rest_shape")
        if settings.rest_shape == "FRAME":
            row = column.row(align=True)
            row.prop(obj.rumple, "rest_frame")
            row.operator("object.rumple_capture_rest", text="Capture")
        elif settings.rest_shape == "SHAPE_KEY":
            keys = obj.data.shape_keys
            if keys is None:
                column.label(text="This mesh has no shape keys", icon="INFO")
            else:
                column.prop_search(obj.rumple, "rest_key", keys, "key_blocks")
        elif settings.rest_shape == "ADAPTIVE":
            draw_reference(column, settings)


def draw_reference(column: bpy.types.UILayout, settings: bpy.types.PropertyGroup) -> None:
    """Draw the settings of an adaptive rest shape. Wrinkle Paths have them in another panel."""
    if settings.stateless:
        column.label(text="Independent Frames: the rest pose counts", icon="INFO")
    for name in reference_settings(settings):
        column.prop(settings, name)
