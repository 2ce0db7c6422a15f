# SPDX-License-Identifier: GPL-3.0-or-later
"""Reference poses as they are stored with an object: bones and shape keys, by their names."""
from __future__ import annotations

from typing import Any, Sequence

import bpy

from . import keys as maps_keys

Records = tuple[Any, Any]  # collections of RUMPLE_PosedBone and of RUMPLE_KeyValue
StoredBone = tuple[str, Sequence[float], Sequence[float], Sequence[float], Sequence[float]]  # as in RUMPLE_PosedBone
Stored = tuple[list[StoredBone], dict[str, float]]


def of_pose(pose: bpy.types.PropertyGroup) -> Records:
    return pose.bones, pose.keys


def of_neutral(settings: bpy.types.PropertyGroup) -> Records:
    return settings.neutral, settings.neutral_keys


def is_captured(settings: bpy.types.PropertyGroup) -> bool:
    """The neutral pose is not rest."""
    return any(map(len, of_neutral(settings)))


def store(records: Records, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """The present pose: all bones of the armature, where there is one, and all shape keys."""
    armature = obj.find_armature()
    bones: list[StoredBone] = [] if armature is None else [
        (bone.name, bone.head, bone.tail, _flat(bone.matrix), _flat(bone.matrix_basis))
        for bone in armature.evaluated_get(depsgraph).pose.bones]
    write(records, (bones, maps_keys.values(obj, depsgraph)))


def read(records: Records) -> Stored:
    """What write() takes."""
    bones, keys = records
    return ([(r.name, tuple(r.head), tuple(r.tail), tuple(r.matrix), tuple(r.basis)) for r in bones],
            maps_keys.of_records(keys))


def write(records: Records, stored: Stored) -> None:
    """In place, item by item: of a linked pose a library override keeps values, not other items."""
    bones, keys = stored
    for name, *values in bones:
        record = _record(records[0], name)
        record.head, record.tail, record.matrix, record.basis = values
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


# ---------------------------------------------------------------- going there
def go_to(records: Records, obj: bpy.types.Object) -> tuple[list[str], list[str]]:
    """Set bones and shape keys as stored; returns the names of bones and of keys that are not there."""
    armature = obj.find_armature()
    missing = [] if armature is None else pose_bones(records[0], armature)
    return missing, maps_keys.set_values(obj, maps_keys.of_records(records[1]))


def pose_bones(records: Any, armature: bpy.types.Object) -> list[str]:
    """Put the bones of an armature where a stored pose has them; returns the names it does not have."""
    from mathutils import Matrix
    missing = []
    for record in records:
        bone = armature.pose.bones.get(record.name)
        if bone is None:
            missing.append(record.name)
        else:
            bone.matrix_basis = Matrix([record.basis[row:row + 4] for row in range(0, 16, 4)])
    return missing


def go_to_rest(obj: bpy.types.Object) -> None:
    """Put every bone at rest, and every shape key that is compared at 0."""
    armature = obj.find_armature()
    for bone in armature.pose.bones if armature is not None else ():
        bone.matrix_basis.identity()
    maps_keys.set_values(obj, {key.name: 0.0 for key in obj.rumple_maps.keys})
