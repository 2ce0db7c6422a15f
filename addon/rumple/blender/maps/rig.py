# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads armatures, stored poses and skin weights for the Wrinkle Maps, and writes stored poses back."""
from __future__ import annotations

from typing import Any, Sequence

import bpy
import numpy as np

from ...core import poses
from ...core.engine import UserError
from ...core.poses import PoseRig, ReferencePose, SkinWeights, TrackedBone

_ROOT_NAMES = ("head", "c_head", "def-head", "mixamorig:head", "def_head", "face_root")


def armature_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The armature that skins an object. Raises UserError."""
    armature = obj.find_armature()
    if armature is None:
        raise UserError(f"{obj.name}: no armature deforms it: Wrinkle Maps follow bones")
    return armature


# ---------------------------------------------------------------- which bones
def skinning_bones(obj: bpy.types.Object, armature: bpy.types.Object) -> list[str]:
    """The deforming bones with a vertex group, in the order of the armature."""
    return [bone.name for bone in armature.data.bones if bone.use_deform and bone.name in obj.vertex_groups]


def guessed_root(armature: bpy.types.Object, names: list[str]) -> str:
    """A bone named as heads are, else the nearest bone that all of these hang from, else the first bone."""
    for bone in armature.data.bones:
        if bone.name.lower() in _ROOT_NAMES:
            return bone.name
    lines = [[bone.name, *(parent.name for parent in bone.parent_recursive)]
             for bone in (armature.data.bones[name] for name in names)]
    common = [name for name in lines[0] if all(name in line for line in lines)] if lines else []
    return common[0] if common else armature.data.bones[0].name


def choose_bones(obj: bpy.types.Object, names: list[str]) -> None:
    """Compare exactly these bones; what was set for those that stay is kept."""
    bones = obj.rumple_maps.bones
    for place in reversed(range(len(bones))):
        if bones[place].name not in names:
            bones.remove(place)
    for name in names:
        if name not in bones:
            bones.add().name = name


def choose_by_default(obj: bpy.types.Object) -> None:
    """The selected bones in Pose Mode, else all skinning bones below the root. The root as well, where none is set."""
    settings, armature = obj.rumple_maps, armature_of(obj)
    skinning = skinning_bones(obj, armature)
    selected = [bone.name for bone in bpy.context.selected_pose_bones or () if bone.id_data == armature]
    if settings.root not in armature.data.bones:
        settings.root = guessed_root(armature, [name for name in selected if name in skinning] or skinning)
    below = {bone.name for bone in armature.data.bones[settings.root].children_recursive}
    choose_bones(obj, [name for name in skinning if name in (selected or below) and name != settings.root])


# ---------------------------------------------------------------- storing poses
StoredBone = tuple[str, Sequence[float], Sequence[float], Sequence[float], Sequence[float]]  # as in RUMPLE_PosedBone


def store(records: Any, armature: bpy.types.Object) -> None:
    """Fill a collection of RUMPLE_PosedBone with all bones of an evaluated armature."""
    write(records, [(bone.name, bone.head, bone.tail, _flat(bone.matrix), _flat(bone.matrix_basis))
                    for bone in armature.pose.bones])


def read(records: Any) -> list[StoredBone]:
    """What write() takes."""
    return [(r.name, tuple(r.head), tuple(r.tail), tuple(r.matrix), tuple(r.basis)) for r in records]


def write(records: Any, bones: list[StoredBone]) -> None:
    """In place, bone by bone: of a linked pose a library override keeps values, not other items."""
    names = {bone[0] for bone in bones}
    for place in reversed(range(len(records))):
        if records[place].name not in names:
            records.remove(place)
    for name, *values in bones:
        record = records.get(name)
        if record is None:
            record = records.add()
            record.name = name
        record.head, record.tail, record.matrix, record.basis = values


def go_to(records: Any, armature: bpy.types.Object) -> list[str]:
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


def go_to_rest(armature: bpy.types.Object) -> None:
    """Put every bone at rest."""
    for bone in armature.pose.bones:
        bone.matrix_basis.identity()


def _flat(matrix: Any) -> list[float]:
    return [value for row in matrix for value in row]


# ---------------------------------------------------------------- the rig as data
class _Pose:
    """Bones of a stored or present pose as arrays, by name. Armature space."""

    def __init__(self, names: list[str], heads: np.ndarray, tails: np.ndarray, matrices: dict[str, np.ndarray]) -> None:
        self.index = {name: place for place, name in enumerate(names)}
        self.points = np.concatenate([heads.reshape(-1, 3), tails.reshape(-1, 3)], 1)
        self.matrices = matrices

    def relative(self, obj: bpy.types.Object, root: str, names: list[str], otherwise: np.ndarray | None) -> np.ndarray:
        """(b, 6) in root space; bones that this pose lacks as in `otherwise`."""
        places = [self.index.get(name, -1) for name in names]
        found = poses.bones_in_root_space(obj.name, self.matrices[root], self.points[places])
        missing = np.array(places) < 0
        if missing.any():
            found[missing] = otherwise[missing]
        return found


def _read(bones: Any, head: str, tail: str, matrix: Any, root: str) -> _Pose:
    """From a collection of bones: the names of its properties, and of the root's matrix how to get it."""
    heads, tails = (np.empty(3 * len(bones), np.float32) for _ in range(2))
    bones.foreach_get(head, heads)
    bones.foreach_get(tail, tails)
    return _Pose([bone.name for bone in bones], heads, tails, {root: matrix(bones[root])} if root in bones else {})


