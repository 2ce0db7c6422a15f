# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Guides": the artist's hand in the folds of every system. panels.py registers it among the others."""
from __future__ import annotations

import bpy

from ...core.keep_smooth import SMOOTH
from ..ui_base import Panel, settings_column
from . import cloth_panel


class DATA_PT_rumple_guides(Panel, bpy.types.Panel):
    bl_label = "Guides"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        row = column.row(align=True)
        row.label(text="Keep Smooth")
        cloth_panel.paint_button(row, obj, SMOOTH)
