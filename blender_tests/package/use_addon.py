# SPDX-License-Identifier: GPL-3.0-or-later
"""Inside Blender, where Rumple was installed and enabled: one click on a skinned sleeve gives a finer mesh."""
from __future__ import annotations

import math
import sys

import bpy

HOME = sys.argv[-1]
RINGS, SEGMENTS, RADIUS, LENGTH = 13, 12, 0.1, 0.6


def add_armature() -> bpy.types.Object:
    """Two bones along x, the second bent by 60 degrees at the elbow."""
    bpy.ops.object.armature_add(enter_editmode=True)
    armature = bpy.context.object
    bones = armature.data.edit_bones
    upper, lower = bones[0], bones.new("lower")
    upper.name, upper.head, upper.tail = "upper", (0, 0, 0), (LENGTH / 2, 0, 0)
    lower.head, lower.tail, lower.parent = upper.tail, (LENGTH, 0, 0), upper
    bpy.ops.object.mode_set(mode="POSE")
    bend = armature.pose.bones["lower"]
    bend.rotation_mode = "XYZ"
    bend.rotation_euler = (math.radians(60), 0, 0)
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def add_sleeve(armature: bpy.types.Object) -> bpy.types.Object:
    points = [(LENGTH * ring / (RINGS - 1), RADIUS * math.cos(turn), RADIUS * math.sin(turn))
              for ring in range(RINGS) for turn in (2 * math.pi * k / SEGMENTS for k in range(SEGMENTS))]
    quads = [(a + k, a + (k + 1) % SEGMENTS, a + SEGMENTS + (k + 1) % SEGMENTS, a + SEGMENTS + k)
             for a in range(0, SEGMENTS * (RINGS - 1), SEGMENTS) for k in range(SEGMENTS)]
    mesh = bpy.data.meshes.new("Sleeve")
    mesh.from_pydata(points, [], quads)
    sleeve = bpy.data.objects.new("Sleeve", mesh)
    bpy.context.collection.objects.link(sleeve)
    upper, lower = sleeve.vertex_groups.new(name="upper"), sleeve.vertex_groups.new(name="lower")
    for index, point in enumerate(points):
        weight = min(max((point[0] / LENGTH - 0.4) / 0.2, 0.0), 1.0)
        upper.add([index], 1.0 - weight, "REPLACE")
        lower.add([index], weight, "REPLACE")
    modifier = sleeve.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    bpy.context.view_layer.objects.active = sleeve
    sleeve.select_set(True)
    return sleeve


def evaluated_vertices(thing: bpy.types.Object) -> int:
    return len(thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)


bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
sleeve = add_sleeve(add_armature())
result = bpy.ops.object.rumple_add(method="MESH")
assert result == {"FINISHED"}, result
bpy.context.scene.frame_set(2)
assert evaluated_vertices(sleeve) > len(sleeve.data.vertices), "the evaluated mesh is not finer than the base"
sleeve.rumple.bake_start, sleeve.rumple.bake_end = 1, 3
bpy.ops.wm.save_as_mainfile(filepath=f"{HOME}/worn.blend")
library = next(module for name, module in sys.modules.items() if name.endswith("rumple.native.library")).lib.path
assert str(library).startswith(HOME), f"the library is not the installed one: {library}"
shaders = next(module for name, module in sys.modules.items() if name.endswith("rumple.blender.viewport.glsl"))
assert shaders.__file__.startswith(HOME)
assert "void main()" in shaders.source(*shaders.FORMULAS, "preview/estimate_waves")
bpy.ops.object.rumple_remove()
assert evaluated_vertices(sleeve) == len(sleeve.data.vertices), "removing the wrinkles left something behind"
assert bpy.ops.wm.rumple_open_example(name="Shirt") == {"FINISHED"}
shirt = bpy.data.objects["Shirt"]
bpy.context.scene.frame_set(20)
assert bpy.data.filepath == "", "the example can be overwritten"
assert evaluated_vertices(shirt) > 4 * len(shirt.data.vertices), "the example shows no folds"
assert not shirt.rumple.message, shirt.rumple.message
print("RUMPLE WORKS with", library)
