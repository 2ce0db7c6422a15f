# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of the Wrinkle Maps.

bpy.ops.rumple.maps_add() (or object.rumple_add(method="MAPS")), maps_remove(), maps_show(), maps_hide(), maps_bones(),
maps_keys(), maps_key_remove().
They act on the active mesh, or, while an armature is posed, on the mesh with Wrinkle Maps that it deforms. The
operators of the reference poses are in maps/pose_operators.py.
"""
from __future__ import annotations

from typing import Callable

import bpy

from ... import native
from ...core.base.wording import UserError
from .. import compat, scheduler, ui_base
from ..frame import rebuild as frame_rebuild
from ..translation import said
from . import (bake_source, changes as maps_changes, keys as maps_keys, materials, modifier as maps_modifier,
               rebuild as maps_rebuild, rig as maps_rig)


def target(context: bpy.types.Context) -> bpy.types.Object | None:
    """The object with Wrinkle Maps to work on: the active one, or one that the active armature deforms: if there are
    several, a selected one, else one with poses."""
    active = context.object
    if active is None or active.type != "ARMATURE":
        return active if active is not None and active.type == "MESH" and maps_modifier.find(active) else None
    deformed = [obj for obj, _ in maps_modifier.mapped_objects() if obj.find_armature() == active]
    return min(deformed, key=lambda obj: (not obj.select_get(), not obj.rumple_maps.poses), default=None)


class OnMaps:
    """Operators for an object that has Wrinkle Maps."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = target(context)
        why = ""
        if obj is None:
            why = "Add Wrinkle Maps to a mesh with an armature or shape keys first"
        elif not compat.is_editable(obj):
            why = ui_base.LINKED_OBJECT
        return ui_base.may_run(cls, why)

    def guarded(self, work: Callable[[], None]) -> set[str]:
        """Run the work, and report errors."""
        try:
            work()
        except (UserError, native.NativeMissing) as error:
            return ui_base.refuse(self, error)
        except TypeError:
            obj = target(bpy.context)
            if obj.override_library is None:
                raise
            return ui_base.refuse(self, f"{obj.name}: it is a library override, in which Blender lets lists grow only: "
                                  "mute a pose instead, or change it in the linked file")
        return {"FINISHED"}


class OnPose(OnMaps):
    """Operators for the active reference pose."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        settings = target(context).rumple_maps
        chosen = 0 <= settings.active < len(settings.poses)
        return ui_base.may_run(cls, "" if chosen else "Add a reference pose first")


def add_maps(obj: bpy.types.Object) -> None:
    """Add the modifier, and the node group in the object's materials. If it raises UserError, nothing is changed."""
    maps_rig.refuse_without_pose(obj)
    native.load()
    settings = obj.rumple_maps
    if not settings.is_property_set("bake_source"):
        settings.bake_source = bake_source.suggested(obj, bpy.context.scene)
    with scheduler.suspended():
        nodes_mod = maps_modifier.add(obj)
    maps_rebuild.prepare(obj, nodes_mod)
    maps_rebuild.note_method(obj)


def remove_maps(obj: bpy.types.Object) -> None:
    """Remove the modifier, its hidden objects and the nodes in materials. The reference poses stay with the object."""
    materials.hide(obj)
    maps_modifier.remove(obj)
    frame_rebuild.drop_orphan_outputs()  # the maps may have been the last user of an output object
    maps_rebuild.note_method(obj)
    group = obj.rumple_maps.group
    obj.rumple_maps.group = None
    if group is not None and group.users == 0 and compat.is_editable(group):
        bpy.data.node_groups.remove(group)


