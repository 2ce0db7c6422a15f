# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Rest Wrinkles" of a Wrinkle Field. panels.py registers it with the other panels."""
from __future__ import annotations

import bpy

from ..objects import mesh_reader
from ..ui_base import Panel
from . import operators as brush_operators, overlay as brush_overlay


class DATA_PT_rumple_rest_wrinkles(Panel, bpy.types.Panel):
    bl_label = "Rest Wrinkles"
    bl_options = {"DEFAULT_CLOSED"}
    method = "FIELD"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        is_active = brush_overlay.is_tool_active(context)
        layout.operator("object.rumple_brush", icon="BRUSH_DATA", depress=is_active)
        if is_active:
            brush_operators.draw_brush(layout.column(), context.scene.rumple_brush)
        row = layout.row(align=True)
        row.operator("object.rumple_scatter", text="Scatter", icon="FORCE_TURBULENCE")
        if mesh_reader.REST_WRINKLE in context.object.data.attributes:
            row.operator("object.rumple_clear_rest_wrinkles", text="Clear", icon="X")
