# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Guides": direct control of folds in every system. panels.py registers it."""
from __future__ import annotations

import bpy

from ...core.paint.keep_smooth import SMOOTH
from ...core.paint.painted_rigid import RIGID
from ..objects import guide_curves
from ..ui_base import Panel, draw_setting, settings_column
from . import cloth_panel


class DATA_PT_rumple_guides(Panel, bpy.types.Panel):
    bl_label = "Guides"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        cloth_panel.paint_only(column, obj, SMOOTH, "Keep Smooth")
        cloth_panel.paint_only(column, obj, RIGID, "Rigid")
        if guide_curves.make_folds(obj) and obj.rumple.method == "FIELD" and obj.rumple.field.output == "SHADING":
            column.label(text="Guides need the output Geometry", icon="INFO")
        for guide in guide_curves.of(obj):
            _draw_guide(column.box().column(), guide)
        column.operator("object.rumple_guide_add", icon="CURVE_DATA")
        draw_setting(column, obj.rumple_guide, "seam_depth")
        spacing = column.column()
        spacing.active = obj.rumple_guide.seam_depth > 0.0
        draw_setting(spacing, obj.rumple_guide, "seam_spacing")


def _draw_guide(column: bpy.types.UILayout, guide: bpy.types.Object) -> None:
    row = column.row()
    row.label(text=guide.name, icon="CURVE_DATA", translate=False)
    row.operator("object.rumple_guide_remove", text="", icon="X").name = guide.name
    turns = guide.rumple_guide.kind == "DIRECTION"
    for name in ("kind", "reach", "others") if turns else ("kind", "count", "spacing", "depth", "others"):
        draw_setting(column, guide.rumple_guide, name)
