# SPDX-License-Identifier: GPL-3.0-or-later
"""The two hidden objects that a Wrinkle Maps modifier reads, in no collection: its inputs keep them alive.

The skin has a point for each vertex, with its weights. The skeleton has two for each bone: Hook modifiers, Blender's
own, move them with its head and tail, and a constraint puts the object itself to the root bone. For a shape key it has
a point that a key of its own moves along x, driven by the value of the artist's. So the present pose
reaches the nodes within Blender's one evaluation of a frame: no handler, no second evaluation, and on a machine
without Rumple the masks follow the pose just so. What stands in their attributes says maps_mask_tree.py.
"""
from __future__ import annotations

from typing import Sequence

import bpy
import numpy as np
from mathutils import Matrix

from ...core.poses import ROW, PoseComparison, PoseRig, packed
from .. import compat
from ..nodes import maps_mask_tree

KEY = "rumple_maps_carrier"  # custom property: tells leftovers from the artist's objects
SHAPE = "rumple_maps_shape"  # ... and what it was made from
SKIN, SKELETON = ".maps", ".bones"
KEY_RANGE = -10.0, 10.0  # Blender's own limits


def _hidden(name: str, mesh: bpy.types.Mesh, shape: str) -> bpy.types.Object:
    hidden_obj = bpy.data.objects.new(name, mesh)
    hidden_obj[KEY], hidden_obj[SHAPE] = True, shape
    return hidden_obj


def made_from(hidden_obj: bpy.types.Object | None, shape: str) -> bool:
    """True where it can be written and is what new_skin() or new_skeleton() would make."""
    # An override of a hidden object has the linked mesh, where writing is silently ignored.
    return hidden_obj is not None and all(map(compat.is_editable,
                                              (hidden_obj, hidden_obj.data))) and hidden_obj.get(SHAPE) == shape


def new_skin(name: str, comparison: PoseComparison, shape: str) -> bpy.types.Object:
    """Without weights: write_weights() must follow."""
    table = comparison.table()
    mesh = bpy.data.meshes.new(name + SKIN)
    mesh.vertices.add(len(table.bone))
    for column in range(ROW):
        compat.write_attribute(mesh, maps_mask_tree.BONE.format(column), "INT", "POINT", table.bone[:, column])
    for row, further in enumerate(table.more):
        values = np.full(len(table.bone), -1, np.int32)
        values[:len(further)] = further
        compat.write_attribute(mesh, maps_mask_tree.MORE.format(row), "INT", "POINT", values)
    return _hidden(name + SKIN, mesh, shape)


def write_weights(hidden_obj: bpy.types.Object, comparison: PoseComparison, gain: float,
                  strength: Sequence[float]) -> None:
    """With gain and strengths. The only thing that handlers write, and only where these are animated."""
    table = comparison.table()
    for number, lifts in enumerate(packed(comparison.lifts(gain, strength))):
        for column in range(ROW):
            compat.write_attribute(hidden_obj.data, maps_mask_tree.WEIGHTS.format(number, column), "FLOAT_VECTOR",
                                   "POINT",
                                   table.weight[:, column, None] * lifts[table.vertex])
    hidden_obj.data.update()


def new_skeleton(obj: bpy.types.Object, comparison: PoseComparison, shape: str) -> bpy.types.Object:
    """Follows the bones that deform an object, in the space of the root bone, and its shape keys."""
    rig, count = comparison.rig, len(comparison.rig.elements)
    mesh = bpy.data.meshes.new(obj.name + SKELETON)
    mesh.vertices.add(2 * count)
    hidden_obj = _hidden(obj.name + SKELETON, mesh, shape)
    if rig.bones:
        _follow_bones(hidden_obj, rig, count, obj.find_armature())
    _write_rig(mesh, comparison)
    mesh.update()
    if rig.keys:
        _follow_keys(hidden_obj, rig, obj.data.shape_keys)
    return hidden_obj


