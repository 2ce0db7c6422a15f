# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the Wrinkle Maps.

bpy.ops.rumple.maps_add() (or object.rumple_add(method="MAPS")), maps_remove(), maps_show(), maps_hide(), maps_bones(),
pose_add(name="Surprise"), pose_update(), pose_remove(), pose_move(direction="UP"), pose_go(), pose_go(neutral=True),
neutral_capture(), neutral_rest(). Renaming, muting and solo are properties of object.rumple_maps.poses[...]. They act
on the active mesh or, while its armature is posed, on the mesh with Wrinkle Maps that it deforms.
"""
from __future__ import annotations

from typing import Callable

import bpy

from .. import native
from ..core.engine import Refused
from ..core.poses import MOST_POSES, PoseComparison
from . import maps_live, maps_nodes, maps_rig, maps_tree, structure, versions
from .maps_properties import unused_name


def target(context: bpy.types.Context) -> bpy.types.Object | None:
    """The object with Wrinkle Maps that is meant: the active one, or what the active armature deforms."""
    active = context.object
    if active is None or active.type != "ARMATURE":
        return active if active is not None and active.type == "MESH" and maps_tree.find(active) else None
    return next((obj for obj, _ in maps_tree.mapped_objects() if obj.find_armature() == active), None)


class OnMaps:
    """Operators for an object that has Wrinkle Maps."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = target(context)
        why = ""
        if obj is None:
            why = "Add Wrinkle Maps to a mesh that an armature deforms first"
        elif not versions.is_editable(obj):
            why = "This object is linked from another file: make a library override or append it"
        if why:
            cls.poll_message_set(why)
        return not why

    def guarded(self, work: Callable[[], None]) -> set[str]:
        """Run; what is refused is reported."""
        try:
            work()
        except (Refused, native.NativeMissing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class OnPose(OnMaps):
    """Operators for the active reference pose."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        settings = target(context).rumple_maps
        if 0 <= settings.active < len(settings.poses):
            return True
        cls.poll_message_set("Add a reference pose first")
        return False


def add_maps(obj: bpy.types.Object) -> None:
    """Put the modifier on and show the group in the object's materials. Raises Refused and changes nothing."""
    maps_rig.armature_of(obj)
    native.load()
    with structure.half_done():
        ours = maps_tree.add(obj)
    maps_live.prepare(obj, ours)


def remove_maps(obj: bpy.types.Object) -> None:
    """Modifier, carrier and the nodes in materials; the reference poses stay with the object."""
    hide(obj)
    maps_tree.remove(obj)
    group = obj.rumple_maps.group
    obj.rumple_maps.group = None
    if group is not None and group.users == 0 and versions.is_editable(group):
        bpy.data.node_groups.remove(group)


def show(obj: bpy.types.Object) -> None:
    """The node group in all materials of the object. Raises Refused after the others for what cannot take it."""
    settings = obj.rumple_maps
    if settings.group is None:
        settings.group = maps_nodes.new_group(obj.name)
    maps_nodes.fill(settings.group, maps_rig.usable_images(obj), settings.maps, settings.uv_map)
    refused = []
    materials = {slot.material for slot in obj.material_slots if slot.material is not None}
    for material in sorted(materials, key=lambda material: material.name):
        try:
            maps_nodes.insert(material, settings.group)
        except Refused as error:
            refused.append(str(error))
    if not materials:
        refused.append(f"{obj.name}: it has no material that could show wrinkle maps")
    if refused:
        raise Refused("; ".join(refused))


def hide(obj: bpy.types.Object) -> None:
    """Take this object's node group out of its materials."""
    for slot in obj.material_slots:
        material = slot.material
        if material is not None and maps_nodes.shown_in(material) == obj.rumple_maps.group is not None:
            maps_nodes.remove(material)


def _posed(context: bpy.types.Context, obj: bpy.types.Object) -> bpy.types.Object:
    armature = maps_rig.armature_of(obj)
    return armature.evaluated_get(context.evaluated_depsgraph_get())


def _refuse_bad(obj: bpy.types.Object) -> None:
    """Raises Refused where the stored poses cannot be compared: two that are equal, one that is the neutral pose."""
    rig, _ = maps_rig.rig_of(obj)
    PoseComparison.build(rig, maps_rig.weights_of(obj, rig))


class RUMPLE_OT_maps_add(bpy.types.Operator):
    """Add normal maps of reference poses, blended by the pose of the bones that deform the mesh"""

    bl_idname = "rumple.maps_add"
    bl_label = "Wrinkle Maps"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        why = ""
        if obj is None or obj.type != "MESH":
            why = "Choose a mesh object first"
        elif not versions.is_editable(obj):
            why = "This object is linked from another file: make a library override or append it"
        elif maps_tree.find(obj) is not None:
            why = "This object has Wrinkle Maps already"
        elif obj.find_armature() is None:
            why = "No armature deforms this mesh: Wrinkle Maps follow bones"
        if why:
            cls.poll_message_set(why)
        return not why

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            add_maps(context.object)
        except (Refused, native.NativeMissing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.scene.render.use_lock_interface = True  # handlers write while the window draws
        return {"FINISHED"}


class RUMPLE_OT_maps_remove(OnMaps, bpy.types.Operator):
    """Take the Wrinkle Maps off the object and out of its materials. The reference poses stay with the object"""

    bl_idname = "rumple.maps_remove"
    bl_label = "Remove Wrinkle Maps"

    def execute(self, context: bpy.types.Context) -> set[str]:
        remove_maps(target(context))
        return {"FINISHED"}


class RUMPLE_OT_pose_add(OnMaps, bpy.types.Operator):
    """Store the present pose of the armature as a reference pose"""

    bl_idname = "rumple.pose_add"
    bl_label = "Add Reference Pose"

    name: bpy.props.StringProperty(name="Name", default="Pose", maxlen=48,
                                   description="Taken names get a number, as everywhere in Blender")

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.guarded(lambda: self._add(context, target(context)))

    def _add(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        settings = obj.rumple_maps
        if len(settings.poses) == MOST_POSES:
            raise Refused(f"{obj.name}: there are {MOST_POSES} reference poses already")
        posed = _posed(context, obj)
        if not settings.bones:
            maps_rig.choose_by_default(obj)
        name = unused_name(self.name, [pose.name for pose in settings.poses])
        pose = settings.poses.add()
        maps_rig.store(pose.bones, posed)
        pose.name = name
        try:
            _refuse_bad(obj)
        except Refused:
            settings.poses.remove(len(settings.poses) - 1)
            raise
        settings.active = len(settings.poses) - 1
        maps_live.maps_changed(obj)


class RUMPLE_OT_pose_update(OnPose, bpy.types.Operator):
    """Store the present pose in place of the active reference pose; its name and map stay"""

    bl_idname = "rumple.pose_update"
    bl_label = "Update Reference Pose"

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.guarded(lambda: self._update(context, target(context)))

    def _update(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        pose = obj.rumple_maps.poses[obj.rumple_maps.active]
        _replace(obj, pose.bones, _posed(context, obj))


def _replace(obj: bpy.types.Object, records: bpy.types.bpy_prop_collection, posed: bpy.types.Object) -> None:
    """Store a pose over another; the former comes back where the new one is refused."""
    former = [(r.name, tuple(r.head), tuple(r.tail), tuple(r.matrix), tuple(r.basis)) for r in records]
    maps_rig.store(records, posed)
    try:
        if obj.rumple_maps.poses:
            _refuse_bad(obj)
    except Refused:
        records.clear()
        for name, *values in former:
            record = records.add()
            record.name = name
            record.head, record.tail, record.matrix, record.basis = values
        raise
    maps_live.rig_changed(obj)


class RUMPLE_OT_pose_remove(OnPose, bpy.types.Operator):
    """Delete the active reference pose; its image stays in the file"""

    bl_idname = "rumple.pose_remove"
    bl_label = "Delete Reference Pose"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        settings = obj.rumple_maps
        settings.poses.remove(settings.active)
        settings.active = max(0, min(settings.active, len(settings.poses) - 1))
        maps_live.maps_changed(obj)
        return {"FINISHED"}


class RUMPLE_OT_pose_move(OnPose, bpy.types.Operator):
    """Move the active reference pose in the list"""

    bl_idname = "rumple.pose_move"
    bl_label = "Move Reference Pose"

    direction: bpy.props.EnumProperty(name="Direction", items=(("UP", "Up", ""), ("DOWN", "Down", "")))

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        settings = obj.rumple_maps
        place = settings.active + (1 if self.direction == "DOWN" else -1)
        if not 0 <= place < len(settings.poses):
            return {"CANCELLED"}
        settings.poses.move(settings.active, place)
        settings.active = place
        maps_live.maps_changed(obj)
        return {"FINISHED"}


class RUMPLE_OT_pose_go(OnMaps, bpy.types.Operator):
    """Put the armature into the active reference pose. Nothing is keyed"""

    bl_idname = "rumple.pose_go"
    bl_label = "Go to Pose"

    neutral: bpy.props.BoolProperty(name="Neutral", description="Go to the neutral pose instead", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        settings, armature = obj.rumple_maps, obj.find_armature()
        if not self.neutral and not 0 <= settings.active < len(settings.poses):
            self.report({"ERROR"}, f"{obj.name}: there is no reference pose to go to")
            return {"CANCELLED"}
        if self.neutral and not settings.neutral:
            maps_rig.go_to_rest(armature)
            missing = []
        else:
            records = settings.neutral if self.neutral else settings.poses[settings.active].bones
            missing = maps_rig.go_to(records, armature)
        if missing:
            self.report({"WARNING"}, f"{armature.name} has no bone {', '.join(missing)}: renamed or deleted?")
        context.view_layer.update()
        return {"FINISHED"}


class RUMPLE_OT_neutral_capture(OnMaps, bpy.types.Operator):
    """Take the present pose as the neutral one, which shows no wrinkles"""

    bl_idname = "rumple.neutral_capture"
    bl_label = "Capture Neutral Pose"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        return self.guarded(lambda: _replace(obj, obj.rumple_maps.neutral, _posed(context, obj)))


class RUMPLE_OT_neutral_rest(OnMaps, bpy.types.Operator):
    """Take the rest pose of the armature as the neutral one"""

    bl_idname = "rumple.neutral_rest"
    bl_label = "Neutral Is Rest"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        obj.rumple_maps.neutral.clear()
        maps_live.rig_changed(obj)
        return {"FINISHED"}


class RUMPLE_OT_maps_bones(OnMaps, bpy.types.Operator):
    """Compare the selected bones, or, in Object Mode, all bones below the root that deform the mesh"""

    bl_idname = "rumple.maps_bones"
    bl_label = "Choose Bones"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)

        def choose() -> None:
            maps_rig.choose_by_default(obj)
            maps_live.rig_changed(obj)
        return self.guarded(choose)


class RUMPLE_OT_maps_show(OnMaps, bpy.types.Operator):
    """Put the wrinkle maps between the normal map and the shader of every material of the object"""

    bl_idname = "rumple.maps_show"
    bl_label = "Show in Materials"

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.guarded(lambda: show(target(context)))


class RUMPLE_OT_maps_hide(OnMaps, bpy.types.Operator):
    """Take the wrinkle maps out of the object's materials again"""

    bl_idname = "rumple.maps_hide"
    bl_label = "Take out of Materials"

    def execute(self, context: bpy.types.Context) -> set[str]:
        hide(target(context))
        return {"FINISHED"}


CLASSES = (RUMPLE_OT_maps_add, RUMPLE_OT_maps_remove, RUMPLE_OT_pose_add, RUMPLE_OT_pose_update,
           RUMPLE_OT_pose_remove, RUMPLE_OT_pose_move, RUMPLE_OT_pose_go, RUMPLE_OT_neutral_capture,
           RUMPLE_OT_neutral_rest, RUMPLE_OT_maps_bones, RUMPLE_OT_maps_show, RUMPLE_OT_maps_hide)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
