# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the reference poses, in the modifier tab of the mesh and, for posing, in the sidebar of the 3D view."""
from __future__ import annotations

from typing import Any

import bpy

from ..nodes import maps_shader
from ..ui_base import draw_message, draw_note
from . import modifier as maps_modifier, operators as maps_operators, runtimes as maps_runtimes, stored_poses


class RUMPLE_UL_poses(bpy.types.UIList):
    """Name, map, how present the pose is, solo and mute."""

    def draw_item(self, _context: bpy.types.Context, layout: bpy.types.UILayout, _data: Any, pose: Any, _icon: int,
                  _active_data: Any, _active_property: str, _index: int = 0) -> None:
        split = layout.split(factor=0.55, align=True)  # otherwise the sidebar shows only two letters of the name
        split.prop(pose, "name", text="", emboss=False, icon="ARMATURE_DATA" if pose.image is None else "IMAGE_DATA")
        row = split.row(align=True)
        bar = row.row()
        bar.enabled = False
        bar.prop(pose, "present", text="", slider=True)
        row.prop(pose, "solo", text="", icon="SOLO_ON" if pose.solo else "SOLO_OFF", emboss=False)
        row.prop(pose, "muted", text="", icon="HIDE_ON" if pose.muted else "HIDE_OFF", emboss=False)


class RUMPLE_UL_tracked_keys(bpy.types.UIList):
    """Name and group."""

    def draw_item(self, _context: bpy.types.Context, layout: bpy.types.UILayout, _data: Any, key: Any, _icon: int,
                  _active_data: Any, _active_property: str, _index: int = 0) -> None:
        row = layout.row(align=True)
        row.label(text=key.name, icon="SHAPEKEY_DATA")
        row.prop(key, "group", text="")


class RUMPLE_UL_tracked_bones(bpy.types.UIList):
    """Name, which end is followed, and the group."""

    def draw_item(self, _context: bpy.types.Context, layout: bpy.types.UILayout, _data: Any, bone: Any, _icon: int,
                  _active_data: Any, _active_property: str, _index: int = 0) -> None:
        row = layout.row(align=True)
        row.label(text=bone.name, icon="BONE_DATA")
        row.prop(bone, "tracked", text="")
        row.prop(bone, "group", text="")


class _Maps:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "modifier"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and context.object.type == "MESH" and \
            maps_modifier.find(context.object) is not None

    def object(self, context: bpy.types.Context) -> bpy.types.Object:
        return maps_operators.target(context)


class _InSidebar(_Maps):
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Rumple"
    bl_context = ""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return maps_operators.target(context) is not None


class _Poses(_Maps):
    bl_label = "Wrinkle Maps"

    def draw(self, context: bpy.types.Context) -> None:
        layout, obj = self.layout, self.object(context)
        settings = obj.rumple_maps
        draw_message(layout, maps_runtimes.message(obj))
        row = layout.row(align=True)
        row.operator("rumple.pose_add", icon="ADD")
        row.operator("rumple.maps_remove", text="", icon="X")
        row = layout.row()
        row.template_list("RUMPLE_UL_poses", "", settings, "poses", settings, "active", rows=4)
        side = row.column(align=True)
        side.operator("rumple.pose_remove", text="", icon="REMOVE")
        side.separator()
        side.operator("rumple.pose_move", text="", icon="TRIA_UP").direction = "UP"
        side.operator("rumple.pose_move", text="", icon="TRIA_DOWN").direction = "DOWN"
        row = layout.row(align=True)
        row.operator("rumple.pose_go").neutral = False
        row.operator("rumple.pose_update", text="Update")
        if 0 <= settings.active < len(settings.poses):
            pose = settings.poses[settings.active]
            layout.template_ID(pose, "image", new="image.new", open="image.open")
            layout.prop(pose, "strength", slider=True)
        column = layout.column(align=True)
        captured = stored_poses.is_captured(settings)
        column.label(text="Neutral: captured" if captured else "Neutral: rest pose")
        row = column.row(align=True)
        row.operator("rumple.pose_go", text="Go").neutral = True
        row.operator("rumple.neutral_capture", text="Capture")
        if captured:
            row.operator("rumple.neutral_rest", text="", icon="X")


