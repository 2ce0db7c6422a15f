# SPDX-License-Identifier: GPL-3.0-or-later
"""A small face: a sheet with two brows that a bone each moves, on a head that may move as a whole."""
from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from rumple.blender import compat
from rumple.blender.maps import runtimes as maps_runtimes
from rumple.blender.nodes import maps_mask_tree, wrinkle_tree
from rumple.blender.objects import modifier
from support import sleeve

SIDE = 13  # vertices along each side of 0.12 m
BROWS = ("brow.L", "brow.R")


def sheet() -> bpy.types.Mesh:
    """A flat face in the xz plane that looks along -y, with a UV map and a material."""
    place = np.linspace(-0.06, 0.06, SIDE)
    vertices = [(x, 0.0, z) for z in place for x in place]
    quads = [(j * SIDE + i, j * SIDE + i + 1, (j + 1) * SIDE + i + 1, (j + 1) * SIDE + i)
             for j in range(SIDE - 1) for i in range(SIDE - 1)]
    mesh = bpy.data.meshes.new("Face")
    mesh.from_pydata(vertices, [], quads)
    corners = np.array([vertices[v] for quad in quads for v in quad], np.float32)
    uv = (corners[:, [0, 2]] + 0.06) / 0.12
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.ascontiguousarray(uv).ravel())
    material = bpy.data.materials.new("Skin")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    mesh.materials.append(material)
    return mesh


def head() -> bpy.types.Object:
    """Bones neck > head > brow.L, brow.R, jaw."""
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    places = dict(neck=((0, 0, -0.2), (0, 0, -0.1)), head=((0, 0, -0.1), (0, 0, 0.1)),
                  jaw=((0, 0.02, -0.02), (0, 0, -0.06)))
    places.update({"brow.L": ((0.03, 0.01, 0.02), (0.03, 0, 0.02)), "brow.R": ((-0.03, 0.01, 0.02), (-0.03, 0, 0.02))})
    for name, (start, end) in places.items():
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = start, end
    for name, parent in (("head", "neck"), ("jaw", "head"), ("brow.L", "head"), ("brow.R", "head")):
        rig.data.edit_bones[name].parent = rig.data.edit_bones[parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def share(x: float, z: float) -> tuple[float, float, float]:
    """Weights of (brow.L, brow.R, jaw); the head has the rest."""
    def near(cx: float, cz: float, reach: float) -> float:
        return max(0.0, 1.0 - math.hypot(x - cx, z - cz) / reach)
    return near(0.03, 0.02, 0.03), near(-0.03, 0.02, 0.03), near(0.0, -0.06, 0.05)


def scene(maps: bool = True) -> tuple[bpy.types.Object, bpy.types.Object]:
    """(face, rig) in an empty file, with Wrinkle Maps unless told otherwise."""
    sleeve.empty_file()
    with sleeve.context():
        rig, mesh = head(), sheet()
        obj = bpy.data.objects.new("Face", mesh)
        bpy.context.scene.collection.objects.link(obj)
        groups = [obj.vertex_groups.new(name=name) for name in (*BROWS, "jaw", "head")]
        for vertex in mesh.vertices:
            weights = share(vertex.co.x, vertex.co.z)
            for group, weight in zip(groups, (*weights, 1.0 - sum(weights))):
                if weight > 0.0:
                    group.add([vertex.index], weight, "REPLACE")
        obj.modifiers.new("Armature", "ARMATURE").object = rig
        sleeve.make_active(obj)
        if maps:
            bpy.ops.object.rumple_add(method="MAPS")
    return obj, rig


def pose(rig: bpy.types.Object, **heights: Any) -> None:
    """Raise bones by metres: brow_L=0.01, jaw=-0.02. The others go to rest."""
    for bone in rig.pose.bones:
        bone.matrix_basis.identity()
    for name, height in heights.items():
        bone = rig.pose.bones[name.replace("_", ".")]
        bone.location = bone.bone.matrix_local.to_3x3().inverted() @ Vector((0.0, 0.0, height))
    with sleeve.context():
        bpy.context.view_layer.update()


def two_poses(obj: bpy.types.Object, rig: bpy.types.Object) -> Any:
    """Surprise: both brows up. Anger: both down and the jaw up."""
    for name, heights in (("Surprise", dict(brow_L=0.01, brow_R=0.01)),
                          ("Anger", dict(brow_L=-0.008, brow_R=-0.008, jaw=0.005))):
        pose(rig, **heights)
        with sleeve.context():
            bpy.ops.rumple.pose_add(name=name)
    pose(rig)
    return obj.rumple_maps


def animate(rig: bpy.types.Object) -> None:
    """The left brow rises linearly: rest at frame 1, its place in Surprise at frame 11."""
    for frame, height in ((1, 0.0), (11, 0.01)):
        pose(rig, brow_L=height)
        rig.pose.bones["brow.L"].keyframe_insert("location", frame=frame)
    for curve in compat.keyed_curves(rig.animation_data):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def risen(frame: Any) -> Any:
    """The influence that animate() gives."""
    return (frame - 1) / 10


def mask(obj: bpy.types.Object, name: str) -> np.ndarray:
    """A mask on the evaluated mesh, (n,)."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return compat.read_attribute(evaluated.data.attributes[maps_mask_tree.MASK.format(name)])[:, 0]


def carried(obj: bpy.types.Object, values: np.ndarray) -> np.ndarray:
    """(n,) of the coarse vertices on the points that are shown: those of a Wrinkle Mesh (Field, Paths) where one is."""
    if modifier.find(obj) is None or not modifier.find(obj).show_viewport:
        return values
    attributes = modifier.output_object(modifier.find(obj)).data.attributes
    corners = [values[compat.read_attribute(attributes[name])[:, 0]] for name in wrinkle_tree.CORNERS]
    u, v, _ = compat.read_attribute(attributes[wrinkle_tree.BARYCENTRIC]).T
    return (1.0 - u - v) * corners[0] + u * corners[1] + v * corners[2]


def weights(obj: bpy.types.Object, name: str) -> np.ndarray:
    """(n,) of a vertex group."""
    index = obj.vertex_groups[name].index
    return np.array([sum(e.weight for e in vertex.groups if e.group == index) for vertex in obj.data.vertices],
                    np.float32)


def notes(obj: bpy.types.Object) -> str:
    return " | ".join(maps_runtimes.of(obj).notes)


class TwoPoses:
    """A test of a face with two reference poses: mix it into a TestCase."""

    def setUp(self) -> None:
        self.obj, self.rig = scene()
        self.settings = two_poses(self.obj, self.rig)
