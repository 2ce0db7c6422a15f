# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of the gallery: Cycles, a low sun from the left that shows folds, a cooler one from behind, an even sky and
a floor that takes shadows; and its cloth, which has the sheen of fibres. What is bare and what is wrinkled get the
same.
"""
from __future__ import annotations

import math
import subprocess
from pathlib import Path

import addon_utils
import bpy
from mathutils import Vector

SAMPLES = 32  # of each pixel
# ffmpeg's filters, for Debian's Blender has no denoiser. The median takes single pixels out of the edges of shadows:
# non-local means would keep them.
DENOISE = "format=gbrp,median=radius=1,nlmeans=s=4:p=5:r=11"
# Where the light comes from, watts per square metre, its angle in degrees, colour.
SOFT_KEY = (-0.75, -0.45, 0.55), 3.4, 14.0, (1.0, 0.96, 0.90)
SUNS = {
    "Key": ((-0.85, -0.30, 0.50), 4.2, 7.0, (1.0, 0.96, 0.90)),
    "Rim": ((0.55, 0.65, 0.45), 2.0, 10.0, (0.86, 0.92, 1.0)),
}
SKY, SKY_STRENGTH, SOFT_SKY_STRENGTH = (0.36, 0.40, 0.46), 0.24, 0.35
BACKDROP = (0.30, 0.31, 0.32), (0.055, 0.062, 0.075)  # what the camera sees of the sky, at the bottom and at the top
FLOOR = (0.34, 0.36, 0.39)
FLOOR_RADIUS = 2.6  # metres: there the floor has faded into the sky
SHEEN, SHEEN_TINT, SPECULAR = 0.9, 0.6, 0.15
# Linear colour, roughness, sheen.
LOOKS = {
    "COTTON": ((0.24, 0.44, 0.62), 0.85, 0.9), "JERSEY": ((0.46, 0.07, 0.07), 0.9, 0.9),
    "SILK": ((0.62, 0.50, 0.30), 0.30, 0.2), "WOOL": ((0.30, 0.28, 0.25), 1.0, 1.0),
    "SUIT": ((0.06, 0.065, 0.09), 0.95, 0.7),
    "DENIM": ((0.045, 0.085, 0.20), 0.9, 0.6), "LEATHER": ((0.11, 0.050, 0.022), 0.35, 0.0),
    "STRETCH": ((0.025, 0.030, 0.055), 0.42, 0.1),
    "SKIN": ((0.62, 0.40, 0.31), 0.5, 0.0), "PAPER": ((0.62, 0.63, 0.64), 0.8, 0.0)}


def light(scene: bpy.types.Scene, soft: bool = False) -> None:
    """Replace the lights and the world of a scene; materials stay as they are. soft: with less shadow, for faces and
    small figures."""
    addon_utils.enable("cycles")
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = SAMPLES, False, False
    cycles.max_bounces, cycles.diffuse_bounces, cycles.sample_clamp_indirect = 2, 1, 0.5
    scene.view_settings.view_transform, scene.view_settings.look = "Filmic", "Medium High Contrast"
    for lamp in [thing for thing in scene.objects if thing.type == "LIGHT"]:
        bpy.data.objects.remove(lamp)
    for name, (direction, power, angle, colour) in (SUNS | {"Key": SOFT_KEY} if soft else SUNS).items():
        sun = bpy.data.lights.new(name, "SUN")
        sun.energy, sun.angle, sun.color = power, math.radians(angle), colour
        lamp = bpy.data.objects.new(name, sun)
        lamp.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    world = scene.world = bpy.data.worlds.new("Gallery")
    world.use_nodes = True
    sky = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    sky.inputs["Color"].default_value = (*SKY, 1.0)
    sky.inputs["Strength"].default_value = SOFT_SKY_STRENGTH if soft else SKY_STRENGTH
    hang_backdrop(world.node_tree, sky)


def hang_backdrop(tree: bpy.types.NodeTree, sky: bpy.types.Node) -> None:
    """Behind what is lit by an even sky the camera sees paper that gets darker upwards."""
    nodes = {kind: tree.nodes.new(f"ShaderNode{kind}") for kind in (
        "TexCoord", "SeparateXYZ", "MixRGB", "Background", "LightPath", "MixShader")}
    for number, colour in enumerate(BACKDROP, 1):
        nodes["MixRGB"].inputs[number].default_value = (*colour, 1.0)
    end = next(node for node in tree.nodes if node.type == "OUTPUT_WORLD")
    for source, sink in ((nodes["TexCoord"].outputs["Window"], nodes["SeparateXYZ"].inputs[0]),
                         (nodes["SeparateXYZ"].outputs["Y"], nodes["MixRGB"].inputs[0]),
                         (nodes["MixRGB"].outputs[0], nodes["Background"].inputs["Color"]),
                         (nodes["LightPath"].outputs["Is Camera Ray"], nodes["MixShader"].inputs[0]),
                         (sky.outputs[0], nodes["MixShader"].inputs[1]),
                         (nodes["Background"].outputs[0], nodes["MixShader"].inputs[2]),
                         (nodes["MixShader"].outputs[0], end.inputs["Surface"])):
        tree.links.new(source, sink)


def add_floor(scene: bpy.types.Scene) -> bpy.types.Object:
    """A disk at z = 0 that takes shadows around its middle and fades into the sky."""
    mesh = bpy.data.meshes.new("Floor")
    rim = [(FLOOR_RADIUS * math.cos(angle), FLOOR_RADIUS * math.sin(angle), 0.0)
           for angle in (math.tau * step / 64 for step in range(64))]
    mesh.from_pydata(rim, [], [range(64)])
    floor = bpy.data.objects.new("Floor", mesh)
    scene.collection.objects.link(floor)
    made = bpy.data.materials.new("Floor")
    mesh.materials.append(made)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    nodes = {kind: tree.nodes.new(f"ShaderNode{kind}") for kind in (
        "TexCoord", "VectorMath", "MapRange", "BsdfDiffuse", "BsdfTransparent", "MixShader", "OutputMaterial")}
    nodes["VectorMath"].operation = "LENGTH"
    ramp = nodes["MapRange"]
    ramp.interpolation_type = "SMOOTHSTEP"
    for name, value in (("From Min", 0.25 * FLOOR_RADIUS), ("From Max", FLOOR_RADIUS)):
        ramp.inputs[name].default_value = value
    nodes["BsdfDiffuse"].inputs["Color"].default_value = (*FLOOR, 1.0)
    for source, sink in ((nodes["TexCoord"].outputs["Object"], nodes["VectorMath"].inputs[0]),
                         (nodes["VectorMath"].outputs["Value"], ramp.inputs["Value"]),
                         (ramp.outputs["Result"], nodes["MixShader"].inputs[0]),
                         (nodes["BsdfDiffuse"].outputs[0], nodes["MixShader"].inputs[1]),
                         (nodes["BsdfTransparent"].outputs[0], nodes["MixShader"].inputs[2]),
                         (nodes["MixShader"].outputs[0], nodes["OutputMaterial"].inputs["Surface"])):
        tree.links.new(source, sink)
    return floor


def render(picture: Path) -> None:
    """Leave the present frame as a PNG; single pixels are replaced by the median, patches that are alike are averaged
    (Buades 2005). Needs ffmpeg."""
    scene, noisy = bpy.context.scene, picture.with_suffix(".noisy.png")
    scene.render.image_settings.file_format, scene.render.filepath = "PNG", str(noisy)
    bpy.ops.render.render(write_still=True)
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-i", str(noisy), "-vf", DENOISE, str(picture)],
                   check=True)
    noisy.unlink()


def as_cloth(garment: bpy.types.Object) -> None:
    """The sheen of fibres for its materials."""
    for slot in garment.material_slots:
        tree = slot.material.node_tree
        for shader in [node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"]:
            for name, value in (("Sheen", SHEEN), ("Sheen Tint", SHEEN_TINT), ("Specular", SPECULAR)):
                shader.inputs[name].default_value = value


def dye(garment: bpy.types.Object, preset: str) -> None:
    """The colour and the gloss of a fabric, for all of it."""
    colour, roughness, sheen = LOOKS[preset]
    for slot in garment.material_slots:
        shader = next(node for node in slot.material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        for name, value in (("Base Color", (*colour, 1.0)), ("Roughness", roughness), ("Sheen", sheen),
                            ("Specular", 0.5 if roughness < 0.5 else SPECULAR)):
            shader.inputs[name].default_value = value