def _follow_bones(hidden_obj: bpy.types.Object, rig: PoseRig, count: int, armature: bpy.types.Object) -> None:
    tails = np.zeros((2 * count, 3), np.float32)  # every point in the space of its bone
    tails[count:count + len(rig.bones), 1] = [armature.data.bones[bone.name].length for bone in rig.bones]
    compat.set_positions(hidden_obj.data, tails)
    for number, bone in enumerate(rig.bones):
        _hook(hidden_obj, armature, bone.name, [number, count + number])
    at_root = hidden_obj.constraints.new("COPY_TRANSFORMS")
    at_root.target, at_root.subtarget = armature, rig.root


def _follow_keys(hidden_obj: bpy.types.Object, rig: PoseRig, keys: bpy.types.Key) -> None:
    """Points at the origin, each moved along x by its key's value. Blender mends the drivers where keys are renamed."""
    hidden_obj.shape_key_add(name="Basis")
    for point, tracked in enumerate(rig.keys, len(rig.bones)):
        block = hidden_obj.shape_key_add(name=str(point), from_mix=False)
        block.slider_min, block.slider_max = KEY_RANGE
        block.data[point].co.x += 1.0
        driver = hidden_obj.data.shape_keys.driver_add(f'key_blocks["{point}"].value').driver
        for name in ("value", "mute"):
            variable = driver.variables.new()
            variable.name = name
            target = variable.targets[0]
            target.id_type, target.id = "KEY", keys
            target.data_path = f'key_blocks["{bpy.utils.escape_identifier(tracked.name)}"].{name}'
        driver.expression = "value * (1 - mute)"  # simple: Blender computes it without Python, and asks for no trust


def armature_of(skeleton: bpy.types.Object) -> bpy.types.Object | None:
    """The armature that it follows."""
    return next((c.target for c in skeleton.constraints if c.type == "COPY_TRANSFORMS"), None)


def keys_of(skeleton: bpy.types.Object) -> bpy.types.Key | None:
    """The shape keys that it follows."""
    own = skeleton.data.shape_keys
    drivers = own.animation_data.drivers if own is not None and own.animation_data is not None else ()
    return drivers[0].driver.variables[0].targets[0].id if len(drivers) else None


def follows(skeleton: bpy.types.Object, obj: bpy.types.Object, rig: PoseRig) -> bool:
    """It has the bones and shape keys of this object, not those of another that it was copied from."""
    return (armature_of(skeleton) == (obj.find_armature() if rig.bones else None)
            and keys_of(skeleton) == (obj.data.shape_keys if rig.keys else None))


def _write_rig(mesh: bpy.types.Mesh, comparison: PoseComparison) -> None:
    rig, count = comparison.rig, len(comparison.rig.elements)

    def ends(bones: np.ndarray) -> np.ndarray:
        """(b + m, 6) heads and tails as points: all heads and keys, then all tails."""
        return np.concatenate([bones[:, :3], bones[:, 3:]])

    def write(name: str, data_type: str, values: np.ndarray) -> None:
        compat.write_attribute(mesh, name, data_type, "POINT", values)

    write(maps_mask_tree.NEUTRAL, "FLOAT_VECTOR", ends(comparison.neutral()))
    for number, slope in enumerate(comparison.slopes()):
        write(maps_mask_tree.SLOPE.format(number), "FLOAT_VECTOR", ends(slope))
    group = rig.group_numbers()
    alone = group < 0
    group[alone] = count + np.flatnonzero(alone)
    write(maps_mask_tree.GROUP, "INT", np.concatenate([group, np.full(count, -1, np.int32)]))  # tails count for none
    for number, shares in enumerate(packed(comparison.shares())):
        write(maps_mask_tree.SHARE.format(number), "FLOAT_VECTOR", np.concatenate([shares, np.zeros_like(shares)]))


def _hook(hidden_obj: bpy.types.Object, armature: bpy.types.Object, bone: str, points: list[int]) -> None:
    """A Hook, not an Armature modifier: that one leaves out bones without Deform, as roots often are."""
    hook = hidden_obj.modifiers.new(bone, "HOOK")
    hook.object, hook.subtarget = armature, bone
    hook.vertex_indices_set(points)
    hook.falloff_type, hook.strength = "NONE", 1.0
    hook.matrix_inverse = Matrix.Identity(4)  # the points lie in the bone's own space