class RUMPLE_OT_maps_add(bpy.types.Operator):
    """Add normal maps of reference poses, blended by the pose of the bones and shape keys that deform the mesh"""

    bl_idname = "rumple.maps_add"
    bl_label = "Add Wrinkle Maps"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        why = ""
        if obj is None or obj.type != "MESH":
            why = "Choose a mesh object first"
        elif not compat.is_editable(obj):
            why = ui_base.LINKED_OBJECT
        elif maps_modifier.find(obj) is not None:
            why = "This object has Wrinkle Maps already"
        elif obj.find_armature() is None and not maps_keys.blocks(obj):
            why = "No armature deforms this mesh and it has no shape keys: Wrinkle Maps follow bones or shape keys"
        return ui_base.may_run(cls, why)

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            add_maps(context.object)
        except (UserError, native.NativeMissing) as error:
            return ui_base.refuse(self, error)
        self.report({"INFO"}, said("Next: pose the bones, or set the shape keys, and press Add Reference Pose"))
        context.scene.render.use_lock_interface = True  # because handlers write data while the window draws
        return {"FINISHED"}


class RUMPLE_OT_maps_remove(OnMaps, bpy.types.Operator):
    """Take the Wrinkle Maps off the object and out of its materials. The reference poses stay with the object"""

    bl_idname = "rumple.maps_remove"
    bl_label = "Remove Wrinkle Maps"

    def execute(self, context: bpy.types.Context) -> set[str]:
        remove_maps(target(context))
        return {"FINISHED"}


class RUMPLE_OT_maps_bones(OnMaps, bpy.types.Operator):
    """Compare the selected bones, or, in Object Mode, all bones below the root that deform the mesh"""

    bl_idname = "rumple.maps_bones"
    bl_label = "Choose Bones"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)

        def choose() -> None:
            maps_rig.choose_bones_by_default(obj)
            maps_changes.rig_changed(obj)
        return self.guarded(choose)


class RUMPLE_OT_maps_keys(OnMaps, bpy.types.Operator):
    """Compare all shape keys that move the mesh"""

    bl_idname = "rumple.maps_keys"
    bl_label = "Choose Shape Keys"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)

        def choose() -> None:
            names = maps_keys.moving(obj)
            if not names:
                raise UserError(f"{obj.name}: it has no relative shape keys that move it: add some first")
            maps_keys.choose(obj.rumple_maps.keys, names)
            maps_changes.rig_changed(obj)
        return self.guarded(choose)


class RUMPLE_OT_maps_key_remove(OnMaps, bpy.types.Operator):
    """Do not compare the active shape key"""

    bl_idname = "rumple.maps_key_remove"
    bl_label = "Leave out Shape Key"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        settings = obj.rumple_maps
        if not 0 <= settings.active_key < len(settings.keys):
            return {"CANCELLED"}

        def leave_out() -> None:
            settings.keys.remove(settings.active_key)
            settings.active_key = max(0, min(settings.active_key, len(settings.keys) - 1))
            maps_changes.rig_changed(obj)
        return self.guarded(leave_out)


class RUMPLE_OT_maps_show(OnMaps, bpy.types.Operator):
    """Put the wrinkle maps between the normal map and the shader of every material of the object"""

    bl_idname = "rumple.maps_show"
    bl_label = "Show in Materials"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        maps_changes.rig_changed(obj)  # warnings about its materials may be over
        return self.guarded(lambda: materials.show(obj))


class RUMPLE_OT_maps_hide(OnMaps, bpy.types.Operator):
    """Take the wrinkle maps out of the object's materials again"""

    bl_idname = "rumple.maps_hide"
    bl_label = "Remove from Materials"

    def execute(self, context: bpy.types.Context) -> set[str]:
        refused = materials.hide(target(context))
        if refused:
            self.report({"ERROR"}, said("; ".join(refused)))
        return {"CANCELLED"} if refused else {"FINISHED"}


CLASSES = (RUMPLE_OT_maps_add, RUMPLE_OT_maps_remove, RUMPLE_OT_maps_bones, RUMPLE_OT_maps_keys,
           RUMPLE_OT_maps_key_remove, RUMPLE_OT_maps_show, RUMPLE_OT_maps_hide)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
