# SPDX-License-Identifier: GPL-3.0-or-later
"""The masks that are rendered are those of the frame that is rendered: never one late, and right under motion blur."""
from __future__ import annotations

import os
import tempfile
import unittest
from typing import Any

import bpy
import numpy as np
from mathutils import Euler
from rumple.blender.maps import modifier as maps_modifier
from rumple.blender.nodes import maps_mask_tree
from support import face

SIZE = 104  # pixels over the face: the brightest lies within a millimetre of the middle of the brow


def show_mask(obj: bpy.types.Object, name: str) -> None:
    """The material emits the mask of a pose."""
    tree = obj.data.materials[0].node_tree
    tree.nodes.clear()
    attribute, emission, output = (tree.nodes.new(kind) for kind in (
        "ShaderNodeAttribute", "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    attribute.attribute_name = maps_mask_tree.MASK.format(name)
    tree.links.new(attribute.outputs["Fac"], emission.inputs["Strength"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])


class Renders(unittest.TestCase):

    def setUp(self) -> None:
        self.obj, self.rig = face.scene()
        face.pose(self.rig, brow_L=0.01, brow_R=0.01)
        bpy.ops.rumple.pose_add(name="Surprise")
        face.animate(self.rig)
        show_mask(self.obj, "Surprise")
        scene = bpy.context.scene
        camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        camera.data.type, camera.data.ortho_scale = "ORTHO", 0.12
        camera.location, camera.rotation_euler = (0.0, -1.0, 0.0), Euler((np.pi / 2, 0.0, 0.0))
        scene.collection.objects.link(camera)
        scene.camera = camera
        scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16, False
        scene.render.resolution_x = scene.render.resolution_y = SIZE
        scene.render.resolution_percentage = 100
        scene.view_settings.view_transform = "Raw"
        scene.render.image_settings.file_format = "OPEN_EXR"

    def rendered(self, **how: object) -> np.ndarray:
        """The brightest pixel of every picture that a render writes, in the order of their names."""
        return np.array([pixels.max() for pixels in self.pictures(**how)])

    def pixels(self) -> np.ndarray:
        """(SIZE, SIZE) of a still."""
        return self.pictures(write_still=True)[0]

    def pictures(self, **how: object) -> list[np.ndarray]:
        with tempfile.TemporaryDirectory() as folder:
            bpy.context.scene.render.filepath = os.path.join(folder, "f")
            bpy.ops.render.render(**how)
            found = []
            for name in sorted(os.listdir(folder)):
                image = bpy.data.images.load(os.path.join(folder, name))
                found.append(np.array(image.pixels[:]).reshape(SIZE, SIZE, 4)[:, :, 0])
                bpy.data.images.remove(image)
        return found

    def check(self, found: Any, frames: Any) -> None:
        """The mask rises linearly: 0 at frame 1, full at frame 11."""
        full = face.weights(self.obj, "brow.L").max()
        np.testing.assert_allclose(found, full * face.risen(np.array(frames)), atol=0.04)

    def test_an_animation(self) -> None:
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 2, 7
        self.check(self.rendered(animation=True), range(2, 8))

    def test_stills_in_any_order(self) -> None:
        for frame in (9, 2, 6):
            bpy.context.scene.frame_set(frame)
            self.check(self.rendered(write_still=True), [frame])

    def test_switched_off_in_the_viewport_it_renders(self) -> None:
        maps_modifier.find(self.obj).show_viewport = False
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 6, 8
        self.check(self.rendered(animation=True), range(6, 9))

    def test_motion_blur_leaves_the_mask_of_the_frame(self) -> None:
        bpy.context.scene.render.use_motion_blur = True
        bpy.context.scene.frame_set(6)
        self.check(self.rendered(write_still=True), [6])
