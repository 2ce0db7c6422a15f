# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads, writes and applies reference poses that are stored with an object: bones and shape keys, by name.

Bones are stored in armature space. Apply (Ctrl A) of the armature's scale, rotation or location changes this space. So
the rest position of each bone is stored too. A reader compares it with the current rest position. Nothing must be
written after such a change, and undo and linked poses need no special treatment.
"""
from __future__ import annotations

from typing import Any, Sequence

import bpy
import numpy as np
from mathutils import Matrix

from ...core.base import transforms
from .. import compat
from . import keys as maps_keys

ASTRAY = 1e-4  # distance / the armature's size: a smaller one is a rounding error of Blender's evaluation

Records = tuple[Any, Any]  # collections of RUMPLE_PosedBone and of RUMPLE_KeyValue
Numbers = Sequence[float]
StoredBone = tuple[str, Numbers, Numbers, Numbers, Numbers, Numbers]  # as in RUMPLE_PosedBone
Stored = tuple[list[StoredBone], dict[str, float]]


def of_pose(pose: bpy.types.PropertyGroup) -> Records:
    return pose.bones, pose.keys


def of_neutral(settings: bpy.types.PropertyGroup) -> Records:
    return settings.neutral, settings.neutral_keys


def is_captured(settings: bpy.types.PropertyGroup) -> bool:
    """Whether a neutral pose was captured; otherwise it is the rest pose."""
    return any(map(len, of_neutral(settings)))


def store(records: Records, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """Store the current pose: all bones of the armature, if there is one, and all shape keys."""
    armature = obj.find_armature()
    bones: list[StoredBone] = []
    if armature is not None:
        rests = _rests(armature)
        bones = [(bone.name, bone.head, bone.tail, _flat(bone.matrix), _flat(bone.matrix_basis),
                  rests[bone.name].tolist())
                 for bone in armature.evaluated_get(depsgraph).pose.bones]
    write(records, (bones, maps_keys.values(obj, depsgraph)))


def read(records: Records) -> Stored:
    """A stored pose, as an argument for write()."""
    bones, keys = records
    return ([(r.name, tuple(r.head), tuple(r.tail), tuple(r.matrix), tuple(r.basis), tuple(r.rest))
             for r in bones],
            maps_keys.of_records(keys))


def write(records: Records, stored: Stored) -> None:
    """Write a pose item by item, in place, because a library override of a linked pose keeps values, but not new
    items."""
    bones, keys = stored
    for name, *values in bones:
        record = _record(records[0], name)
        record.head, record.tail, record.matrix, record.basis, record.rest = values
    for name, value in keys.items():
        _record(records[1], name).value = value
    _keep_only(records[0], {bone[0] for bone in bones})
    _keep_only(records[1], set(keys))


def _record(records: Any, name: str) -> bpy.types.PropertyGroup:
    record = records.get(name)
    if record is None:
        record = records.add()
        record.name = name
    return record


def _keep_only(records: Any, names: set[str]) -> None:
    for place in reversed(range(len(records))):
        if records[place].name not in names:
            records.remove(place)


def _flat(matrix: Any) -> list[float]:
    return [value for row in matrix for value in row]


# ---------------------------------------------------------------- applied transforms of the armature
def _rests(armature: bpy.types.Object) -> dict[str, np.ndarray]:
    """Bone -> (9,) float32: head, tail and a point on its x axis, as far from the head as the tail. Armature space.

    Three points, so that a single bone is enough to find scale and rotation of the rig.
    """
    bones = armature.data.bones
    matrices, lengths = np.empty(16 * len(bones), np.float32), np.empty(len(bones), np.float32)
    bones.foreach_get("matrix_local", matrices)
    bones.foreach_get("length", lengths)
    x_axes, y_axes, _, heads = matrices.reshape(-1, 4, 4)[:, :, :3].transpose(1, 0, 2)  # by columns
    ends = [heads, heads + lengths[:, None] * y_axes, heads + lengths[:, None] * x_axes]
    return dict(zip(bones.keys(), np.concatenate(ends, axis=1)))


def remember_rest(obj: bpy.types.Object) -> None:
    """Store the current rest positions for poses of older files that lack them. Structural work.

    Not in a library override: the linked file may get its own later, which the override would hide.
    """
    settings, armature = obj.rumple_maps, obj.find_armature()
    if armature is None or not compat.is_editable(obj) or obj.override_library is not None:
        return
    stored = [settings.neutral, *(pose.bones for pose in settings.poses)]
    unknown = [record for records in stored if len(records) and not any(records[0].rest) for record in records]
    rests = _rests(armature) if unknown else {}
    for record in unknown:
        record.rest = rests.get(record.name, record.rest)


def applied_since(records: Any, armature: bpy.types.Object) -> np.ndarray | None:
    """(3, 4): the affine map that moved most bones at rest since a pose was stored, in armature space. None if they did
    not move, were edited, or if their former positions are not known."""
    former = np.empty(9 * len(records), np.float32)
    records.foreach_get("rest", former)
    rests = _rests(armature)
    pairs = [(rest, rests[record.name]) for rest, record in zip(former.reshape(-1, 9), records)
             if record.name in rests and rest.any()]
    if not pairs:
        return None
    before, now = np.array(pairs).transpose(1, 0, 2)
    if np.array_equal(before, now):
        return None
    moved = transforms.affine_between(before.reshape(-1, 3), now.reshape(-1, 3))
    if moved is None:  # without the points on x axes, which do not move with a stretched bone
        moved = transforms.affine_between(before[:, :6].reshape(-1, 3), now[:, :6].reshape(-1, 3))
    return moved


# ---------------------------------------------------------------- where the bones belong
def matrices(records: Any, armature: bpy.types.Object) -> dict[str, Matrix]:
    """Bone -> where it stood in a pose, as a matrix in the armature space of now. Left out are bones that are gone or
    were edited since then; all of them if the armature was stretched or mirrored."""
    applied, rests = applied_since(records, armature), _rests(armature)
    scale = None if applied is None else transforms.scale_of(applied)
    if applied is not None and scale is None:
        return {}
    found = {}
    for record in records:
        matrix, former = np.array(record.matrix, np.float64).reshape(4, 4), np.array(record.rest, np.float32)
        if record.name not in rests or not matrix.any():
            continue
        if applied is not None:
            matrix[:3, 3] = transforms.placed(applied, matrix[None, :3, 3])[0]
            matrix[:3, :3] = transforms.product(applied[:, :3] / scale, matrix[:3, :3])
        elif former.any() and not np.array_equal(former, rests[record.name]):
            continue
        found[record.name] = Matrix(matrix.tolist())
    return found


def first_astray(wanted: dict[str, Matrix], armature: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> str:
    """The first bone of an armature that does not have the wanted matrix. Empty if there is none."""
    bones = armature.evaluated_get(depsgraph).pose.bones
    size = max((float(np.abs(rest).max()) for rest in _rests(armature).values()), default=0.0)
    for name, matrix in wanted.items():
        length = armature.data.bones[name].length
        now, there = (place @ Matrix.Diagonal((length, length, length, 1.0)) for place in (bones[name].matrix, matrix))
        if not np.abs(np.array(now) - np.array(there)).max() <= ASTRAY * size:  # also if it is not finite
            return name
    return ""


# ---------------------------------------------------------------- going there
def go_to(records: Records, obj: bpy.types.Object) -> tuple[list[str], list[str]]:
    """Set bones and shape keys as stored. Returns the names of missing bones and of missing keys."""
    armature = obj.find_armature()
    missing = [] if armature is None else pose_bones(records[0], armature)
    return missing, maps_keys.set_values(obj, maps_keys.of_records(records[1]))


def pose_bones(records: Any, armature: bpy.types.Object) -> list[str]:
    """Set the bones of an armature to a stored pose. Returns the names of missing bones."""
    missing = []
    applied = applied_since(records, armature)
    longer = applied is not None and transforms.scale_of(applied) or 1.0
    for record in records:
        bone = armature.pose.bones.get(record.name)
        if bone is None:
            missing.append(record.name)
        else:
            basis = Matrix([record.basis[row:row + 4] for row in range(0, 16, 4)])
            basis.translation *= longer
            bone.matrix_basis = basis
    return missing


def go_to_rest(obj: bpy.types.Object) -> None:
    """Put every bone at rest, and every shape key that is compared at 0."""
    armature = obj.find_armature()
    for bone in armature.pose.bones if armature is not None else ():
        bone.matrix_basis.identity()
    maps_keys.set_values(obj, {key.name: 0.0 for key in obj.rumple_maps.keys})
