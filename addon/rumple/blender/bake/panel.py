# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Bake". ui/panels.py registers it among the others."""
from __future__ import annotations

import bpy

from ..frame import clip_status
from ..objects import modifier
from ..ui_base import Panel, property_column


class DATA_PT_rumple_bake(Panel, bpy.types.Panel):
    bl_label = "Bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = property_column(self.layout), context.object
        for name in ("bake_start", "bake_end", "bake_samples", "bake_folder"):
            column.prop(obj.rumple, name)
        if clip_status.sees_ahead(obj, context.scene):
            column.prop(obj.rumple, "bake_whole_clip")
        row = column.row(align=True)
        row.operator("object.rumple_bake", icon="RENDER_ANIMATION")
        if modifier.is_baked(modifier.find(obj)):
            row.operator("object.rumple_bake_free")
        column.operator("object.rumple_bake_shape_keys")
