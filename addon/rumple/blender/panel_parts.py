# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels in the modifier tab have in common."""
from __future__ import annotations

import bpy

from . import modifier, properties


class Panel:
    """A panel below DATA_PT_rumple."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "modifier"
    bl_parent_id = "DATA_PT_rumple"
    method: str | None = None  # that it belongs to; None: all

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        return obj is not None and obj.type == "MESH" and modifier.find(obj) is not None and (
            cls.method is None or obj.rumple.method == cls.method)


def property_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """Names on the left, values on the right."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout.column()


def named_paint(column: bpy.types.UILayout, obj: bpy.types.Object, name: str, group: str) -> None:
    """The name of a vertex group or an attribute, and the button that paints the group."""
    row = column.row(align=True)
    row.prop(properties.group_of(obj), name)
    exists = getattr(properties.group_of(obj), name) in obj.vertex_groups
    row.operator("object.rumple_paint", text="", icon="WPAINT_HLT" if exists else "BRUSH_DATA").group = group
