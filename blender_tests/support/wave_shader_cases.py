# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group Rumple Field draws what the kernel computes, in each engine: the same tests in -b and in a window.

An irregular flat sheet, squeezed in x by a shape key, with waves that hardly agree: then the three plane waves of
every triangle differ, and a shader that mixes them up is seen.
"""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple import native
from rumple.blender.nodes import field_shader
from rumple.blender.objects import runtimes
from support import sleeve, small_renders

CELLS, SIZE, PIXELS, SQUEEZE, TILT = 8, 1.0, 96, 0.7, 0.5
WAVELENGTH = 0.25
HEIGHT = 0.25 * WAVELENGTH * (1.0 - SQUEEZE**2)**0.5


def sheet() -> bpy.types.Object:
    """Quads whose inner points are shaken; UV is the rest position."""
    sleeve.empty_file()
    random = np.random.RandomState(3)
    grid = [(i, j) for j in range(CELLS + 1) for i in range(CELLS + 1)]
    shaken = [(i + random.uniform(-0.3, 0.3) * (0 < i < CELLS), j + random.uniform(-0.3, 0.3) * (0 < j < CELLS), 0.0)
              for i, j in grid]
    quads = [(v, v + 1, v + CELLS + 2, v + CELLS + 1) for v, (i, j) in enumerate(grid) if i < CELLS and j < CELLS]
    mesh = bpy.data.meshes.new("Sheet")
    mesh.from_pydata((np.array(shaken) * SIZE / CELLS).tolist(), [], quads)
    uv = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops], np.float32)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.ascontiguousarray(uv).ravel())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(quads), bool))
    obj = bpy.data.objects.new("Sheet", mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.shape_key_add(name="Basis")
    squeezed = obj.shape_key_add(name="Squeezed")
    for point in squeezed.data:
        point.co.x *= SQUEEZE
    squeezed.value = 1.0
    return obj


class Waves:
    """Height, normal and parallax of each pixel against the kernel's equations (5), (8), (10) and (11)."""

    def stage(self, engine: str, profile: str = "SINE") -> None:
        if engine != "CYCLES" and not small_renders.can_draw():
            raise unittest.SkipTest(f"{engine} needs a screen in this Blender: the window suite does it")
        self.obj = sheet()
        with sleeve.context():
            sleeve.make_active(self.obj)
            settings = self.obj.rumple.field
            settings.wavelength, settings.start, settings.start_rounds = WAVELENGTH, "RANDOM", 3
            settings.profile = profile
            self.assertEqual(bpy.ops.object.rumple_add(method="FIELD"), {"FINISHED"})
            bpy.context.scene.frame_set(1)
            self.look_from_above(engine)
        self.assertEqual(self.obj.rumple.message, "")

    def look_from_above(self, engine: str) -> None:
        scene = bpy.context.scene
        self.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1.1
        scene.collection.objects.link(self.camera)
        scene.camera = self.camera
        self.lean(0.0)
        render = scene.render
        render.engine = small_renders.eevee() if engine == "EEVEE" else engine
        render.resolution_x = render.resolution_y = PIXELS
        render.resolution_percentage, render.filter_size, render.film_transparent = 100, 0.0, True
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        if engine == "CYCLES":
            scene.cycles.samples, scene.cycles.use_denoising = 1, False
            scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
        if engine == "EEVEE":
            small_renders.plain_eevee(scene, 1)

    def lean(self, angle: float) -> None:
        """Look at the middle of the squeezed sheet, turned about the x axis."""
        middle = np.array([0.5 * SQUEEZE * SIZE, 0.5 * SIZE, 0.0])
        self.camera.rotation_euler = (angle, 0.0, 0.0)
        self.camera.location = middle + 3.0 * np.array([0.0, -np.sin(angle), np.cos(angle)])
        self.angle = angle

    def emit(self, output: str, scale: float, shift: float) -> None:
        """Let the sheet shine with an output of the group, times scale plus shift."""
        tree = self.obj.active_material.node_tree
        field = next(n for n in tree.nodes if n.type == "GROUP" and field_shader.is_ours(n.node_tree))
        add, emission = tree.nodes.new("ShaderNodeVectorMath"), tree.nodes.new("ShaderNodeEmission")
        add.operation = "MULTIPLY_ADD"
        add.inputs[1].default_value, add.inputs[2].default_value = (scale,) * 3, (shift,) * 3
        surface = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"]
        tree.links.new(field.outputs[output], add.inputs[0])
        tree.links.new(add.outputs[0], emission.inputs["Color"])
        tree.links.new(emission.outputs[0], surface)

    def render(self, output: str, scale: float = 1.0, shift: float = 0.0) -> np.ndarray:
        """An output of the group at every pixel inside the sheet, (p, 3)."""
        self.emit(output, scale, shift)
        with tempfile.TemporaryDirectory() as folder, sleeve.context():
            bpy.context.scene.render.filepath = os.path.join(folder, "still.exr")
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(bpy.context.scene.render.filepath)
            pixels = np.empty(PIXELS * PIXELS * 4, np.float32)
            image.pixels.foreach_get(pixels)
            bpy.data.images.remove(image)
        pixels = pixels.reshape(PIXELS, PIXELS, 4)[..., :3]
        return (pixels[self.where()] - shift) / scale

    def where(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the pixels well inside the sheet; their points on it become self.points."""
        step = self.camera.data.ortho_scale / PIXELS
        across = (np.arange(PIXELS) + 0.5) * step - 0.5 * self.camera.data.ortho_scale
        x, y = np.meshgrid(across + 0.5 * SQUEEZE * SIZE, across / np.cos(self.angle) + 0.5 * SIZE)
        inside = (0.02 < x) & (x < SQUEEZE * SIZE - 0.02) & (0.02 < y) & (y < SIZE - 0.02)
        self.points = np.stack([x[inside], y[inside]], 1)
        return np.nonzero(inside)

    def computed(self, profile: str = "SINE") -> tuple[np.ndarray, np.ndarray]:
        """Height and gradient at self.points, from the kernel."""
        runtime = runtimes.of(self.obj)
        fine, kernels = runtime.evaluator, native.load()
        state = fine.frame_cache.get(1.0).state
        waves = kernels.shown_waves_wrinkle_field(
            fine.model, fine._native_settings(runtime.inputs.settings), kernels.WrinkleFieldProfile(profile),
            fine._paint, runtime.inputs.positions, state)
        triangles = runtime.inputs.positions[fine.corner_vertex.reshape(-1, 3), :2].astype(float)
        origin, b, c = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        way = self.points[:, None] - origin
        area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
        weights = np.stack([way[..., 0] * c[:, 1] - way[..., 1] * c[:, 0],
                            b[:, 0] * way[..., 1] - b[:, 1] * way[..., 0]], 2) / area[:, None]
        which = np.minimum(weights.min(2), 1.0 - weights.sum(2)).argmax(1)
        return kernels.evaluate_wrinkle_field(
            fine.model, waves, kernels.WrinkleFieldProfile(profile), state.phase, which.astype(np.int32),
            weights[np.arange(len(which)), which].astype(np.float32))

    def near(self, found: np.ndarray, right: np.ndarray, scale: float) -> None:
        """A few pixels lie on crests, where a curve's table and a kink differ most."""
        error = np.abs(found - right).reshape(len(right), -1).max(1) / scale
        self.assertGreater(len(error), 1000)
        self.assertLess(np.median(error), 2e-3)
        self.assertLess(np.percentile(error, 99), 2e-2)

    def check(self, engine: str) -> None:
        self.stage(engine)
        found = self.render("Height", 4.0, 0.5)[:, 0]
        height, gradient = self.computed()
        self.assertGreater(height.max(), 0.5 * HEIGHT)
        self.assertLess(height.min(), -0.5 * HEIGHT)
        self.near(found, height, HEIGHT)
        normal = np.array([0.0, 0.0, 1.0]) - gradient
        self.near(self.render("Normal", 0.4, 0.5), normal / np.sqrt((normal**2).sum(1, keepdims=True)), 1.0)
        self.lean(TILT)
        found = self.render("UV", 0.5, 0.25)[:, :2]
        height, _ = self.computed()
        viewer = np.array([0.0, -np.sin(TILT), np.cos(TILT)])
        shift = viewer[:2] * viewer[2] / (viewer[2]**2 + 0.1) * height[:, None]  # equation (10), n' = z
        self.assertGreater(np.abs(shift).max(), 0.01)
        self.near(found, (self.points + shift) / (SQUEEZE, 1.0), SIZE)  # (11): u grows as the sheet is squeezed

    def test_cycles(self) -> None:
        self.check("CYCLES")

    def test_eevee(self) -> None:
        self.check("EEVEE")

    def test_every_profile_in_cycles(self) -> None:
        for profile in ("ACCORDION", "PENCIL_PLEATS"):
            self.stage("CYCLES", profile)
            found = self.render("Height", 4.0, 0.5)[:, 0]
            self.near(found, self.computed(profile)[0], HEIGHT)
