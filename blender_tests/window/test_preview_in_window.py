# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview: what is drawn, where it is not drawn, and what it leaves behind."""
from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Iterator

import bpy
import gpu
import numpy as np
from mathutils import Matrix
from rumple.blender.objects import modifier, runtimes
from rumple.blender.ui import panels
from rumple.blender.viewport import gpu_arrays, preview, preview_field
from rumple.core.systems.wrinkle_field import PHASE, U_GRADIENT, V_GRADIENT, VECTORS, WEIGHT
from support import gpu_waves, sleeve, small_renders
from support.preview_case import PreviewCase, showing_normals, smooth

SIDE = 400  # pixels of the drawings into a buffer


class Drawn(PreviewCase):

    def test_waves_show_and_the_switch_takes_them_away(self) -> Iterator[float]:
        yield from self.make(gpu_preview=False)
        yield from self.shot()
        plain = self.seen
        self.assertEqual(len(preview._on_gpu), 0)
        self.obj.rumple.field.gpu_preview = True
        yield from self.shot()
        waving = self.seen
        self.screenshot("gpu_preview")
        self.assertEqual(self.obj.rumple.message, "")
        # Light and dark side by side at the bend, and nothing new elsewhere.
        changed = np.abs(waving - plain) > 15.0
        self.assertGreater(changed.sum(), 1000)
        detail = [np.abs(picture - smooth(picture))[changed].mean() for picture in (waving, plain)]
        self.assertGreater(detail[0], 2.0 * detail[1])
        sleeve_pixels = np.abs(plain - plain[5, 5]) > 8.0
        self.assertLess(changed.sum(), 0.5 * sleeve_pixels.sum())
        self.obj.rumple.field.gpu_preview = False
        yield from self.shot()
        np.testing.assert_array_equal(self.seen, plain)
        self.assertEqual(len(preview._on_gpu), 0)

    def test_without_waves_it_looks_like_the_viewport(self) -> Iterator[float]:
        """Whatever the light: studio, turned with the world, flat; whatever the colour."""
        yield from self.make(strength=0.0)
        shading = self.area.spaces.active.shading
        slot = self.obj.data.materials[0]
        slot.diffuse_color, slot.metallic, slot.roughness = (0.7, 0.3, 0.2, 1.0), 0.0, 0.3
        self.obj.color = (0.2, 0.5, 0.8, 1.0)
        for settings in (dict(), dict(show_specular_highlight=False),
                         dict(use_world_space_lighting=True, studiolight_rotate_z=1.0), dict(color_type="OBJECT"),
                         dict(light="FLAT", color_type="SINGLE", single_color=(0.8, 0.4, 0.1))):
            for name, value in settings.items():
                setattr(shading, name, value)
            pictures = []
            for on in (False, True):
                self.obj.rumple.field.gpu_preview = on
                yield from self.shot()
                pictures.append(self.seen)
            self.assertEqual(len(preview._on_gpu), 1)
            sleeve_pixels = np.abs(pictures[0] - pictures[0][5, 5]) > 8.0
            self.assertGreater(sleeve_pixels.sum(), 20000)
            difference = np.abs(pictures[1] - pictures[0])[sleeve_pixels]
            self.assertGreater((difference > 0.0).sum(), 100, settings)  # it was drawn: rounding differs
            self.assertLess(np.median(difference), 4.0, settings)
            self.assertLess((difference > 20.0).mean(), 0.05, settings)  # silhouettes are not smoothed

    def test_it_follows_the_frames_by_itself(self) -> Iterator[float]:
        """From one frame to the next the GPU goes on alone, and stays with what renders will show."""
        yield from self.make()
        sleeve.at(1)
        yield 0.2
        begun: list[int] = []
        self.watch(preview_field.GpuField, "begin", begun)
        for frame in range(2, sleeve.LAST + 1):
            yield from self.drawn_at(frame)
            expected = runtimes.of(self.obj).evaluator.state_of(float(frame)).phase
            off = (gpu_waves.phases(self.held().drawing.waves) - expected + math.pi) % (2.0 * math.pi) - math.pi
            # Where nothing is compressed k is of no direction, and rounding chooses it.
            wrinkles = gpu_waves.estimated(self.held().drawing.waves)[1][:, 2] > 0.05
            np.testing.assert_allclose(off[wrinkles], 0.0, atol=1e-3, err_msg=str(frame))
            drawn = gpu_waves.drawn(self.held().drawing.waves)[:, 3]
            shown = self.in_renders().attributes["rumple_amplitude"]
            np.testing.assert_allclose(drawn[wrinkles], shown[wrinkles], atol=2e-3 * shown.max(), err_msg=str(frame))
        self.assertGreater(wrinkles.sum(), 20)
        self.assertEqual(begun, [])
        yield from self.drawn_at(5)
        self.assertEqual(len(begun), 1)

    def test_it_follows_a_rest_shape_that_adapts(self) -> Iterator[float]:
        """The GPU crushes by itself: it must measure against the reference of the frame, not the rest pose."""
        yield from self.make()
        self.obj.rumple.field.rest_shape, self.obj.rumple.field.reference = "ADAPTIVE", "FIRST_FRAME"
        bpy.context.scene.frame_start = self.obj.rumple.bake_start = 10  # bent already
        yield from self.until(lambda: runtimes.of(self.obj).inputs is not None
                              and runtimes.of(self.obj).inputs.settings.adapts)
        for frame in (10, 11, 12, 18):
            yield from self.drawn_at(frame)
            self.assertFalse(self.held().refusal)  # drawn while it was made anew
            fullness = self.engines_fullness(1e-5)
            self.assertLess(fullness.max() if frame == 10 else 0.0, 1e-2)  # the first frame is unwrinkled

    def test_on_a_base_cloth_no_waves_run_along_lines_that_bend(self) -> Iterator[float]:
        """Its passes know no such lines: the preview drew waves, twice as high in all, that no render had."""
        yield from self.make(base_cloth="HANG")
        yield from self.drawn_at(sleeve.LAST - 1)
        self.assertGreater(self.engines_fullness(1e-4).max(), 0.1)

    def test_a_standing_frame_costs_no_pass(self) -> Iterator[float]:
        yield from self.make()
        yield from self.shot()
        passes: list[int] = []
        self.watch(gpu_arrays.Pass, "run", passes)
        yield from self.shot()
        self.assertEqual(passes, [])
        self.obj.rumple.field.strength = 0.5
        yield from self.shot()
        self.assertGreater(len(passes), 0)

    def test_bones_and_outlines_stay_over_the_waves(self) -> Iterator[float]:
        """What Blender blends over a picture depends on the picture by no more than the pictures differ."""
        yield from self.make()
        boxes, seen, read = [], {}, gpu_arrays.overlays
        self.addCleanup(setattr, gpu_arrays, "overlays", read)
        gpu_arrays.overlays = lambda box: boxes.append(box) or read(box)
        for waves in (False, True):
            self.obj.rumple.field.gpu_preview = waves
            for overlays in (False, True):
                self.show_overlays(overlays)
                yield from self.shot()
                seen[waves, overlays] = self.seen
            self.screenshot(f"overlays_{'over_waves' if waves else 'plain'}")
        below = np.abs(seen[True, False] - seen[False, False])
        drawn = np.abs(seen[False, True] - seen[False, False])
        above = np.abs(seen[True, True] - seen[False, True])
        self.assertGreater(((drawn > 30.0) & (below > 15.0)).sum(), 50)  # bones before waves
        self.assertGreater((drawn > 30.0).sum(), 1000)
        self.assertLess((above - below).max(), 4.0)
        self.assertLess(np.median(above[drawn > 30.0]), 1.0)
        left, bottom, width, height = boxes[-1]
        top = len(below) + 10 - bottom  # seen is the viewport without some pixels: see shot()
        drawn_at = below[top - height:top, left - 60:left - 60 + width]
        self.assertEqual(((drawn_at > 0).sum(), drawn_at.size < 0.8 * below.size), ((below > 0).sum(), True))


