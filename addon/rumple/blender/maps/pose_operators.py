# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of the reference poses. All of them can be undone.

bpy.ops.rumple.pose_add(name="Surprise"), pose_update(), pose_rename(name="Joy"), pose_move(direction="UP"),
pose_mute(mute=True), pose_solo(solo=True), pose_remove(), pose_go(), pose_go(neutral=True), neutral_capture(),
neutral_rest(). They act on object.rumple_maps.poses[object.rumple_maps.active], whose name, muted and solo are
properties as well.
"""
from __future__ import annotations

import bpy

from ...core.base.wording import UserError
from ...core.systems.poses import MOST_POSES, PoseComparison
from .. import ui_base
from ..translation import said
from . import changes as maps_changes, keys as maps_keys, posed_rig, rig as maps_rig, stored_poses
from .operators import OnMaps, OnPose, target
from .properties import unused_name


def _store(context: bpy.types.Context, obj: bpy.types.Object, records: stored_poses.Records) -> None:
    stored_poses.store(records, obj, context.evaluated_depsgraph_get())


def _refuse_bad(obj: bpy.types.Object) -> None:
    """Raises UserError if the stored poses cannot be compared: two are equal, or one equals the neutral pose."""
    rig, _ = maps_rig.rig_of(obj)
    PoseComparison.build(rig, maps_rig.weights_of(obj, rig))


class RUMPLE_OT_pose_add(OnMaps, bpy.types.Operator):
    """Store the present pose of the armature, and the values of the shape keys, as a reference pose"""

    bl_idname = "rumple.pose_add"
    bl_label = "Add Reference Pose"

    name: bpy.props.StringProperty(name="Name", default="Pose", maxlen=48,
                                   description="Taken names get a number, as everywhere in Blender")

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.guarded(lambda: self._add(context, target(context)))

    def _add(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        settings = obj.rumple_maps
        if len(settings.poses) == MOST_POSES:
            raise UserError(f"{obj.name}: there are {MOST_POSES} reference poses already: delete one first")
        maps_rig.refuse_without_pose(obj)
        if not settings.bones and not settings.keys:
            maps_rig.choose_by_default(obj)
        name = unused_name(self.name, [pose.name for pose in settings.poses])
        # in the background this compares all poses, so do it before a pose is incomplete
        depsgraph = context.evaluated_depsgraph_get()
        pose = settings.poses.add()
        stored_poses.store(stored_poses.of_pose(pose), obj, depsgraph)
        pose.name = name
        try:
            _refuse_bad(obj)
        except UserError:
            settings.poses.remove(len(settings.poses) - 1)
            raise
        settings.active = len(settings.poses) - 1
        maps_changes.maps_changed(obj)


class RUMPLE_OT_pose_update(OnPose, bpy.types.Operator):
    """Store the present pose in place of the active reference pose; its name and map stay"""

    bl_idname = "rumple.pose_update"
    bl_label = "Update Reference Pose"

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.guarded(lambda: self._update(context, target(context)))

    def _update(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        pose = obj.rumple_maps.poses[obj.rumple_maps.active]
        _replace(context, obj, stored_poses.of_pose(pose))


def _replace(context: bpy.types.Context, obj: bpy.types.Object, records: stored_poses.Records) -> None:
    """Store a pose over another one. If the new pose is refused, the former is restored."""
    maps_rig.refuse_without_pose(obj)
    former = stored_poses.read(records)
    _store(context, obj, records)
    try:
        if obj.rumple_maps.poses:
            _refuse_bad(obj)
    except UserError:
        stored_poses.write(records, former)
        raise
    maps_changes.rig_changed(obj)


class RUMPLE_OT_pose_remove(OnPose, bpy.types.Operator):
    """Delete the active reference pose; its image stays in the file"""

    bl_idname = "rumple.pose_remove"
    bl_label = "Delete Reference Pose"

    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.guarded(lambda: self._remove(target(context)))

    def _remove(self, obj: bpy.types.Object) -> None:
        settings = obj.rumple_maps
        settings.poses.remove(settings.active)
        settings.active = max(0, min(settings.active, len(settings.poses) - 1))
        maps_changes.maps_changed(obj)


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
        return self.guarded(lambda: self._move(obj, place))

    def _move(self, obj: bpy.types.Object, place: int) -> None:
        settings = obj.rumple_maps
        settings.poses.move(settings.active, place)
        settings.active = place
        maps_changes.maps_changed(obj)


class RUMPLE_OT_pose_rename(OnPose, bpy.types.Operator):
    """Rename the active reference pose: shaders and nodes that read its mask must follow"""

    bl_idname = "rumple.pose_rename"
    bl_label = "Rename Reference Pose"

    name: bpy.props.StringProperty(name="Name", default="Pose", maxlen=48,
                                   description="Taken names get a number, as everywhere in Blender")

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = target(context).rumple_maps
        settings.poses[settings.active].name = self.name
        return {"FINISHED"}


class RUMPLE_OT_pose_mute(OnPose, bpy.types.Operator):
    """Do not show the wrinkles of the active reference pose, or show them again"""

    bl_idname = "rumple.pose_mute"
    bl_label = "Mute Reference Pose"

    mute: bpy.props.BoolProperty(name="Mute", default=True)

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = target(context).rumple_maps
        settings.poses[settings.active].muted = self.mute
        return {"FINISHED"}


class RUMPLE_OT_pose_solo(OnPose, bpy.types.Operator):
    """Show the wrinkles of the active reference pose only, or of all again"""

    bl_idname = "rumple.pose_solo"
    bl_label = "Solo Reference Pose"

    solo: bpy.props.BoolProperty(name="Solo", default=True)

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = target(context).rumple_maps
        for number, pose in enumerate(settings.poses):
            pose.solo = self.solo and number == settings.active
        return {"FINISHED"}


class RUMPLE_OT_pose_go(OnMaps, bpy.types.Operator):
    """Put armature and shape keys into the active reference pose. Nothing is keyed"""

    bl_idname = "rumple.pose_go"
    bl_label = "Go to Pose"

    neutral: bpy.props.BoolProperty(name="Neutral", description="Go to the neutral pose instead", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        settings = obj.rumple_maps
        if not self.neutral and not 0 <= settings.active < len(settings.poses):
            return ui_base.refuse(self, f"{obj.name}: there is no reference pose to go to")
        if self.neutral and not stored_poses.is_captured(settings):
            stored_poses.go_to_rest(obj)
            context.view_layer.update()
        else:
            self._go(context, obj, stored_poses.of_neutral(settings) if self.neutral
                     else stored_poses.of_pose(settings.poses[settings.active]))
        return {"FINISHED"}

    def _go(self, context: bpy.types.Context, obj: bpy.types.Object, records: stored_poses.Records) -> None:
        bones, keys = stored_poses.go_to(records, obj)
        context.view_layer.update()
        armature = obj.find_armature()
        if bones:
            self.report({"WARNING"}, said(f"{armature.name} has no bone {', '.join(bones)}: renamed or deleted?"))
        if keys:
            self.report({"WARNING"}, said(f"{obj.name} has no shape key {', '.join(keys)}: renamed or deleted?"))
        held = armature is not None and stored_poses.first_astray(
            posed_rig.of_skin(obj, armature, records[0]), armature, context.evaluated_depsgraph_get())
        if held:
            self.report({"WARNING"}, said(f"{armature.name}: bone {held} does not come to where it was stored: a "
                                          "constraint, a driver or Rest Position holds it"))
        astray = maps_keys.astray(obj, maps_keys.of_records(records[1]))
        if astray:
            self.report({"WARNING"}, said(f"{obj.name}: {', '.join(astray)} cannot be set here: a driver sets it, or "
                                          "it is muted"))


class RUMPLE_OT_neutral_capture(OnMaps, bpy.types.Operator):
    """Take the present pose as the neutral one, which shows no wrinkles"""

    bl_idname = "rumple.neutral_capture"
    bl_label = "Capture Neutral Pose"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)
        return self.guarded(lambda: _replace(context, obj, stored_poses.of_neutral(obj.rumple_maps)))


class RUMPLE_OT_neutral_rest(OnMaps, bpy.types.Operator):
    """Take the rest pose of the armature, and shape keys at 0, as the neutral one"""

    bl_idname = "rumple.neutral_rest"
    bl_label = "Use Rest Pose as Neutral"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = target(context)

        def rest() -> None:
            obj.rumple_maps.neutral.clear()
            obj.rumple_maps.neutral_keys.clear()
            maps_changes.rig_changed(obj)
        return self.guarded(rest)


CLASSES = (RUMPLE_OT_pose_add, RUMPLE_OT_pose_update, RUMPLE_OT_pose_rename, RUMPLE_OT_pose_move,
           RUMPLE_OT_pose_mute, RUMPLE_OT_pose_solo, RUMPLE_OT_pose_remove, RUMPLE_OT_pose_go,
           RUMPLE_OT_neutral_capture, RUMPLE_OT_neutral_rest)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