def _stored(records: Any, root: str) -> _Pose:
    return _read(records, "head", "tail", lambda record: np.array(record.matrix, np.float32).reshape(4, 4), root)


def _at_rest(armature: bpy.types.Object, root: str) -> _Pose:
    return _read(armature.data.bones, "head_local", "tail_local", lambda bone: np.array(bone.matrix_local, np.float32),
                 root)


def _present(armature: bpy.types.Object, root: str) -> _Pose:
    return _read(armature.pose.bones, "head", "tail", lambda bone: np.array(bone.matrix, np.float32), root)


def present_bones(obj: bpy.types.Object, armature: bpy.types.Object, rig: PoseRig) -> np.ndarray:
    """(b, 6) heads and tails in root space of an evaluated armature. Raises UserError where a bone is gone."""
    here = _present(armature, rig.root)
    for name in (rig.root, *(bone.name for bone in rig.bones)):
        if name not in here.index:
            raise UserError(f"{obj.name}: {armature.name} has no bone {name}: was it renamed or deleted?")
    return here.relative(obj, rig.root, [bone.name for bone in rig.bones], None)


def rig_of(obj: bpy.types.Object) -> tuple[PoseRig, list[str]]:
    """The rig as the core wants it, and what is odd about it. Raises UserError where nothing can be compared."""
    settings, armature = obj.rumple_maps, armature_of(obj)
    known, notes = armature.data.bones, []
    if not settings.bones:
        raise UserError(f"{obj.name}: no bones are chosen to be compared: add a reference pose, or choose bones")
    if settings.root not in known:
        raise UserError(f"{obj.name}: {armature.name} has no bone \"{settings.root}\" to be the root: choose another")
    bones = [TrackedBone(bone.name, bone.tracked, bone.group) for bone in settings.bones if bone.name in known]
    lost = [bone.name for bone in settings.bones if bone.name not in known]
    if not bones:
        raise UserError(f"{obj.name}: {armature.name} has none of the bones that are compared: {_listed(lost)}")
    if lost:
        notes.append(f"{obj.name}: {armature.name} has no bone {_listed(lost)}: renamed or deleted? It is left out")
    idle = [bone.name for bone in bones if bone.name not in obj.vertex_groups]
    if idle:
        notes.append(f"{obj.name}: it has no vertex group {_listed(idle)}: these bones show no wrinkle")
    names = [bone.name for bone in bones]
    at_rest = _at_rest(armature, settings.root).relative(obj, settings.root, names, None)
    neutral = at_rest
    if settings.neutral:
        neutral = _pose_of(obj, settings.neutral, "the neutral pose", names, at_rest, notes)
    rig = PoseRig(obj.name, settings.root, bones, neutral, maps=settings.maps, gain=settings.gain)
    for pose in settings.poses:
        places = _pose_of(obj, pose.bones, f"pose {pose.name}", names, neutral, notes)
        rig.poses.append(ReferencePose(pose.name, places, _file_name(pose.image), pose.strength, pose.muted, pose.solo))
    return rig, notes


