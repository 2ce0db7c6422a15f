# SPDX-License-Identifier: GPL-3.0-or-later
"""The entries of Add Modifier, and the menu Object > Wrinkles, through which F3 finds all commands of the panels."""
from __future__ import annotations

import bpy

from ...core.systems.all_systems import SYSTEMS
from .. import compat, ui_base
from ..translation import said
from . import examples, panels, thumbnails

# Groups of operators, by their names in bpy.ops. A property name after an operator makes a submenu. A text after the
# property makes an entry with this text that sets the property.
_ENTRIES = (
    ("object.rumple_preset preset", "object.rumple_paint group", "object.rumple_copy_settings",
     "object.rumple_capture_rest", "object.rumple_width_from_height"),
    ("object.rumple_paint_clear group", "object.rumple_paint_invert group", "object.rumple_paint_from_border group",
     "object.rumple_paint_from_texture group", "object.rumple_paint_from_material group"),
    ("object.rumple_bake", "object.rumple_bake every Bake All", "object.rumple_bake_free",
     "object.rumple_bake_shape_keys", "object.rumple_clear_frames", "object.rumple_publish", "object.rumple_vat"),
    ("object.rumple_shade", "object.rumple_unshade", "object.rumple_brush", "object.rumple_scatter",
     "object.rumple_clear_rest_wrinkles"),
    ("object.rumple_guide_add", "object.rumple_guide_remove"),
    ("object.rumple_curves_add", "object.rumple_curves_remove"),
    ("rumple.pose_add", "rumple.pose_update", "rumple.pose_go", "rumple.pose_remove", "rumple.neutral_capture",
     "rumple.neutral_rest", "rumple.maps_bones", "rumple.maps_keys", "rumple.maps_key_remove", "rumple.maps_show",
     "rumple.maps_hide", "rumple.maps_bake", "rumple.maps_export", "rumple.maps_weights", "rumple.maps_remove"),
    ("object.rumple_apply", "object.rumple_remove"),
)


class OBJECT_MT_rumple_add(bpy.types.Menu):
    bl_label = "Wrinkles"

    def draw(self, context: bpy.types.Context) -> None:
        obj = context.object
        why = ui_base.refusal(obj, wrinkled=False)
        if why:
            self.layout.label(text=said(why), icon="INFO", translate=False)
        systems = [] if why else list(SYSTEMS.values())
        maps = panels.may_get_maps(obj)
        entries = thumbnails.beside_pictures(self.layout, [system.method for system in systems] + ["MAPS"] * maps)
        for system in systems:
            entries.operator("object.rumple_add", text=system.label,
                             icon=panels.ICONS[system.method]).method = system.method
        if maps:
            entries.operator("rumple.maps_add", text="Wrinkle Maps", icon="ARMATURE_DATA")
        examples.draw_menu(self.layout)


class OBJECT_MT_rumple(bpy.types.Menu):
    bl_label = "Wrinkles"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.menu("OBJECT_MT_rumple_add", text="Add Wrinkles")
        for group in _ENTRIES:
            self.layout.separator()
            for operator, choice, text in ((*entry.split(" ", 2), "", "")[:3] for entry in group):
                if text:
                    setattr(self.layout.operator(operator, text=text), choice, True)
                elif choice:
                    self.layout.operator_menu_enum(operator, choice)
                else:
                    self.layout.operator(operator)


def _add_entry(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    if context.object is not None and context.object.type == "MESH":
        self.layout.menu("OBJECT_MT_rumple_add", icon="MOD_CLOTH")


def _object_entry(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    if context.object is not None and context.object.type == "MESH":
        self.layout.separator()
        self.layout.menu("OBJECT_MT_rumple", icon="MOD_CLOTH")


_register, _unregister = bpy.utils.register_classes_factory((OBJECT_MT_rumple_add, OBJECT_MT_rumple))


def register() -> None:
    _register()
    if compat.HAS_MODIFIER_MENU:
        bpy.types.OBJECT_MT_modifier_add.append(_add_entry)
    else:
        bpy.types.DATA_PT_modifiers.prepend(_add_entry)
    bpy.types.VIEW3D_MT_object.append(_object_entry)


def unregister() -> None:
    bpy.types.VIEW3D_MT_object.remove(_object_entry)
    if compat.HAS_MODIFIER_MENU:
        bpy.types.OBJECT_MT_modifier_add.remove(_add_entry)
    else:
        bpy.types.DATA_PT_modifiers.remove(_add_entry)
    _unregister()
