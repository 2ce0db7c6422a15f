# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of the gallery: Cycles, a low sun from the left that shows folds, a cooler one from behind, an even sky."""
from __future__ import annotations

import math

import addon_utils
import bpy
from mathutils import Vector

SAMPLES = 20
# Where the light comes from, watts per square metre, its angle in degrees, colour.
SUNS = {
    "Key": ((-0.75, -0.45, 0.55), 3.4, 14.0, (1.0, 0.96, 0.90)),
    "Rim": ((0.55, 0.65, 0.45), 2.0, 10.0, (0.86, 0.92, 1.0)),
}
SKY, SKY_STRENGTH = (0.36, 0.40, 0.46), 0.6


def light(scene: bpy.types.Scene) -> None:
    """Replace the lights and the world of a scene; materials stay as they are."""
    addon_utils.enable("cycles")
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = SAMPLES, False, False
    cycles.max_bounces, cycles.diffuse_bounces, cycles.sample_clamp_indirect = 3, 2, 2.0
    scene.view_settings.view_transform, scene.view_settings.look = "Filmic", "Medium High Contrast"
    for lamp in [thing for thing in scene.objects if thing.type == "LIGHT"]:
        bpy.data.objects.remove(lamp)
    for name, (direction, power, angle, colour) in SUNS.items():
        sun = bpy.data.lights.new(name, "SUN")
        sun.energy, sun.angle, sun.color = power, math.radians(angle), colour
        lamp = bpy.data.objects.new(name, sun)
        lamp.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    world = scene.world = bpy.data.worlds.new("Gallery")
    world.use_nodes = True
    sky = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    sky.inputs["Color"].default_value = (*SKY, 1.0)
    sky.inputs["Strength"].default_value = SKY_STRENGTH