class _Shading(_Maps):
    bl_label = "Shading"

    def draw(self, context: bpy.types.Context) -> None:
        layout, obj = self.layout, self.object(context)
        settings = obj.rumple_maps
        layout.use_property_split, layout.use_property_decorate = True, False
        materials = [slot.material for slot in obj.material_slots if slot.material is not None]
        shown = settings.group is not None and any(maps_shader.shown_in(m) == settings.group for m in materials)
        layout.operator("rumple.maps_show", icon="NODE_MATERIAL")
        if shown:
            layout.operator("rumple.maps_hide")
        layout.prop(settings, "maps")
        layout.prop(settings, "gain")
        layout.prop_search(settings, "uv_map", obj.data, "uv_layers")
        layout.prop(settings, "show_influences")


class _Bones(_Maps):
    bl_label = "Bones"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _Maps.poll(context) and (context.object.find_armature() is not None
                                        or len(context.object.rumple_maps.bones) > 0)

    def draw(self, context: bpy.types.Context) -> None:
        layout, obj = self.layout, self.object(context)
        settings, armature = obj.rumple_maps, obj.find_armature()
        if armature is not None:
            layout.prop_search(settings, "root", armature.data, "bones")
        layout.template_list("RUMPLE_UL_tracked_bones", "", settings, "bones", settings, "active_bone", rows=4)
        layout.operator("rumple.maps_bones")


class _Keys(_Maps):
    bl_label = "Shape Keys"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _Maps.poll(context) and (context.object.data.shape_keys is not None
                                        or len(context.object.rumple_maps.keys) > 0)

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = self.layout, self.object(context).rumple_maps
        row = layout.row()
        row.template_list("RUMPLE_UL_tracked_keys", "", settings, "keys", settings, "active_key", rows=4)
        row.operator("rumple.maps_key_remove", text="", icon="REMOVE")
        layout.operator("rumple.maps_keys")


class _Bake(_Maps):
    bl_label = "Bake Maps"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = self.layout, self.object(context).rumple_maps
        layout.use_property_split, layout.use_property_decorate = True, False
        for name in ("bake_source", "bake_size", "bake_margin", "bake_cage", "bake_deep", "bake_folder"):
            layout.prop(settings, name)
        row = layout.row(align=True)
        row.operator("rumple.maps_bake", icon="RENDER_STILL")
        row.operator("rumple.maps_bake", text="All Poses").every = True
        row = layout.row(align=True)
        row.operator("rumple.maps_export", icon="EXPORT")
        row.operator("rumple.maps_weights")


class _Status(_Maps):
    bl_label = "Status"

    def draw(self, context: bpy.types.Context) -> None:
        runtime = maps_runtimes.of(self.object(context))
        lines = list(runtime.notes)
        if runtime.comparison is not None:
            model = runtime.comparison.model
            keys = len(runtime.comparison.rig.keys)
            lines.insert(0, f"{model.bone_count - keys} bones, {keys} shape keys, {model.pose_count} poses, "
                         f"{model.vertex_count} vertices")
        for line in lines:
            draw_note(self.layout, line)


def _panel(body: Any, place: type, name: str, parent: str = "") -> type:
    """Make a panel class from its content and its place."""
    members = {"bl_idname": name, "bl_label": body.bl_label, "draw": body.draw, "bl_order": 101,
               "bl_options": getattr(body, "bl_options", set())}
    if parent:
        members["bl_parent_id"] = parent
    if "poll" in vars(body):
        members["poll"] = vars(body)["poll"]
    return type(name, (place, bpy.types.Panel), members)


CLASSES = (RUMPLE_UL_poses, RUMPLE_UL_tracked_bones, RUMPLE_UL_tracked_keys,
           _panel(_Poses, _Maps, "DATA_PT_rumple_maps"),
           _panel(_Shading, _Maps, "DATA_PT_rumple_maps_shading", "DATA_PT_rumple_maps"),
           _panel(_Bones, _Maps, "DATA_PT_rumple_maps_bones", "DATA_PT_rumple_maps"),
           _panel(_Keys, _Maps, "DATA_PT_rumple_maps_keys", "DATA_PT_rumple_maps"),
           _panel(_Bake, _Maps, "DATA_PT_rumple_maps_bake", "DATA_PT_rumple_maps"),
           _panel(_Status, _Maps, "DATA_PT_rumple_maps_status", "DATA_PT_rumple_maps"),
           _panel(_Poses, _InSidebar, "VIEW3D_PT_rumple_maps"),
           _panel(_Shading, _InSidebar, "VIEW3D_PT_rumple_maps_shading", "VIEW3D_PT_rumple_maps"))

register, unregister = bpy.utils.register_classes_factory(CLASSES)
