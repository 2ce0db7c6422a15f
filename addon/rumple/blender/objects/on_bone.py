# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that a bone moves as a whole, because it is their parent: capes, swords and hats of many game characters."""
from __future__ import annotations

import bpy
from mathutils import Matrix


def bone_of(obj: bpy.types.Object) -> bpy.types.Bone | None:
    """The bone that moves an object as a whole. None if no bone is its parent, or an Armature modifier deforms it."""
    if obj.parent is None or obj.parent.type != "ARMATURE" or obj.parent_type != "BONE":
        return None
    if any(m.type == "ARMATURE" for m in obj.modifiers):
        return None
    return obj.parent.data.bones.get(obj.parent_bone)


def world_at_rest(obj: bpy.types.Object) -> Matrix:
    """The world matrix of an object while its armature is at rest. Skinned meshes at rest are where the object is now;
    but what hangs on a bone is now where the pose has it."""
    bone = bone_of(obj)
    if bone is None:
        return obj.matrix_world
    at_tail = Matrix() if bone.use_relative_parent else bone.matrix_local @ Matrix.Translation((0.0, bone.length, 0.0))
    return obj.parent.matrix_world @ at_tail @ obj.matrix_parent_inverse @ obj.matrix_basis
