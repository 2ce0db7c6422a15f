# SPDX-License-Identifier: GPL-3.0-or-later
"""A figure of any height that stands on two legs: its skeleton, its body, and a dress over it."""
from __future__ import annotations

import bpy
import numpy as np
from support import sleeve

HEIGHT = 1.8
# name, parent, x and z of the head of a bone of a figure of HEIGHT
MIDDLE = (("root", "", 0.0, 0.0), ("hips", "root", 0.0, 0.95), ("spine", "hips", 0.0, 1.1),
          ("chest", "spine", 0.0, 1.3), ("neck", "chest", 0.0, 1.5), ("head", "neck", 0.0, 1.58))
LIMBS = (("thigh", "hips", 0.1, 0.92), ("shin", "thigh", 0.1, 0.5), ("foot", "shin", 0.1, 0.08),
         ("shoulder", "chest", 0.05, 1.45), ("upper_arm", "shoulder", 0.18, 1.45),
         ("forearm", "upper_arm", 0.45, 1.45), ("hand", "forearm", 0.7, 1.45))
AROUND, ALONG = 16, 12


def skeleton(height: float = HEIGHT) -> bpy.types.Object:
    """An armature in the open file."""
    rig = bpy.data.objects.new("Figure", bpy.data.armatures.new("Figure"))
    bpy.context.scene.collection.objects.link(rig)
    sleeve.make_active(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    limbs = [(name + side, parent + side if parent in {one[0] for one in LIMBS} else parent, sign * x, z)
             for side, sign in ((".L", 1.0), (".R", -1.0)) for name, parent, x, z in LIMBS]
    for name, parent, x, z in (*MIDDLE, *limbs):
        add_bone(rig, name, parent, (x, 0.0, z), height / HEIGHT)
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def add_bone(rig: bpy.types.Object, name: str, parent: str, head: tuple[float, float, float],
             scale: float = 1.0) -> None:
    """Add a bone to an armature in Edit Mode."""
    bone = rig.data.edit_bones.new(name)
    bone.head = scale * np.array(head)
    bone.tail = scale * (np.array(head) + (0.0, 0.0, 0.05))
    bone.parent = rig.data.edit_bones.get(parent)


def tube(rig: bpy.types.Object, name: str, radius: float, low: float, high: float) -> bpy.types.Object:
    """A tube around the z axis between two heights that hips and chest of a skeleton move. The object is linked and not
    wrinkled."""
    heights = np.linspace(low, high, ALONG)
    turns = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    points = [(radius * np.cos(turn), radius * np.sin(turn), height) for height in heights for turn in turns]
    faces = [(row * AROUND + k, row * AROUND + (k + 1) % AROUND, (row + 1) * AROUND + (k + 1) % AROUND,
              (row + 1) * AROUND + k) for row in range(ALONG - 1) for k in range(AROUND)]
    obj = skinned(rig, name, points, faces)
    middle = 0.5 * (low + high)
    for bone, below in (("hips", True), ("chest", False)):
        numbers = [vertex.index for vertex in obj.data.vertices if (vertex.co.z < middle) == below]
        obj.vertex_groups.new(name=bone).add(numbers, 1.0, "REPLACE")
    return obj


def skinned(rig: bpy.types.Object, name: str, points: list, faces: list) -> bpy.types.Object:
    """An object with an Armature modifier and without weights."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    mesh.update()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    return obj


def dressed(height: float = HEIGHT, low: float = 0.8, high: float = 1.5) -> bpy.types.Object:
    """A file with a figure of this height in a garment between two heights of a figure of HEIGHT. Returns the
    garment."""
    sleeve.empty_file()
    scale = height / HEIGHT
    rig = skeleton(height)
    tube(rig, "Body", 0.12 * scale, 0.0, height)
    return tube(rig, "Dress", 0.14 * scale, low * scale, high * scale)
