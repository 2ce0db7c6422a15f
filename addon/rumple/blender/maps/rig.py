# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the rig of the Wrinkle Maps from armature, shape keys, stored poses and skin weights, and chooses bones."""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...core.base import transforms
from ...core.base.wording import UserError
from ...core.systems import poses
from ...core.systems.poses import PoseRig, ReferencePose, SkinWeights, TrackedBone, TrackedKey
from ...core.systems.shape_keys import with_keys
from . import keys as maps_keys, stored_poses

_SAME = 1e-6  # values of a shape key that differ by less are equal
_MOVED = 1e-4  # distance / the armature's size: a smaller one is a rounding error of Blender's evaluation
_ROOT_NAMES = ("head", "c_head", "def-head", "mixamorig:head", "def_head", "face_root")


def armature_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The armature that skins an object. Raises UserError."""
    armature = obj.find_armature()
    if armature is None:
        raise UserError(f"{obj.name}: no armature deforms it any more, so its bones cannot be compared: give it "
                        "its Armature modifier back")
    return armature


def refuse_without_pose(obj: bpy.types.Object) -> None:
    """Raises UserError if nothing can be posed."""
    if obj.find_armature() is None and not maps_keys.blocks(obj):
        if maps_keys.are_absolute(obj):
            raise UserError(f"{obj.name}: its shape keys are absolute: switch on Relative, since no map follows "
                            "absolute ones")
        raise UserError(f"{obj.name}: no armature deforms it and it has no shape keys: add one or the other, Wrinkle "
                        "Maps follow them")


# ---------------------------------------------------------------- which bones
def skinning_bones(obj: bpy.types.Object, armature: bpy.types.Object) -> list[str]:
    """The deforming bones with a vertex group, in the order of the armature."""
    return [bone.name for bone in armature.data.bones if bone.use_deform and bone.name in obj.vertex_groups]


def _below(armature: bpy.types.Object, root: str) -> set[str]:
    """All descendants of a bone; all bones if root is empty."""
    known = armature.data.bones
    return {bone.name for bone in (known[root].children_recursive if root else known)}


def _head(armature: bpy.types.Object, names: list[str]) -> str:
    """A bone with a usual name of a head that has some of these as descendants; otherwise empty."""
    heads = (bone.name for bone in armature.data.bones if bone.name.lower() in _ROOT_NAMES)
    return next((head for head in heads if _below(armature, head) & set(names)), "")


def is_face(obj: bpy.types.Object) -> bool:
    """Whether most of the bones that deform a mesh are those of a head."""
    armature = obj.find_armature()
    names = [] if armature is None else skinning_bones(obj, armature)
    head = "" if armature is None else _head(armature, names)
    return bool(head) and 2 * len({head, *_below(armature, head)} & set(names)) > len(names)


def common_root(armature: bpy.types.Object, names: list[str]) -> str:
    """The nearest common ancestor of these bones; empty if there is none: the armature itself."""
    known = armature.data.bones
    first = known[names[0]] if names else None
    for bone in [first, *first.parent_recursive] if first is not None else ():
        others = set(names) - {bone.name}
        if others and others <= _below(armature, bone.name):
            return bone.name
    return ""


def choose_by_default(obj: bpy.types.Object) -> None:
    """Choose keys and bones for the first pose: shape keys that move the mesh, and bones unless only keys are posed."""
    names = maps_keys.moving(obj)
    maps_keys.choose(obj.rumple_maps.keys, names)
    armature = obj.find_armature()
    if armature is not None and (_selected(armature) or _has_moved(obj, armature, names)):
        choose_bones_by_default(obj)


def _has_moved(obj: bpy.types.Object, armature: bpy.types.Object, keys: list[str]) -> bool:
    """Whether bones are part of the pose. If shape keys are set, only bones of the head count."""
    skinning = skinning_bones(obj, armature)
    head = _head(armature, skinning)
    return bool(head and _move(obj, armature, head, skinning)) or not maps_keys.are_set(obj, keys)


def choose_bones_by_default(obj: bpy.types.Object) -> None:
    """Choose the selected bones in Pose Mode, otherwise all skinning bones below the root. Also choose the root if none
    is set."""
    settings, armature = obj.rumple_maps, armature_of(obj)
    skinning, selected = skinning_bones(obj, armature), _selected(armature)
    wanted = [name for name in selected if name in skinning] or skinning
    if settings.root not in armature.data.bones or not set(wanted) - {settings.root} & (
            set(selected) or _below(armature, settings.root)):
        settings.root = _guessed_root(obj, armature, wanted, bool(selected))
    among = set(selected) or _below(armature, settings.root)
    maps_keys.choose(settings.bones, [name for name in skinning if name in among and name != settings.root])


def _selected(armature: bpy.types.Object) -> list[str]:
    return [bone.name for bone in bpy.context.selected_pose_bones or () if bone.id_data == armature]


def _guessed_root(obj: bpy.types.Object, armature: bpy.types.Object, names: list[str], selected: bool) -> str:
    """The head, if the compared bones are its descendants and are posed; otherwise their common ancestor."""
    head, common = _head(armature, names), common_root(armature, names)
    if selected:
        return head if head and set(names) - {head} <= _below(armature, head) else common
    if head and (_move(obj, armature, head, names) or not _move(obj, armature, common, names)):
        return head
    return common


def _move(obj: bpy.types.Object, armature: bpy.types.Object, root: str, names: list[str]) -> bool:
    """Whether a descendant of root differs from its rest pose, relative to root."""
    below = [name for name in names if name in _below(armature, root) and name != root]
    if not below:
        return False
    rest, now = (read(armature, root).relative(obj, root, below, None) for read in (_at_rest, _present))
    return bool(np.abs(now - rest).max() > _MOVED * np.abs(rest).max())


# ---------------------------------------------------------------- the rig as data
class _Pose:
    """Bones of a stored or current pose as arrays, by name. Armature space."""

    def __init__(self, names: list[str], heads: np.ndarray, tails: np.ndarray, matrices: dict[str, np.ndarray]) -> None:
        self.index = {name: place for place, name in enumerate(names)}
        self.points = np.concatenate([heads.reshape(-1, 3), tails.reshape(-1, 3)], 1)
        self.matrices = matrices

    def relative(self, obj: bpy.types.Object, root: str, names: list[str], otherwise: np.ndarray | None) -> np.ndarray:
        """(b, 6) in root space. Bones that this pose lacks are taken from `otherwise`. A pose of shape keys lacks
        all."""
        known = [place for place, name in enumerate(names) if name in self.index]
        matrix = self.matrices[root] if root else np.eye(4, dtype=np.float32)
        here = self.points[[self.index[names[place]] for place in known]]
        found = np.zeros((len(names), 6), np.float32) if otherwise is None else otherwise.copy()
        found[known] = poses.bones_in_root_space(obj.name, matrix, here)
        return found

    def carry(self, affine: np.ndarray, scale: float) -> None:
        """Apply an affine map (3, 4) that rotates and scales. Matrices of bones are not scaled, as in Blender."""
        self.points = transforms.placed(affine, self.points.reshape(-1, 3)).reshape(-1, 6).astype(np.float32)
        for matrix in self.matrices.values():
            columns = transforms.turned(affine[:, :3] / scale, matrix[:3, :3].T)
            matrix[:3, 3] = transforms.placed(affine, matrix[None, :3, 3])[0]
            matrix[:3, :3] = columns.T


def _read(bones: Any, head: str, tail: str, matrix: Any, root: str) -> _Pose:
    """Read a collection of bones. head, tail: names of properties; matrix: a function that returns the root's
    matrix."""
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


def present(obj: bpy.types.Object, rig: PoseRig) -> tuple[np.ndarray, np.ndarray]:
    """(b, 6) heads and tails of the evaluated armature in root space, and (m,) evaluated values of shape keys. Raises
    UserError if one is missing."""
    values = maps_keys.values(obj)
    gone = [key.name for key in rig.keys if key.name not in values]
    if gone:
        raise UserError(f"{obj.name}: it has no shape key {_listed(gone)}: give it its name back, or choose keys anew")
    keys = np.array([values[key.name] for key in rig.keys], np.float32)
    if not rig.bones:
        return np.zeros((0, 6), np.float32), keys
    armature = armature_of(obj)
    here = _present(armature, rig.root)
    for name in (*([rig.root] if rig.root else ()), *(bone.name for bone in rig.bones)):
        if name not in here.index:
            raise UserError(f"{obj.name}: {armature.name} has no bone {name}: give it its name back, or choose bones "
                            "anew")
    return here.relative(obj, rig.root, [bone.name for bone in rig.bones], None), keys


def rig_of(obj: bpy.types.Object) -> tuple[PoseRig, list[str]]:
    """The rig for the core, and warnings. Raises UserError if nothing can be compared."""
    settings = obj.rumple_maps
    notes: list[str] = []
    if not settings.bones and not settings.keys:
        raise UserError(f"{obj.name}: nothing is chosen to be compared: add a reference pose, or choose bones or "
                        "shape keys")
    keys = _tracked_keys(obj, notes)
    bones = _tracked_bones(obj, bool(keys), notes)
    rig = PoseRig(obj.name, settings.root if bones else "", bones, np.zeros((0, 6), np.float32), maps=settings.maps,
                  gain=settings.gain)
    for pose in settings.poses:
        rig.poses.append(ReferencePose(pose.name, rig.neutral, _file_name(pose.image), pose.strength, pose.muted,
                                       pose.solo))
    if bones:
        _place_bones(obj, rig, notes)
    if keys:
        _place_keys(obj, rig, keys, notes)
    return rig, notes


# --- its bones
def _tracked_bones(obj: bpy.types.Object, optional: bool, notes: list[str]) -> list[TrackedBone]:
    """The chosen bones that exist. optional: shape keys are compared too."""
    settings, armature = obj.rumple_maps, obj.find_armature()
    if not settings.bones:
        return []
    if armature is None and optional:
        notes.append(f"{obj.name}: no armature deforms it any more: only its shape keys are compared")
        return []
    armature = armature_of(obj)
    known = armature.data.bones
    if settings.root and settings.root not in known:
        raise UserError(f"{obj.name}: {armature.name} has no bone \"{settings.root}\" to be the root: choose another")
    bones = [TrackedBone(bone.name, bone.tracked, bone.group) for bone in settings.bones if bone.name in known]
    lost = [bone.name for bone in settings.bones if bone.name not in known]
    if not bones and not optional:
        raise UserError(f"{obj.name}: {armature.name} has none of the bones that are compared ({_listed(lost)}): "
                        "choose others")
    if lost:
        notes.append(f"{obj.name}: {armature.name} has no bone {_listed(lost)}: renamed or deleted? It is left out")
    idle = [bone.name for bone in bones if bone.name not in obj.vertex_groups]
    if idle:
        notes.append(f"{obj.name}: it has no vertex group {_listed(idle)}: these bones show no wrinkle")
    return bones


def _place_bones(obj: bpy.types.Object, rig: PoseRig, notes: list[str]) -> None:
    settings, names = obj.rumple_maps, [bone.name for bone in rig.bones]
    at_rest = _at_rest(armature_of(obj), rig.root).relative(obj, rig.root, names, None)
    rig.neutral = at_rest
    if settings.neutral:
        rig.neutral = _pose_of(obj, settings.neutral, "the neutral pose", names, at_rest, notes)
    for pose, stored in zip(rig.poses, settings.poses):
        pose.bones = _pose_of(obj, stored.bones, f"pose {pose.name}", names, rig.neutral, notes)


def _pose_of(obj: bpy.types.Object, records: Any, name: str, names: list[str], otherwise: np.ndarray,
             notes: list[str]) -> np.ndarray:
    root = obj.rumple_maps.root
    stored = _stored(records, root)
    if root and root not in stored.index:
        raise UserError(f"{obj.name}: {name} was stored without the root bone {root}: update it")
    _note_unknown(obj, name, [bone for bone in names if bone not in stored.index], notes)
    armature = armature_of(obj)
    applied = stored_poses.applied_since(records, armature)
    scale = None if applied is None else transforms.scale_of(applied)
    if scale is not None:
        stored.carry(applied, scale)
    elif applied is not None:
        notes.append(f"{obj.name}: {armature.name} was stretched or mirrored since {name} was stored: update it")
    return stored.relative(obj, root, names, otherwise)


def _note_unknown(obj: bpy.types.Object, pose: str, unknown: list[str], notes: list[str]) -> None:
    if unknown:
        notes.append(f"{obj.name}: {pose} was stored without {_listed(unknown)}: update it")


# --- its shape keys
def _tracked_keys(obj: bpy.types.Object, notes: list[str]) -> list[TrackedKey]:
    """The chosen keys that exist."""
    settings, known = obj.rumple_maps, {block.name for block in maps_keys.blocks(obj)}
    lost = [key.name for key in settings.keys if key.name not in known]
    why = f"{obj.name}: it has no shape key {_listed(lost)}: renamed or deleted? It is left out"
    if maps_keys.are_absolute(obj):
        why = f"{obj.name}: its shape keys are absolute: switch on Relative, since no map follows absolute ones"
    if lost and len(lost) == len(settings.keys) and not settings.bones:
        raise UserError(why)
    if lost:
        notes.append(why)
    return [TrackedKey(key.name, key.group) for key in settings.keys if key.name in known]


def _place_keys(obj: bpy.types.Object, rig: PoseRig, keys: list[TrackedKey], notes: list[str]) -> None:
    """Add the keys that differ from the neutral pose in some pose. Other keys have no influence, and would cost
    time."""
    settings, names = obj.rumple_maps, [key.name for key in keys]
    neutral = maps_keys.of_records(settings.neutral_keys)
    if neutral:
        _note_unknown(obj, "the neutral pose", [name for name in names if name not in neutral], notes)
    rest = np.array([neutral.get(name, 0.0) for name in names], np.float32)
    places = []
    for pose in settings.poses:
        stored = maps_keys.of_records(pose.keys)
        _note_unknown(obj, f"pose {pose.name}", [name for name in names if name not in stored], notes)
        places.append([stored.get(name, value) for name, value in zip(names, rest)])
    table = np.array(places, np.float32).reshape(len(rig.poses), len(names))
    _note_constant(obj, names, rest, table, notes)
    used = np.flatnonzero((np.abs(table - rest) > _SAME).any(0))
    if not len(used) and not rig.bones:
        used = np.arange(len(keys))
    rig.keys, rig.neutral_keys = [keys[place] for place in used], rest[used]
    for pose, row in zip(rig.poses, table):
        pose.keys = row[used]


def _note_constant(obj: bpy.types.Object, names: list[str], rest: np.ndarray, table: np.ndarray, notes: list[str]
                   ) -> None:
    """Warn about keys with the same value in every pose: they belong to the person, not to a pose."""
    if len(table) > 1:
        same = (np.abs(table - table[0]) < _SAME).all(0) & (np.abs(table[0] - rest) > maps_keys.SET)
        constant = [names[place] for place in np.flatnonzero(same)]
        if constant:
            notes.append(f"{obj.name}: {_listed(constant)} has the same value in every pose: go to the neutral face "
                         "and capture it")


def at_rest(obj: bpy.types.Object, rig: PoseRig) -> np.ndarray:
    """(7 b + 17,), or (0,) without bones: all that a skeleton depends on (hidden_meshes.py). Armature space."""
    if not rig.bones:
        return np.zeros(0, np.float32)
    known, names = armature_of(obj).data.bones, [bone.name for bone in rig.bones]
    rest = _at_rest(armature_of(obj), rig.root)
    root = rest.matrices.get(rig.root, np.eye(4))
    rigid = [not name or is_rigid(known[name]) for name in (*names, rig.root)]
    return np.concatenate([rest.points[[rest.index[name] for name in names]].ravel(), root.ravel(), rigid])


def is_rigid(bone: bpy.types.Bone) -> bool:
    """Whether an Armature modifier moves every point of its vertex group exactly like the bone."""
    return bone.use_deform and bone.bbone_segments == 1 and not bone.use_envelope_multiply


def _listed(names: list[str], most: int = 3) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def _file_name(image: bpy.types.Image | None) -> str:
    if image is None:
        return ""
    return bpy.path.basename(image.filepath_raw) or f"{bpy.path.clean_name(image.name)}.png"


def weights_of(obj: bpy.types.Object, rig: PoseRig) -> SkinWeights:
    """Weights of every bone that deforms the mesh, and of the shape keys."""
    bones = _skin_weights(obj, rig) if rig.bones else SkinWeights(
        np.zeros(len(obj.data.vertices) + 1, np.int32), np.zeros(0, np.int32), np.zeros(0, np.float32))
    return with_keys(bones, [maps_keys.weights(obj, key.name) for key in rig.keys], len(rig.bones))


def _skin_weights(obj: bpy.types.Object, rig: PoseRig) -> SkinWeights:
    """Weights of the bones. Cost: 1 ms per 1,000 vertices."""
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
    """Warnings about the wrinkle maps: missing, empty, of different sizes, read as colours."""
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
    """The map of every pose; None if it is missing or cannot be read, and so is not used."""
    return [pose.image if pose.image is not None and tuple(pose.image.size)[0] else None
            for pose in obj.rumple_maps.poses]
