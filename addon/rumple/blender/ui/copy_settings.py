# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies wrinkle settings to several garments."""
from __future__ import annotations

import bpy

from .. import compat, ui_base
from ..objects import modifier, properties
from ..translation import said

OWN = frozenset(("up", "rest_shape", "source"))  # settings of a mesh, not of its cloth


class OBJECT_OT_rumple_copy_settings(ui_base.OnWrinkled, bpy.types.Operator):
    """Copy fabric and sliders to the other selected objects of this system, but not paint, bodies and rest shape"""

    bl_idname = "object.rumple_copy_settings"
    bl_label = "Copy Wrinkle Settings to Selected"

    def execute(self, context: bpy.types.Context) -> set[str]:
        source = context.object
        targets = [obj for obj in context.selected_objects if obj != source and obj.type == "MESH"
                   and compat.is_editable(obj) and modifier.find(obj) is not None
                   and obj.rumple.method == source.rumple.method]
        if not targets:
            return ui_base.refuse(self, f"Select other objects with a {said(properties.system_of(source).label)} too")
        group = properties.group_of(source)
        names = [name for name in properties.fields_of(source) if name not in OWN]
        for obj in targets:
            to = properties.group_of(obj)
            for name in (*names, *(name for name in ("preset", "preset_replaced") if hasattr(group, name))):
                if getattr(to, name) != getattr(group, name) or group.is_property_set(name):
                    setattr(to, name, getattr(group, name))
            obj.rumple.most_vertices = source.rumple.most_vertices
            obj.rumple.viewport_steps = source.rumple.viewport_steps
        self.report({"INFO"}, said(f"{source.name}: settings copied to {', '.join(obj.name for obj in targets)}"))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_rumple_copy_settings,))
