# SPDX-License-Identifier: GPL-3.0-or-later
"""A quad whose pixels are the texels of its wrinkle maps, seen through the node group "Rumple Maps"."""
from __future__ import annotations

import os
import tempfile
import unittest
from typing import Any

import bpy
import numpy as np
from rumple import native
from rumple.blender import compat
from rumple.blender.nodes import maps_shader
from support import small_renders

SIDE = 32
STEP = 1.0 / 255.0  # of eight bits


def image(name: str, texels: np.ndarray) -> bpy.types.Image:
    """(SIDE, SIDE, 3) uint8, the lowest row first."""
    made = bpy.data.images.new(name, SIDE, SIDE)
    made.colorspace_settings.name = "Non-Color"
    pixels = np.ones((SIDE, SIDE, 4), np.float32)
    pixels[:, :, :3] = texels / np.float32(255)
    made.pixels.foreach_set(pixels.ravel())
    made.update()
    made.pack()
    return made


def normals(random: np.random.Generator) -> np.ndarray:
    """Random texels of a tangent-space normal map, some of them steep."""
    tilted = random.uniform((-1, -1, 0.2), (1, 1, 1), (SIDE, SIDE, 3))
    tilted /= np.sqrt((tilted * tilted).sum(2, keepdims=True))
    return np.rint(255 * (0.5 * tilted + 0.5)).astype(np.uint8)


def emit_normals(tree: bpy.types.NodeTree) -> None:
    """Let a material show the world normals of its Normal Map node, encoded as colours."""
    emission, encode = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeVectorMath")
    encode.operation = "MULTIPLY_ADD"
    encode.inputs[1].default_value = encode.inputs[2].default_value = (0.5,) * 3
    tree.links.new(tree.nodes["Normal Map"].outputs["Normal"], encode.inputs[0])
    tree.links.new(encode.outputs["Vector"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.get_output_node("ALL").inputs["Surface"])


class Quad:
    """Masks that change linearly over it, a random map for each pose, and a random neutral map."""

    def __init__(self, poses: int, maps: str, seed: int = 0) -> None:
        random = np.random.default_rng(seed)
        self.maps = maps
        self.neutral = normals(random)
        self.wrinkles = [normals(random) for _ in range(poses)]
        self.slopes = random.uniform(0, 0.5, (poses, 3)).astype(np.float32)  # of each mask: along u, along v, at (0, 0)
        self.obj = self.build()

    def build(self) -> bpy.types.Object:
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        mesh = bpy.data.meshes.new("Quad")
        corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
        mesh.from_pydata(corners.tolist(), [], [(0, 1, 2, 3)])
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.ascontiguousarray(corners[:, :2]).ravel())
        packs = np.zeros((4, 3 * ((len(self.wrinkles) + 2) // 3)), np.float32)
        packs[:, :len(self.wrinkles)] = self.masks(corners[:, 0], corners[:, 1]).T
        for pack in range(packs.shape[1] // 3):
            compat.write_attribute(mesh, maps_shader.MASKS.format(pack), "FLOAT_VECTOR", "POINT",
                                   packs[:, 3 * pack:3 * pack + 3])
        obj = bpy.data.objects.new("Quad", mesh)
        bpy.context.scene.collection.objects.link(obj)
        mesh.materials.append(material("Skin", image("Neutral", self.neutral)))
        self.group = maps_shader.new_group("Quad")
        images = [image(f"Wrinkles {k}", texels) for k, texels in enumerate(self.wrinkles)]
        maps_shader.fill(self.group, images, self.maps, "UVMap")
        maps_shader.insert(mesh.materials[0], self.group)
        return obj

    def masks(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(poses, n) at places on the quad."""
        return self.slopes[:, :1] * u + self.slopes[:, 1:2] * v + self.slopes[:, 2:] / len(self.wrinkles)

    def expected(self) -> np.ndarray:
        """(SIDE, SIDE, 3) encoded normals by the native module, from the eight bits."""
        place = (np.arange(SIDE, dtype=np.float32) + 0.5) / SIDE
        v, u = (grid.ravel() for grid in np.meshgrid(place, place, indexing="ij"))
        decoded = [(2 * (texels / np.float32(255)) - 1).astype(np.float32).reshape(-1, 3)
                   for texels in (self.neutral, *self.wrinkles)]
        masks = [np.ascontiguousarray(mask) for mask in self.masks(u, v).astype(np.float32)]
        blended = native.load().blend_wrinkle_maps(decoded[0], decoded[1:], masks, self.maps)
        return (0.5 * blended + 0.5).reshape(SIDE, SIDE, 3)

    def rendered(self, engine: str) -> np.ndarray:
        """(SIDE, SIDE, 3) encoded world normals that the Normal Map node hands to the shader: the quad lies flat."""
        tree = self.obj.data.materials[0].node_tree
        for node in [*tree.nodes, *self.group.nodes]:
            if node.type == "TEX_IMAGE":
                node.interpolation = "Closest"  # EEVEE's linear filter reads between texels and mip maps
        emit_normals(tree)
        return self.picture(engine)

    def picture(self, engine: str) -> np.ndarray:
        scene = bpy.context.scene
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        camera.location, camera.data.type, camera.data.ortho_scale = (0.5, 0.5, 1.0), "ORTHO", 1.0
        scene.collection.objects.link(camera)
        scene.camera, render = camera, scene.render
        render.engine = small_renders.eevee() if engine == "EEVEE" else engine
        render.resolution_x = render.resolution_y = SIDE
        render.resolution_percentage, render.film_transparent = 100, False
        scene.view_settings.view_transform = "Raw"
        scene.cycles.samples, scene.cycles.use_denoising = 1, False
        scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
        render.filter_size = 0.0
        small_renders.plain_eevee(scene, 1)
        former = render.image_settings.file_format
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        with tempfile.TemporaryDirectory() as folder:
            render.filepath = os.path.join(folder, "maps.exr")
            bpy.ops.render.render(write_still=True)
            loaded = bpy.data.images.load(render.filepath)
            pixels = np.empty(SIDE * SIDE * 4, np.float32)
            loaded.pixels.foreach_get(pixels)
        bpy.data.images.remove(loaded)
        render.image_settings.file_format = former
        return pixels.reshape(SIDE, SIDE, 4)[:, :, :3]


def material(name: str, neutral: Any) -> bpy.types.Material:
    """Principled, with a Normal Map of the neutral image."""
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    tree = made.node_tree
    texture, normal_map = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
    texture.image = neutral
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(texture.outputs["Color"], normal_map.inputs["Color"])
    tree.links.new(normal_map.outputs["Normal"], shader.inputs["Normal"])
    return made


def check(case: unittest.TestCase, engine: str) -> None:
    """Every texel, for one to sixteen poses and both kinds of maps."""
    for poses, maps in ((1, "WRINKLES"), (2, "WHOLE"), (3, "WRINKLES"), (16, "WHOLE"), (16, "WRINKLES")):
        quad = Quad(poses, maps, seed=poses)
        expected, found = quad.expected(), quad.rendered(engine)
        case.assertLessEqual(np.abs(found - expected).max(), STEP, f"{engine}, {poses} poses, {maps}")
        case.assertGreater(np.abs(expected - quad.neutral / 255.0).max(), 30 * STEP)
