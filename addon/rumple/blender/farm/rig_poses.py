# SPDX-License-Identifier: GPL-3.0-or-later
"""Random poses of a garment's rig: ranges of its joints, and functions that set and read a pose."""
from __future__ import annotations

from typing import Callable

import bpy
import numpy as np
from mathutils import Euler, Matrix

from ...core.files.pose_set import BoneRange, widened
from ..objects import bodies

AXES = "xyz"


def armatures(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The armatures that move a garment and its bodies."""
    found = []
    for one in (obj, *bodies.of(obj)):
        moved_by = [modifier.object for modifier in one.modifiers if modifier.type == "ARMATURE"] + [one.parent]
        for rig in moved_by:
            if rig is not None and rig.type == "ARMATURE" and rig not in found:
                found.append(rig)
    return found


def bones(rigs: list[bpy.types.Object]) -> list[bpy.types.PoseBone]:
    """All bones, by armature, parents first."""
    return [bone for rig in rigs for bone in rig.pose.bones]


# ---------------------------------------------------------------- ranges
def ranges(rigs: list[bpy.types.Object], frames: range, visit: Callable[[int], object],
           widen: float) -> list[BoneRange]:
    """The range of every bone. visit: evaluates a frame. Bones without limits get their range in the clip, widened."""
    seen: list[list[tuple[float, ...]]] = [[] for _ in bones(rigs)]
    for frame in frames:
        visit(frame)
        for angles, bone in zip(seen, bones(rigs)):
            before = Euler(angles[-1], "XYZ") if angles else Euler((0.0, 0.0, 0.0), "XYZ")
            angles.append(tuple(bone.matrix_basis.to_euler("XYZ", before)))
    return [_range(bone, np.array(angles), widen) for bone, angles in zip(bones(rigs), seen)]


def _range(bone: bpy.types.PoseBone, angles: np.ndarray, widen: float) -> BoneRange:
    found = BoneRange(bone.id_data.name, bone.name, [], [], [])
    for number, axis in enumerate(AXES):
        limits = _limits(bone, axis)
        least, most = angles[:, number].min().item(), angles[:, number].max().item()
        if limits is not None:
            (least, most), source = limits[:2], limits[2]
        elif most - least > 1e-6:
            (least, most), source = widened(least, most, widen), "clip"
        else:
            source = "none"
        found.least.append(least)
        found.most.append(most)
        found.source.append(source)
    return found


def _limits(bone: bpy.types.PoseBone, axis: str) -> tuple[float, float, str] | None:
    """The limits from a Limit Rotation constraint, otherwise from inverse kinematics."""
    for constraint in bone.constraints:
        if (constraint.type == "LIMIT_ROTATION" and not constraint.mute and constraint.owner_space == "LOCAL"
                and getattr(constraint, f"use_limit_{axis}")):
            return getattr(constraint, f"min_{axis}"), getattr(constraint, f"max_{axis}"), "constraint"
    if getattr(bone, f"lock_ik_{axis}"):
        return 0.0, 0.0, "ik"
    if getattr(bone, f"use_ik_limit_{axis}"):
        return getattr(bone, f"ik_min_{axis}"), getattr(bone, f"ik_max_{axis}"), "ik"
    return None


# ---------------------------------------------------------------- poses
def let_go(rigs: list[bpy.types.Object]) -> None:
    """Remove all animation of the bones, so that they keep their pose. Only for a file that is not saved."""
    for rig in rigs:
        if rig.animation_data is not None:
            rig.animation_data.action = None
            rig.animation_data.use_nla = False


def put(rigs: list[bpy.types.Object], ranges_: list[BoneRange], drawn: np.ndarray) -> None:
    """Set a random pose. drawn: (bones, 3) in [0, 1). Bones without a range keep their pose. Locations and scales do
    not change."""
    for bone, its, shares in zip(bones(rigs), ranges_, drawn):
        if set(its.source) == {"none"}:
            continue
        turned = Euler(its.angles(shares), "XYZ").to_quaternion()
        if bone.rotation_mode == "QUATERNION":
            bone.rotation_quaternion = turned
        elif bone.rotation_mode == "AXIS_ANGLE":
            axis, angle = turned.to_axis_angle()
            bone.rotation_axis_angle = (angle, *axis)
        else:
            bone.rotation_euler = turned.to_euler(bone.rotation_mode)


def read(obj: bpy.types.Object, rigs: list[bpy.types.Object], depsgraph: bpy.types.Depsgraph) -> np.ndarray:
    """(bones, 4, 4) float32: from the bones' own space to the garment's space, after constraints."""
    to_object = obj.evaluated_get(depsgraph).matrix_world.inverted_safe()
    return _matrices([to_object @ rig.evaluated_get(depsgraph).matrix_world @ bone.matrix
                      for rig in rigs for bone in rig.evaluated_get(depsgraph).pose.bones])


def at_rest(rigs: list[bpy.types.Object]) -> np.ndarray:
    """(bones, 4, 4) float32: from the bones' own space to their armature's space, at rest."""
    return _matrices([bone.bone.matrix_local for bone in bones(rigs)])


def parents(rigs: list[bpy.types.Object]) -> np.ndarray:
    """(bones,) int32: the number of each bone's parent, or -1."""
    numbers = {(bone.id_data.name, bone.name): number for number, bone in enumerate(bones(rigs))}
    return np.array([-1 if bone.parent is None else numbers[bone.id_data.name, bone.parent.name]
                     for bone in bones(rigs)], np.int32)


def _matrices(found: list[Matrix]) -> np.ndarray:
    return np.array([[list(row) for row in matrix] for matrix in found], np.float32).reshape(-1, 4, 4)
