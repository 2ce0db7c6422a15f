# SPDX-License-Identifier: GPL-3.0-or-later
"""The two hidden objects that a Wrinkle Maps modifier reads, in no collection: its inputs keep them alive.

The skin has a point for each vertex, with its weights. The skeleton has two for each bone: Hook modifiers, Blender's
own, move them with its head and tail. So the present pose reaches the nodes within Blender's one evaluation of a
frame: no handler, no second evaluation, and on a machine without Rumple the masks follow the bones just so.
What stands in their attributes says maps_geometry.py.
"""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ..core.poses import ROW, PoseComparison, packed
from . import maps_geometry, versions

KEY = "rumple_maps_carrier"  # custom property: tells leftovers from the artist's objects
SHAPE = "rumple_maps_shape"  # ... and what it was made from
SKIN, SKELETON = ".maps", ".bones"


def _hidden(name: str, mesh: bpy.types.Mesh, shape: str) -> bpy.types.Object:
    held = bpy.data.objects.new(name, mesh)
    held[KEY], held[SHAPE] = True, shape
    return held


def made_from(held: bpy.types.Object | None, shape: str) -> bool:
    """True where it can be written and is what new_skin() or new_skeleton() would make."""
    return held is not None and versions.is_editable(held) and held.get(SHAPE) == shape


def new_skin(name: str, comparison: PoseComparison, shape: str) -> bpy.types.Object:
    """Without lifts: write_lifts() must follow."""
    table = comparison.table()
    mesh = bpy.data.meshes.new(name + SKIN)
    mesh.vertices.add(len(table.bone))
    for column in range(ROW):
        versions.write_attribute(mesh, maps_geometry.BONE.format(column), "INT", "POINT", table.bone[:, column])
        versions.write_attribute(mesh, maps_geometry.WEIGHT.format(column), "FLOAT", "POINT", table.weight[:, column])
    for row, further in enumerate(table.more):
        values = np.full(len(table.bone), -1, np.int32)
        values[:len(further)] = further
        versions.write_attribute(mesh, maps_geometry.MORE.format(row), "INT", "POINT", values)
    mesh.update()
    return _hidden(name + SKIN, mesh, shape)


def write_lifts(held: bpy.types.Object, lifts: np.ndarray) -> None:
    """Gain and strengths: (o, n). The only thing that handlers write, and only where these are animated."""
    count = len(held.data.vertices)
    for number, pack in enumerate(packed(lifts)):
        values = np.zeros((count, pack.shape[1]), np.float32)
        values[:len(pack)] = pack
        versions.write_attribute(held.data, maps_geometry.LIFT.format(number), "FLOAT_VECTOR", "POINT", values)
    held.data.update()


def new_skeleton(name: str, comparison: PoseComparison, armature: bpy.types.Object, shape: str) -> bpy.types.Object:
    """Follows the bones of an armature, in its space."""
    rig, known = comparison.rig, armature.data.bones
    count = len(rig.bones)
    rest = np.zeros((2 * count + maps_geometry.ROOT_POINTS, 3), np.float32)  # of every point, in its bone's space
    rest[count:2 * count, 1] = [known[bone.name].length for bone in rig.bones]
    rest[2 * count + 1:] = np.eye(3)
    mesh = bpy.data.meshes.new(name + SKELETON)
    mesh.vertices.add(len(rest))
    versions.set_positions(mesh, rest)
    _write_rig(mesh, comparison)
    mesh.update()
    held = _hidden(name + SKELETON, mesh, shape)
    held.parent = armature
    for number, bone in enumerate(rig.bones):
        _hook(held, armature, bone.name, [number, count + number])
    _hook(held, armature, rig.root, list(range(2 * count, len(rest))))
    return held


def _write_rig(mesh: bpy.types.Mesh, comparison: PoseComparison) -> None:
    rig, count = comparison.rig, len(comparison.rig.bones)

    def write(name: str, data_type: str, values: np.ndarray) -> None:
        """For the points of the bones; those of the root get zeros."""
        padded = np.zeros((len(mesh.vertices), *values.shape[1:]), values.dtype)
        padded[:len(values)] = values
        versions.write_attribute(mesh, name, data_type, "POINT", padded)

    def ends(bones: np.ndarray) -> np.ndarray:
        """(b, 6) heads and tails as points: all heads, then all tails."""
        return np.concatenate([bones[:, :3], bones[:, 3:]])

    write(maps_geometry.NEUTRAL, "FLOAT_VECTOR", ends(rig.neutral))
    for number, slope in enumerate(comparison.slopes()):
        write(maps_geometry.SLOPE.format(number), "FLOAT_VECTOR", ends(slope))
    group = rig.group_numbers()
    alone = group < 0
    group[alone] = len(group) + np.flatnonzero(alone)
    write(maps_geometry.GROUP, "INT", np.concatenate([group, np.full(count, -1, np.int32)]))
    for number, pack in enumerate(packed(comparison.shares())):
        write(maps_geometry.SHARE.format(number), "FLOAT_VECTOR", pack)


def _hook(held: bpy.types.Object, armature: bpy.types.Object, bone: str, points: list[int]) -> None:
    """A Hook, not an Armature modifier: that one leaves out bones without Deform, as roots often are."""
    hook = held.modifiers.new(bone, "HOOK")
    hook.object, hook.subtarget = armature, bone
    hook.vertex_indices_set(points)
    hook.falloff_type, hook.strength = "NONE", 1.0
    hook.matrix_inverse = Matrix.Identity(4)  # the points lie in the bone's own space