class Exact(PreviewCase):
    """The render stage, pixel by pixel, against the attributes that renders read."""

    def sheet(self, **settings: object) -> Iterator[float]:
        """A flat uneven sheet of a metre, smooth, with a shape key that squeezes and bends it. Seen from above."""
        sleeve.empty_file()
        count = 9
        random = np.random.default_rng(2)
        line = np.linspace(0.0, 1.0, count)
        rest = np.array([(x, y, 0.0) for y in line for x in line])
        inner = (np.abs(rest[:, :2] - 0.5) < 0.49).all(1)
        rest[inner, :2] += random.uniform(-0.25, 0.25, (inner.sum(), 2)) / (count - 1)
        first = [j * count + i for j in range(count - 1) for i in range(count - 1)]
        mesh = bpy.data.meshes.new("Sheet")
        mesh.from_pydata(rest.tolist(), [], [(a, a + 1, a + count + 1, a + count) for a in first])
        uv = rest[[loop.vertex_index for loop in mesh.loops], :2]
        mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", np.ascontiguousarray(uv, np.float32).ravel())
        self.obj = bpy.data.objects.new("Sheet", mesh)
        bpy.context.scene.collection.objects.link(self.obj)
        self.obj.shape_key_add(name="Basis")
        squeezed = self.obj.shape_key_add(name="Squeezed")
        pose = rest * (0.75, 1.0, 1.0) + np.stack((0 * rest[:, 0], 0 * rest[:, 0], 0.1 * np.sin(3.0 * rest[:, 1])), 1)
        squeezed.data.foreach_set("co", np.ascontiguousarray(pose, np.float32).ravel())
        squeezed.value = 1.0
        for name, value in {"gpu_preview": True, "wavelength": 0.3, **settings}.items():
            setattr(self.obj.rumple.field, name, value)
        with sleeve.context():
            sleeve.make_active(self.obj)
            bpy.ops.object.rumple_add(method="FIELD")
        self.obj.rumple.field.wavelength = settings.get("wavelength", 0.3)
        sleeve.at(2)
        yield from self.view()
        yield 0.5
        yield from self.until(lambda: preview._on_gpu and self.held().inputs is not None)

    def drawn(self, shading: SimpleNamespace, projection: Matrix, view: Matrix) -> np.ndarray:
        """(SIDE, SIDE, 4) float32, the bottom row first; alpha 0 where nothing is."""
        buffer = gpu.types.GPUOffScreen(SIDE, SIDE, format="RGBA32F")
        with buffer.bind():
            here = gpu.state.active_framebuffer_get()
            here.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
                gpu.matrix.load_matrix(view)
                gpu.matrix.load_projection_matrix(projection)
                preview._draw_object(self.obj, self.held(), shading, gpu_arrays.no_overlays())
            pixels = here.read_color(0, 0, SIDE, SIDE, 4, 0, "FLOAT")
        gpu_arrays.plain_state()
        pixels.dimensions = SIDE * SIDE * 4
        found = np.array(pixels, np.float32).reshape(SIDE, SIDE, 4)
        buffer.free()
        return found

    def expected(self, at: np.ndarray) -> dict[str, np.ndarray]:
        """Of points (n, 2) of the sheet from above: by equations (5), (7), (8) from what the shader nodes read."""
        runtime = runtimes.of(self.obj)
        model, shown = runtime.evaluator.model, self.in_renders().attributes
        positions, normals = model.weld_pose(runtime.inputs.positions)
        out = {name: np.full((len(at), width), np.nan) for name, width in (
            ("height", 1), ("normal", 3), ("smooth", 3), ("place", 3), ("u", 3), ("v", 3))}
        for t, triangle in enumerate(model.triangles):
            a, b, c = positions[triangle, :2].astype(float)
            weights = np.linalg.solve(np.stack((b - a, c - a), 1), (at - a).T).T
            weights = np.column_stack((1.0 - weights.sum(1), weights))
            inside = (weights > 1e-3).all(1)
            weights, corners = weights[inside], slice(3 * t, 3 * t + 3)
            phase, weight = weights @ shown[PHASE][corners], weights @ shown[WEIGHT][corners]
            height, gradient = weight * np.cos(phase), -weight * np.sin(phase)  # a sine
            smooth_normal = weights @ normals[triangle]
            smooth_normal /= np.linalg.norm(smooth_normal, axis=1, keepdims=True)
            wrinkled = smooth_normal - sum(gradient[:, i:i + 1] * shown[VECTORS[i]][3 * t] for i in range(3))
            out["height"][inside, 0] = height.sum(1)
            out["normal"][inside] = wrinkled / np.linalg.norm(wrinkled, axis=1, keepdims=True)
            out["smooth"][inside] = smooth_normal
            out["place"][inside] = weights @ positions[triangle]
            for name, attribute in (("u", U_GRADIENT), ("v", V_GRADIENT)):
                out[name][inside] = weights @ shown[attribute][corners]
        return out

    def test_normals_are_equations_7_and_8(self) -> Iterator[float]:
        yield from self.sheet()
        found = self.drawn(showing_normals(), orthographic(), Matrix.Translation((-0.5, -0.5, 0.0)))
        place = from_above()
        right = self.expected(place)["normal"]
        seen = ~np.isnan(right[:, 0]) & (found.reshape(-1, 4)[:, 3] > 0.5)
        self.assertGreater(seen.sum(), 0.5 * SIDE * SIDE)
        colors = found.reshape(-1, 4)[seen, :3]
        scale = np.float32(4.0).view(np.int32)  # the reciprocal of 4 as studio_light.glsl has it
        normals = colors / np.int32(0x7EEF370B - scale).view(np.float32) - 1.0
        self.assertLess(right[seen, 2].min(), 0.9)  # there are waves
        self.assertLess(np.abs(normals - right[seen]).max(), 2e-3)

    def test_parallax_is_equations_10_and_11(self) -> Iterator[float]:
        """An image whose colour is the place in it: the picture says which place was taken."""
        yield from self.sheet()
        self.obj.data.materials[0] = image_of_itself()
        runtimes.of(self.obj).invalidate_output()
        sleeve.at(3)
        yield from self.until_drawn(3.0)
        shading = SimpleNamespace(light="FLAT", color_type="TEXTURE", show_backface_culling=False,
                                  show_specular_highlight=False)
        view = Matrix.Rotation(-0.5, 4, "X") @ Matrix.Translation((-0.5, -0.5, 0.0))
        found = self.drawn(shading, orthographic(), view).reshape(-1, 4)
        # Looked at aslant: where each place of the sheet comes to lie.
        place = from_above()[::7]
        right = self.expected(place)
        known = ~np.isnan(right["height"][:, 0])
        right = {name: values[known] for name, values in right.items()}
        in_view = right["place"] @ np.array(view.to_3x3()).T + np.array(view.translation)
        pixel = np.floor((in_view[:, :2] / 0.6 + 1.0) * SIDE / 2.0).astype(int)
        towards = np.array(view.to_3x3().inverted() @ Matrix.Identity(3).col[2])
        facing = right["smooth"] @ towards
        shift = right["height"] * (towards - facing[:, None] * right["smooth"]) * (facing / (facing**2 + 0.1))[:, None]
        own = right["place"][:, :2] / (0.75, 1.0)
        moved = np.stack([(right[name] * shift).sum(1) for name in "uv"], 1)
        self.assertGreater(np.abs(moved).max(), 0.02)
        color = found[pixel[:, 1] * SIDE + pixel[:, 0]]
        drawn = (color[:, 3] > 0.5) & (np.abs(own + moved - 0.5) < 0.49).all(1)  # the image repeats beyond its border
        self.assertGreater(drawn.mean(), 0.8)
        off = np.abs(color[drawn, :2] - (own + moved)[drawn])
        # A pixel is 0.003 of the sheet, a texel 0.004.
        self.assertLess(np.percentile(off, 99), 0.01)
        self.assertLess(off.mean(), 0.25 * np.abs(moved).mean())


