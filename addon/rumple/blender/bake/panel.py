# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Bake". ui/panels.py registers it with the other panels."""
from __future__ import annotations

import bpy

from ..frame import clip_status
from ..objects import clip_place, modifier
from ..translation import said
from ..ui_base import Panel, draw_note, property_column
from . import duration


def draw_header(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """Above the other panels: which frames are baked, and the button that frees them."""
    if not modifier.is_baked(modifier.find(obj)):
        return
    clip = clip_status.clip_path(obj)
    about = None if clip is None else clip_status.manifest(clip)
    row = layout.row(align=True)
    row.label(text=said("Baked" if about is None else f"Baked {about.start}\u2013{about.end}"), icon="CHECKMARK")
    row.operator("object.rumple_bake_free", text="Free")


def _draw_range(column: bpy.types.UILayout, obj: bpy.types.Object, scene: bpy.types.Scene) -> None:
    """The frame range: greyed if it is that of the scene."""
    column.prop(obj.rumple, "bake_scene_range")
    own = column.column()
    own.enabled = not obj.rumple.bake_scene_range
    for name, of_scene, label in (("bake_start", "frame_start", "Start"), ("bake_end", "frame_end", "End")):
        if own.enabled:
            own.prop(obj.rumple, name)
        else:
            own.prop(scene, of_scene, text=label)


class DATA_PT_rumple_bake(Panel, bpy.types.Panel):
    bl_label = "Bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column, obj = property_column(self.layout), context.object
        _draw_range(column, obj, context.scene)
        for name in ("bake_samples", "bake_folder"):
            column.prop(obj.rumple, name)
        if clip_status.sees_ahead(obj, context.scene):
            column.prop(obj.rumple, "bake_whole_clip")
        if clip_place.of(obj) is None:
            draw_note(self.layout, f"{obj.name}: the file was never saved, so the clip goes to a temporary folder")
        every = duration.bake_all(context.scene)
        for objects in ([obj], every) if len(every) > 1 else ([obj],):
            expected = duration.note(objects, context.scene)
            if expected:
                draw_note(column, expected, "TIME")
        row = column.row(align=True)
        row.operator("object.rumple_bake", icon="RENDER_ANIMATION").every = False
        row.operator("object.rumple_bake", text="Bake All").every = True
        if modifier.is_baked(modifier.find(obj)):
            row.operator("object.rumple_bake_free")
        column.operator("object.rumple_bake_shape_keys")
        row = column.row(align=True)  # these operators are in the folder `farm`
        row.operator("object.rumple_publish", icon="EXPORT")
        row.operator("object.rumple_vat", icon="TEXTURE")
