# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Paint": every map of an object's wrinkles. panels.py registers it."""
from __future__ import annotations

import bpy

from ..objects import painted_maps, weight_paint
from ..translation import said
from ..ui_base import Panel, draw_note, labelled_row, settings_column
from . import paint_words

NO_FOLDS = "This mask or tool of Weight Paint needs the coarse mesh: folds are shown again after it"


class DATA_PT_rumple_paint(Panel, bpy.types.Panel):
    bl_label = "Paint"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = settings_column(self.layout, context.object), context.object
        column.use_property_split = False
        numbers = painted_maps.measured(obj)
        for painted in painted_maps.of(obj):
            _draw_map(column, obj, painted, numbers.get(painted.key))
        if painted_maps.is_masked(obj):
            draw_note(self.layout, "A mask of Weight Paint is on: only what is selected changes")
        if weight_paint.needs_coarse(obj):
            draw_note(self.layout, NO_FOLDS)


def _draw_map(column: bpy.types.UILayout, obj: bpy.types.Object, painted: painted_maps.PaintedMap,
              numbers: tuple[float, float] | None) -> None:
    row = labelled_row(column, painted.label)
    row.operator("object.rumple_paint", text="", icon="WPAINT_HLT" if painted.exists else "BRUSH_DATA",
                 depress=is_active_map(obj, painted)).group = painted.key
    row.operator("object.rumple_paint_from_border", text="", icon="MOD_EDGESPLIT").group = painted.key
    row.operator("object.rumple_paint_from_texture", text="", icon="TEXTURE").group = painted.key
    row.operator("object.rumple_paint_from_material", text="", icon="MATERIAL").group = painted.key
    of_existing = row.row(align=True)
    of_existing.enabled = painted.exists
    of_existing.operator("object.rumple_paint_invert", text="", icon="ARROW_LEFTRIGHT").group = painted.key
    of_existing.operator("object.rumple_paint_clear", text="", icon="X").group = painted.key
    if numbers is not None:
        row = column.row()
        row.active = False
        row.alignment = "RIGHT"
        row.label(text=said(words(numbers)), translate=False)


def draw_active_map(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """While a map is painted, show the meaning of its weights."""
    for painted in painted_maps.of(obj) if obj.mode == "WEIGHT_PAINT" else ():
        if is_active_map(obj, painted):
            draw_note(layout, paint_words.how(painted), "BRUSH_DATA")


def is_active_map(obj: bpy.types.Object, painted: painted_maps.PaintedMap) -> bool:
    """Whether this map is being painted."""
    active = obj.vertex_groups.active
    return obj.mode == "WEIGHT_PAINT" and active is not None and active.name == painted.name


def words(numbers: tuple[float, float]) -> str:
    """A text about a map: mean 0.62 - 31 % of the vertices. A small share is not rounded to 0."""
    mean, share = numbers
    percent = f"{100.0 * share:.0f}" if share >= 0.005 or share == 0.0 else "< 1"
    return f"mean {mean:.2f} \u00b7 {percent} % of the vertices"