def orthographic() -> Matrix:
    """A square of 1.2 by 1.2 around the axis of view, 10 deep."""
    return Matrix.Diagonal((1.0 / 0.6, 1.0 / 0.6, -0.1, 1.0))


def from_above() -> np.ndarray:
    """Where the centres of the pixels of a drawing lie on the sheet, (SIDE * SIDE, 2)."""
    line = (np.arange(SIDE) + 0.5) / SIDE * 1.2 - 0.6 + 0.5
    x, y = np.meshgrid(line, line)
    return np.stack((x.ravel(), y.ravel()), 1)


def image_of_itself() -> bpy.types.Material:
    """A material with an image of floats: red is u, green is v."""
    image = bpy.data.images.new("Places", 256, 256, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    u, v = np.meshgrid(*[(np.arange(256, dtype=np.float32) + 0.5) / 256] * 2)
    image.pixels.foreach_set(np.stack((u, v, 0 * u, 0 * u + 1), 2).astype(np.float32).ravel())
    image.update()
    material = bpy.data.materials.new("Places")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    material.node_tree.nodes.active = node
    return material


class Manners(PreviewCase):

    def test_a_refusal_is_said_once_and_leaves_blenders_picture(self) -> Iterator[float]:
        yield from self.make(gpu_preview=False)
        yield from self.shot()
        plain = self.seen
        tried = self.refuse(preview_field)
        self.obj.rumple.field.gpu_preview = True
        yield from self.shot()
        yield from self.shot()
        np.testing.assert_array_equal(self.seen, plain)
        self.assertEqual((len(tried), panels.status_lines(self.obj)[-1]), (1, (preview.REFUSED, "INFO")))

    def test_never_in_a_render(self) -> Iterator[float]:
        obj = small_renders.stage("BLENDER_WORKBENCH")
        with sleeve.context():
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method="FIELD")
        yield from self.view()
        pictures = []
        for on in (False, True):
            obj.rumple.field.gpu_preview = on
            yield 0.5
            pictures.append(small_renders.still(sleeve.LAST))
        self.assertEqual(len(preview._on_gpu), 1)
        np.testing.assert_array_equal(*pictures)

    def test_edit_mode_material_preview_and_a_closed_eye_show_blenders_own(self) -> Iterator[float]:
        yield from self.make()
        yield from self.shot()
        waving = self.seen
        modifier.find(self.obj).show_viewport = False
        yield from self.shot()
        self.assertEqual(len(preview._on_gpu), 0)
        modifier.find(self.obj).show_viewport = True
        yield from self.shot()
        np.testing.assert_array_equal(self.seen, waving)
        self.obj.hide_set(True)
        yield from self.shot()
        self.assertLess(self.seen.max(), 0.6 * waving.max())  # nothing but the background
        self.obj.hide_set(False)
        with self.area_of_view():
            bpy.ops.object.mode_set(mode="EDIT")
        yield from self.shot()
        self.assertEqual(len(preview._on_gpu), 0)
        with self.area_of_view():
            bpy.ops.object.mode_set(mode="OBJECT")

    def test_undo_deletion_and_another_file_leave_nothing(self) -> Iterator[float]:
        yield from self.make()
        with self.area_of_view():
            bpy.ops.ed.undo_push(message="before")
            self.obj.rumple.field.strength = 0.5
            bpy.ops.ed.undo_push(message="weaker")
        yield from self.shot()
        with self.area_of_view():
            bpy.ops.ed.undo()
        yield 0.5
        yield from self.shot()
        self.assertEqual(len(preview._on_gpu), 1)
        self.assertEqual(self.held().inputs.settings.strength, 1.0)
        bpy.data.objects.remove(bpy.data.objects["Sleeve"])
        yield from self.shot()
        self.assertEqual(len(preview._on_gpu), 0)
        yield from self.make()
        yield from self.shot()
        self.assertEqual(len(preview._on_gpu), 1)
        sleeve.empty_file()
        self.assertEqual(len(preview._on_gpu), 0)
        self.assertEqual(gpu_arrays._kept, {})

    def test_unregister_and_register(self) -> Iterator[float]:
        yield from self.make()
        yield from self.shot()
        waving = self.seen
        preview.unregister()
        self.assertEqual(gpu_arrays._kept, {})
        yield from self.shot()
        self.assertGreater(np.abs(self.seen - waving).max(), 30.0)
        preview.register()
        yield from self.shot()
        np.testing.assert_array_equal(self.seen, waving)