def _pose_of(obj: bpy.types.Object, records: Any, name: str, names: list[str], otherwise: np.ndarray,
             notes: list[str]) -> np.ndarray:
    stored = _stored(records, obj.rumple_maps.root)
    if obj.rumple_maps.root not in stored.index:
        raise UserError(f"{obj.name}: {name} was stored without the root bone {obj.rumple_maps.root}: update it")
    unknown = [bone for bone in names if bone not in stored.index]
    if unknown:
        notes.append(f"{obj.name}: {name} was stored without {_listed(unknown)}: update it")
    return stored.relative(obj, obj.rumple_maps.root, names, otherwise)


def bone_lengths(obj: bpy.types.Object, rig: PoseRig) -> np.ndarray:
    """(b,) at rest, of the tracked bones."""
    known = armature_of(obj).data.bones
    return np.array([known[bone.name].length for bone in rig.bones], np.float32)


def _listed(names: list[str], most: int = 3) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def _file_name(image: bpy.types.Image | None) -> str:
    if image is None:
        return ""
    return bpy.path.basename(image.filepath_raw) or f"{bpy.path.clean_name(image.name)}.png"


def weights_of(obj: bpy.types.Object, rig: PoseRig) -> SkinWeights:
    """Weights of every bone that deforms the mesh. Walks all vertices: 1 ms per 1000."""
    tracked = {bone.name: place for place, bone in enumerate(rig.bones)}
    deforming = set(skinning_bones(obj, armature_of(obj))) | tracked.keys()
    column = {group.index: tracked.get(group.name, -1) for group in obj.vertex_groups if group.name in deforming}
    start, bones, weights = [0], [], []
    for vertex in obj.data.vertices:
        for element in vertex.groups:
            place = column.get(element.group)
            if place is not None and element.weight > 0.0:
                bones.append(place)
                weights.append(element.weight)
        start.append(len(bones))
    return SkinWeights(np.array(start, np.int32), np.array(bones, np.int32), np.array(weights, np.float32))


# ---------------------------------------------------------------- images
def image_notes(obj: bpy.types.Object) -> list[str]:
    """What is odd about the wrinkle maps: missing, empty, of different sizes, read as colours."""
    notes, first = [], None
    for pose in obj.rumple_maps.poses:
        image = pose.image
        if image is None:
            continue
        at = f"{obj.name}: the wrinkle map {image.name} of pose {pose.name}"
        if not tuple(image.size)[0]:
            notes.append(f"{at} cannot be found: {image.filepath_raw or 'it has no file'}")
            continue
        if not image.colorspace_settings.is_data:
            notes.append(f"{at} is read as a colour: set its color space to Non-Color")
        first = first or pose
        if tuple(image.size) != tuple(first.image.size):
            notes.append(f"{at} has {image.size[0]} x {image.size[1]} texels, that of pose {first.name} "
                         f"{first.image.size[0]} x {first.image.size[1]}: game engines want one size")
    return notes


def usable_images(obj: bpy.types.Object) -> list[bpy.types.Image | None]:
    """The map of every pose; None where it has none or it cannot be read, so that it does not count."""
    return [pose.image if pose.image is not None and tuple(pose.image.size)[0] else None
            for pose in obj.rumple_maps.poses]
