# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Body": what a garment is worn over. panels.py registers it among the others."""
from __future__ import annotations

import bpy

from .panel_parts import Panel, property_column


class DATA_PT_rumple_body(Panel, bpy.types.Panel):
    bl_label = "Body"

    def draw(self, context: bpy.types.Context) -> None:
        column = property_column(self.layout)
        column.prop(context.object.rumple, "body")
        column.prop(context.object.rumple, "body_collection")
