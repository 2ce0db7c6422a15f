# SPDX-License-Identifier: GPL-3.0-or-later
"""Two scenes of the lessons that nothing else has: a skirt on a figure that turns, and a face with three bones.

Both are made from the demo's mannequin, in Blender. Metres, z up, the figure faces -y.
"""
from __future__ import annotations

import math

import bmesh
import bpy
import demo_body
import demo_scene
import numpy as np
from demo_body import Array
from interpolation import smoothstep

SKIRT_AROUND, SKIRT_ALONG = 56, 16
# Height, half width, half depth of the skirt, from the waistband to the hem.
SKIRT = np.array([[1.03, 0.150, 0.106], [0.98, 0.168, 0.122], [0.91, 0.192, 0.148], [0.78, 0.230, 0.196],
                  [0.48, 0.300, 0.274]])
TURN = ((1, 0.0), (8, 0.0), (34, 360.0), (60, 360.0))  # frame, degrees about z
SKIRT_FRAMES = (1, 60)
SKIRT_BODY_SPACING = 0.012  # metres: the file stays small
FACE_LOW, FACE_SPACING = 1.56, 0.006
# Bone, head; where its skin is, how far that reaches, metres. Tails point forwards.
FACE_BONES = {"brow.L": ((0.030, -0.085, 1.708), (0.040, 0.026)), "brow.R": ((-0.030, -0.085, 1.708), (0.040, 0.026)),
              "jaw": ((0.0, -0.060, 1.600), (0.050, 0.030))}


def skirt_mesh() -> tuple[Array, Array]:
    """Points (n, 3) and quads (m, 4), normals outward."""
    heights = np.interp(np.linspace(0.0, 1.0, SKIRT_ALONG), np.linspace(0.0, 1.0, len(SKIRT)), SKIRT[:, 0])
    wide, deep = (np.interp(-heights, -SKIRT[:, 0], SKIRT[:, column]) for column in (1, 2))
    angles = np.linspace(0.0, 2.0 * math.pi, SKIRT_AROUND, endpoint=False)
    points = np.stack([np.outer(wide, np.cos(angles)), np.outer(deep, np.sin(angles)) + 0.008,
                       np.repeat(heights[:, None], SKIRT_AROUND, 1)], axis=-1).reshape(-1, 3)
    quads = [((j + 1) * SKIRT_AROUND + i, (j + 1) * SKIRT_AROUND + (i + 1) % SKIRT_AROUND,
              j * SKIRT_AROUND + (i + 1) % SKIRT_AROUND, j * SKIRT_AROUND + i)
             for j in range(SKIRT_ALONG - 1) for i in range(SKIRT_AROUND)]
    return points, np.array(quads)


def build_skirt_scene() -> bpy.types.Object:
    """A figure that turns and stops, in a smooth skirt. Returns the skirt."""
    skeleton, scene = demo_scene.build_figure(SKIRT_BODY_SPACING), bpy.context.scene
    scene.frame_start, scene.frame_end = SKIRT_FRAMES
    points, quads = skirt_mesh()
    skirt = demo_scene.mesh_object("Skirt", points, quads, ("Shirt cloth",))
    skirt.vertex_groups.new(name="hips").add(range(len(points)), 1.0, "REPLACE")
    skirt.modifiers.new("Armature", "ARMATURE").object = skeleton
    skirt.parent = skeleton
    for frame, degrees in TURN:
        skeleton.rotation_euler.z = math.radians(degrees)
        skeleton.keyframe_insert("rotation_euler", index=2, frame=frame)
    demo_scene.add_camera_and_lights()
    bpy.context.view_layer.objects.active = skirt
    scene.frame_set(scene.frame_start)
    return skirt


def face_rig() -> bpy.types.Object:
    """The bones head > brow.L, brow.R, jaw."""
    rig = bpy.data.objects.new("Face Rig", bpy.data.armatures.new("Face Rig"))
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    head = rig.data.edit_bones.new("head")
    head.head, head.tail = (0.0, 0.02, 1.58), (0.0, 0.02, 1.62)  # short: behind a brow a click would take it
    for name, (place, _) in FACE_BONES.items():
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail, bone.parent = place, np.add(place, (0.0, -0.03, 0.0)), head
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.hide_render = True
    return rig


def face_weights(points: Array) -> dict[str, Array]:
    """Of every bone at the points; they sum to 1."""
    front = smoothstep((0.03 - points[:, 1]) / 0.06)
    weights = {}
    for name, (place, (across, up)) in FACE_BONES.items():
        way = (points[:, [0, 2]] - np.array(place)[[0, 2]]) / (across, up)
        weights[name] = front * np.exp(-(way * way).sum(axis=1))
    most = np.maximum(1.0, sum(weights.values()))
    weights = {name: weight / most for name, weight in weights.items()}
    return {**weights, "head": 1.0 - sum(weights.values())}


def cut_below(mesh: bpy.types.Mesh, z: float) -> Array:
    """Cut off what lies below z, metres, by a plane. Returns the vertices that are left, (n, 3) metres."""
    cut = bmesh.new()
    cut.from_mesh(mesh)
    bmesh.ops.bisect_plane(cut, geom=[*cut.verts, *cut.edges, *cut.faces], plane_co=(0.0, 0.0, z),
                           plane_no=(0.0, 0.0, 1.0), clear_inner=True)
    cut.to_mesh(mesh)
    cut.free()
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.reshape(-1))
    return points


def build_face_scene() -> bpy.types.Object:
    """The mannequin's head with two brows and a jaw to pose, and a UV map. Returns the head."""
    demo_scene.clear_scene()
    demo_scene.set_up_render()
    rig = face_rig()
    face = demo_scene.mesh_object("Face", *demo_body.build_body(FACE_SPACING, FACE_LOW - 0.02), ("Mannequin",))
    points = cut_below(face.data, FACE_LOW)
    polygon_size, corners = np.empty(len(face.data.polygons), np.int32), np.empty(len(face.data.loops), np.int32)
    face.data.polygons.foreach_get("loop_total", polygon_size)
    face.data.loops.foreach_get("vertex_index", corners)
    # From the front, what is behind beside it: no two places of the skin share a texel.
    first = np.cumsum(polygon_size) - polygon_size
    back = np.repeat(np.add.reduceat(points[corners, 1], first) / polygon_size > 0.02, polygon_size)
    u = (points[corners, 0] + 0.1) / 0.2 * 0.62
    uv = np.stack([np.where(back, 0.64 + u * 0.56, u), (points[corners, 2] - 1.55) / 0.28], axis=-1)
    face.data.uv_layers.new(name="UVMap").data.foreach_set("uv", np.ascontiguousarray(uv, np.float32).ravel())
    for name, weights in face_weights(points).items():
        group = face.vertex_groups.new(name=name)
        for vertex in np.flatnonzero(weights > 1e-3).tolist():
            group.add([vertex], float(weights[vertex]), "REPLACE")
    face.modifiers.new("Armature", "ARMATURE").object = rig
    demo_scene.add_camera_and_lights()
    bpy.context.view_layer.objects.active = face
    return face
