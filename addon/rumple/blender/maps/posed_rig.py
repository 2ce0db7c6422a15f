# SPDX-License-Identifier: GPL-3.0-or-later
"""The armature that poses the two meshes of a bake of maps. It is the artist's own, or a copy of it where that one does
not come to the stored pose: constraints, drivers or Rest Position hold its bones."""
from __future__ import annotations

from contextlib import ExitStack
from typing import Any

import bpy
from mathutils import Matrix

from . import rig as maps_rig, stored_poses


def of_skin(obj: bpy.types.Object, armature: bpy.types.Object, records: Any) -> dict[str, Matrix]:
    """Where the bones that deform an object stood in a pose, as stored_poses.matrices()."""
    skinning = set(maps_rig.skinning_bones(obj, armature))
    return {name: matrix for name, matrix in stored_poses.matrices(records, armature).items() if name in skinning}


class PosedRig:
    """An armature in a stored pose."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, records: Any, ended: ExitStack) -> None:
        """records: the stored bones. ended: undoes it, but leaves the artist's armature in the pose, as far as it
        comes. What else the armature moves in the scene follows the copy too: a garment lies on its body."""
        self.obj, self.own = obj, obj.find_armature()
        self.posing = self.own
        self._context, self._wanted = context, {}
        if self.own is None:
            return
        stored_poses.pose_bones(records, self.own)
        context.view_layer.update()
        self._wanted = of_skin(obj, self.own, records)
        if self.astray():
            self.posing = _free_copy(self.own, context.scene, ended)
            context.view_layer.update()  # makes the bones of the copy
            _place_bones(self.posing, stored_poses.matrices(records, self.own))
            for other in set(context.scene.objects) - {obj, self.own, self.posing}:
                _follow(other, self.own, self.posing)
                ended.callback(_follow, other, self.posing, self.own)
            context.view_layer.update()

    def astray(self) -> str:
        """The first bone that poses the object and is not where it was stored. Empty if there is none."""
        if self.own is None:
            return ""
        return stored_poses.first_astray(self._wanted, self.posing, self._context.evaluated_depsgraph_get())

    def lead(self, copy: bpy.types.Object) -> None:
        """Let this armature pose a copy of the object, also where its modifier is switched off in viewports."""
        if self.own is None:
            return
        for modifier in _follow(copy, self.own, self.posing):
            copy.driver_remove(f'modifiers["{bpy.utils.escape_identifier(modifier.name)}"].show_viewport')
            modifier.show_viewport = True


def _follow(obj: bpy.types.Object, former: bpy.types.Object, new: bpy.types.Object) -> list[bpy.types.Modifier]:
    """Let an armature move an object in place of another one. Returns the modifiers by which it does."""
    modifiers = [m for m in obj.modifiers if m.type == "ARMATURE" and m.object == former]
    for modifier in modifiers:
        modifier.object = new
    if obj.parent == former:
        obj.parent = new
    return modifiers


def _free_copy(armature: bpy.types.Object, scene: bpy.types.Scene, ended: ExitStack) -> bpy.types.Object:
    """A copy of an armature whose bones only their own channels move. ended: removes it."""
    data = armature.data.copy()
    ended.callback(bpy.data.armatures.remove, data)
    copy = armature.copy()
    ended.callback(bpy.data.objects.remove, copy)
    copy.data = data
    for animated in (copy, copy.data):
        animated.animation_data_clear()
    for bone in copy.pose.bones:
        for constraint in bone.constraints:
            constraint.mute = True
    copy.data.pose_position = "POSE"
    scene.collection.objects.link(copy)
    copy.hide_viewport = False
    return copy


def _place_bones(armature: bpy.types.Object, matrices: dict[str, Matrix]) -> None:
    """Give bones these matrices in armature space. Others keep their channels."""
    posed: dict[str, Matrix] = {}
    for bone in armature.data.bones:  # parents come before their children
        channels, parents = armature.pose.bones[bone.name], {}
        if bone.parent is not None:
            parents = dict(parent_matrix=posed[bone.parent.name], parent_matrix_local=bone.parent.matrix_local)
        if bone.name in matrices:
            channels.matrix_basis = bone.convert_local_to_pose(matrices[bone.name], bone.matrix_local, invert=True,
                                                               **parents)
        posed[bone.name] = bone.convert_local_to_pose(channels.matrix_basis, bone.matrix_local, **parents)
