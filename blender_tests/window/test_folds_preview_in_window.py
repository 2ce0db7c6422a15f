# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview of the Wrinkle Paths: its numbers against C++, its pictures against the fine mesh, its manners."""
from __future__ import annotations

import tempfile
from pathlib import Path
from types import SimpleNamespace
from typing import Iterator

import bpy
import gpu
import numpy as np
import shots
import sleeve
from case import WindowCase
from mathutils import Matrix
from preview_case import PreviewCase, smooth
from rumple import native
from rumple.blender import gpu_arrays, gpu_paths, handlers, modifier, preview, registry, shaders
from rumple.core import engine
from rumple.core.settings import PathsSettings
from rumple.core.wrinkle_paths import WrinklePaths

SIDE = 400  # pixels of the drawings into a buffer
WIDTH = 0.08  # of the folds of the sheet, which is a metre wide

PROBE = """
void main() {
    int i = THIS_TEXEL(lists);
    vec4 place = TEXEL(places, i);
    vec3 n = TEXEL(normals, i).xyz;
    FoldBlend blend = folds_at(ivec2(TEXEL(lists, i).xy), place.xyz, n, place.w);
    out_fold = vec4(blended_normal(blend, n), blend.height);
}
"""


class Sheet:
    """A curved uneven sheet that is squeezed, with its folds, without Blender."""

    def __init__(self, attachment: str = "LIMIT", flat: bool = False, count: int = 11, **settings: object) -> None:
        random = np.random.default_rng(2)
        line = np.linspace(0.0, 1.0, count)
        rest = np.array([(x, y, 0.0) for y in line for x in line])
        inner = (np.abs(rest[:, :2] - 0.5) < 0.49).all(1)
        rest[inner, :2] += random.uniform(-0.25, 0.25, (inner.sum(), 2)) / (count - 1)
        first = np.array([j * count + i for j in range(count - 1) for i in range(count - 1)], np.int32)
        quads = np.stack((first, first + 1, first + count + 1, first + count), 1)
        corner = 4 * np.arange(len(quads), dtype=np.int32)[:, None]
        triangles = np.concatenate((corner + (0, 1, 2), corner + (0, 2, 3)), 1).reshape(-1, 3).astype(np.int32)
        self.base = engine.BaseMesh("Sheet", rest.astype(np.float32), np.arange(0, quads.size + 1, 4, dtype=np.int32),
                                    quads.ravel(), triangles)
        self.settings = PathsSettings(width=WIDTH, attachment=attachment, hem_rings=1, **settings)
        self.fine = WrinklePaths.build(self.base, self.settings)
        bulge = 0.0 if flat else 0.08
        self.pose = np.column_stack((0.7 * rest[:, 0], rest[:, 1], bulge * np.sin(5.0 * rest[:, 0] + 3.0 * rest[:, 1])))
        self.pose = self.pose.astype(np.float32)
        for frame in range(1, 16):  # folds rise in some frames
            share = min(frame / 6.0, 1.0)
            pose = ((1.0 - share) * rest + share * self.pose).astype(np.float32)
            self.sketch = self.fine.solve_frame(float(frame), pose, self.settings, {}, start=1, sketched=True)
        self.drawing = self.sketch.drawing
        self.native_settings = self.fine._native_settings(self.settings)

    def points(self, count: int, inside: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """(triangle, weights of corners 1 and 2): random ones, edges and corners among them unless inside."""
        random = np.random.default_rng(5)
        triangle = random.integers(0, len(self.fine.model.triangle_vertex), count).astype(np.int32)
        weights = random.dirichlet((1.0, 1.0, 1.0), count)
        if not inside:
            weights[::5] = np.eye(3)[random.integers(0, 3, len(weights[::5]))]
            weights[1::5, 0] = 0.0
            weights /= weights.sum(1, keepdims=True)
        return triangle, np.ascontiguousarray(weights[:, 1:], np.float32)

    def twin(self, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """(n, 7) position, height and normal by C++."""
        return native.load().drawn_wrinkle_paths(self.fine.model, self.native_settings, self.drawing, triangle, weights)

    def mixed(self, values: np.ndarray, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Values of welded vertices at places."""
        corners = values[self.fine.model.triangle_vertex[triangle]]
        all_weights = np.column_stack((1.0 - weights.sum(1), weights)).astype(np.float32)
        return sum(corners[:, k] * all_weights[:, k].reshape(-1, *[1] * (corners.ndim - 2)) for k in range(3))


class Formulas(WindowCase):

    def test_heights_and_normals_are_those_of_cpp(self) -> None:
        for profile in gpu_paths.PROFILES:
            for direction in ("OUTWARD", "BOTH"):
                sheet = Sheet(profile=profile, direction=direction)
                triangle, weights = sheet.points(4000)
                expected = sheet.twin(triangle, weights)
                lists = sheet.drawing.lists
                normal = sheet.mixed(sheet.drawing.normal, triangle, weights)
                normal /= np.sqrt((normal * normal).sum(1, keepdims=True))
                place = np.column_stack((sheet.mixed(sheet.drawing.flat, triangle, weights),
                                         sheet.mixed(sheet.drawing.hem, triangle, weights)))
                start = lists.triangle_start
                inputs = dict(lists=np.column_stack((start[triangle], start[triangle + 1])), places=place,
                              normals=normal, ranges=lists.ranges, ends=lists.ends.reshape(-1, 4))
                probe = gpu_arrays.Pass(
                    shaders.source(*shaders.FOLDS, "preview/texels", "preview/folds") + PROBE, tuple(inputs),
                    ("out_fold",), (("INT", "profile"),))
                target = gpu_arrays.Target(len(triangle))
                gpu_arrays.plain_state()
                probe.run(target, {name: gpu_arrays.upload(values) for name, values in inputs.items()},
                          profile=gpu_paths.PROFILES.index(profile))
                found = target.read()
                self.assertGreater((np.abs(expected[:, 3]) > 0.1 * WIDTH).sum(), 400)
                self.assertEqual((expected[:, 3] < -1e-3 * WIDTH).any(), direction == "BOTH")
                np.testing.assert_allclose(found[:, 3], expected[:, 3], atol=1e-5 * WIDTH)
                # At a crest the gradient turns round within rounding of the place.
                off = np.abs(found[:, :3] - expected[:, 4:]).max(1)
                self.assertLess(np.percentile(off, 99), 1e-4)
                self.assertLess(off.mean(), 1e-4)

    def test_patterns_cover_a_triangle_once(self) -> None:
        for parts in (1, 2, 8, 32):
            points, cells = gpu_paths.spots(parts), gpu_paths.cells(parts)
            self.assertEqual((len(points), len(cells)), ((parts + 1) * (parts + 2) // 2, parts * parts))
            a, b, c = (points[cells[:, k]] for k in range(3))
            twice_area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
            np.testing.assert_array_equal(twice_area, 1)  # all as large, all the same way round: parts^2 in all
            self.assertTrue((points >= 0).all() and (points.sum(1) <= parts).all())

    def test_runs_draw_every_patch_once(self) -> None:
        for parts in (1, 8, 32):
            for count in (1, 2, 7, 600, 5000):
                drawn = [i for first, size in gpu_paths.runs(3, count, parts) for i in range(first, first + size)]
                self.assertEqual(drawn, list(range(3, 3 + count)))


class Stage(WindowCase):
    """The sheet drawn into a buffer, seen from above."""

    def drawn(self, sheet: Sheet, view: Matrix = Matrix.Translation((-0.35, -0.5, 0.0))) -> None:
        """self.color (SIDE, SIDE, 4), the bottom row first, alpha 0 where nothing is; self.depth (SIDE, SIDE)."""
        drawing = gpu_paths.Drawing(sheet.fine.model)
        mesh = SimpleNamespace(uv_layers=())
        obj = SimpleNamespace(matrix_world=Matrix(), dimensions=(1.0, 1.0, 1.0), material_slots=(), data=mesh)
        entry = SimpleNamespace(picture=sheet.sketch, fine=sheet.fine, inputs=SimpleNamespace(settings=sheet.settings))
        self.assertTrue(drawing.update(obj, entry, None, np.zeros(len(sheet.base.triangle_corner), np.int32)))
        # Three lights that wrap all round, along the axes, red, green and blue: the picture is the normal.
        lights = [SimpleNamespace(use=True, direction=axis, diffuse_color=axis, specular_color=(0, 0, 0), smooth=1.0)
                  for axis in np.eye(3).tolist()]
        shading = SimpleNamespace(light="STUDIO", color_type="SINGLE", single_color=(1.0, 1.0, 1.0),
                                  show_specular_highlight=False, show_backface_culling=False,
                                  use_world_space_lighting=False, selected_studio_light=SimpleNamespace(
                                      solid_lights=lights, light_ambient=(0.0, 0.0, 0.0)))
        buffer = gpu.types.GPUOffScreen(SIDE, SIDE, format="RGBA32F")
        with buffer.bind():
            here = gpu.state.active_framebuffer_get()
            here.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
                gpu.matrix.load_matrix(view)
                gpu.matrix.load_projection_matrix(Matrix.Diagonal((1.0 / 0.6, 1.0 / 0.6, -1.0, 1.0)))
                preview._draw_object(obj, preview._OnGpu(sheet.fine.model, drawing), shading)
            color, depth = (here.read_color(0, 0, SIDE, SIDE, 4, 0, "FLOAT"), here.read_depth(0, 0, SIDE, SIDE))
        gpu_arrays.plain_state()
        self.color, self.depth = as_array(color, 4), as_array(depth, 1)[..., 0]
        buffer.free()

    def normals(self) -> np.ndarray:
        scale = np.float32(4.0).view(np.int32)  # the reciprocal of 4 as studio_light.glsl has it
        return self.color[..., :3] / np.int32(0x7EEF370B - scale).view(np.float32) - 1.0

    def test_pixels_have_the_normal_and_the_place_of_cpp(self) -> None:
        sheet = Sheet("LINEAR", flat=True)
        triangle, weights = sheet.points(3000, inside=True)
        expected = sheet.twin(triangle, weights)
        self.drawn(sheet)
        at = (expected[:, :2] - (0.35, 0.5)) / 0.6
        pixel = np.floor((at + 1.0) * SIDE / 2.0).astype(int)
        inside = (self.color[pixel[:, 1], pixel[:, 0], 3] > 0.5)
        self.assertGreater(inside.mean(), 0.95)
        self.assertGreater((expected[:, 3] > 0.2 * WIDTH).sum(), 300)
        off = np.abs(self.normals()[pixel[:, 1], pixel[:, 0]] - expected[:, 4:])[inside]
        self.assertLess(np.median(off), 0.01)  # a pixel is 0.003 wide, 1 / 27 of a fold
        self.assertLess(np.percentile(off, 95), 0.2)
        # z is 1 - 2 depth; and a thousandth nearer than it is.
        z = 1.0 - 2.0 * self.depth[pixel[:, 1], pixel[:, 0]] - 1e-3
        z_off = np.abs(z - expected[:, 2])[inside]
        self.assertLess(np.median(z_off), 0.01 * WIDTH)
        self.assertLess(np.percentile(z_off, 99), 0.1 * WIDTH)  # chords of triangles of 3/8 of the width

    def test_nothing_tears(self) -> None:
        """No background that has the sheet on all four sides, whatever the parts of the edges."""
        for attachment in ("LIMIT", "PN", "LINEAR"):
            sheet = Sheet(attachment, count=7)
            parts = sheet.drawing.parts
            self.assertGreater(len(np.unique(parts)), 2, attachment)
            self.assertTrue((parts[:, 1:] < parts[:, :1]).any(), attachment)  # some are cut less at an edge
            for turn in np.linspace(0.0, 0.9, 7):
                self.drawn(sheet, Matrix.Rotation(turn, 4, "X") @ Matrix.Rotation(turn, 4, "Z")
                           @ Matrix.Translation((-0.35, -0.5, 0.0)))
                covered = self.color[..., 3] > 0.5
                around = np.ones_like(covered)
                for axis in (0, 1):
                    for step in (1, -1):  # something on this side of it
                        turned = np.flip(covered, axis) if step < 0 else covered
                        so_far = np.logical_or.accumulate(turned, axis)
                        around &= np.flip(so_far, axis) if step < 0 else so_far
                self.assertGreater(covered.sum(), 0.2 * SIDE * SIDE)
                self.assertEqual((around & ~covered).sum(), 0, f"{attachment}, {turn}")


def as_array(buffer: gpu.types.Buffer, channels: int) -> np.ndarray:
    buffer.dimensions = SIDE * SIDE * channels
    return np.array(buffer, np.float32).reshape(SIDE, SIDE, channels)


class FoldsCase(PreviewCase):
    method = "PATHS"

    def entry(self) -> registry.Runtime:
        return registry.runtime(self.obj)

    def settled(self, stands_in: bool = True) -> Iterator[float]:
        """Waits until the viewport has the mesh that it should have."""
        self.area.tag_redraw()
        yield from self.until(lambda: self.entry().inputs is not None and self.entry().inputs.stands_in == stands_in)
        self.assertEqual(self.entry().inputs.stands_in, stands_in)
        yield 0.1

    def both(self) -> Iterator[float]:
        """self.fine and self.drawn: pictures of the fine mesh and of the preview."""
        paths = self.obj.rumple.paths
        paths.gpu_preview = False
        yield from self.settled(False)
        yield from self.shot()
        self.fine = self.seen
        self.screenshot("folds_fine")
        paths.gpu_preview = True
        yield from self.settled()
        yield from self.shot()
        self.drawn = self.seen


class Pictures(FoldsCase):

    def test_it_looks_like_the_fine_mesh(self) -> Iterator[float]:
        yield from self.make()
        yield from self.both()
        self.screenshot("folds_preview")
        self.assertEqual(len(preview._on_gpu), 1)
        self.assertGreater(self.entry().picture.report.paths, 0)
        here = np.abs(self.fine - self.fine[5, 5]) > 8.0
        difference = np.abs(self.drawn - self.fine)[here]
        self.assertLess(np.median(difference), 4.0)
        self.assertLess(difference.mean(), 8.0)
        detail = [np.abs(picture - smooth(picture))[here].mean() for picture in (self.drawn, self.fine)]
        self.assertAlmostEqual(detail[0] / detail[1], 1.0, delta=0.3)
        # Without folds less is to be seen.
        self.obj.rumple.paths.height = 0.0
        yield from self.shot()
        self.assertLess(np.abs(self.seen - smooth(self.seen))[here].mean(), 0.85 * detail[0])

    def test_it_lies_over_what_is_behind_and_under_what_is_in_front(self) -> Iterator[float]:
        yield from self.make()
        yield from self.settled()
        shading = self.area.spaces.active.shading
        shading.light, shading.color_type, self.obj.color = "FLAT", "OBJECT", (1, 1, 1, 1)
        yield from self.shot()
        alone = (self.seen > 200.0).sum()
        self.assertGreater(alone, 20000)
        for z, seen in ((0.2, 0.8), (-0.2, 1.0)):  # the viewer is at z = 0.8
            with sleeve.context():
                bpy.ops.mesh.primitive_plane_add(size=0.2, location=(0.2, 0.0, z))
                plane = bpy.context.object
            plane.color = (0.05, 0.05, 0.05, 1)
            yield from self.shot()
            share = (self.seen > 200.0).sum() / alone
            self.assertTrue(share == 1.0 if seen == 1.0 else share < seen, (z, share))
            bpy.data.objects.remove(plane)

    def test_selected_it_has_an_outline_and_a_click_selects_it(self) -> Iterator[float]:
        yield from self.make()
        self.area.spaces.active.overlay.show_outline_selected = True
        self.obj.select_set(False)
        yield from self.settled()
        yield from self.shot()
        plain = self.seen
        region = next(region for region in self.area.regions if region.type == "WINDOW")
        from bpy_extras.view3d_utils import location_3d_to_region_2d
        at = location_3d_to_region_2d(region, self.area.spaces.active.region_3d, (0.1, 0.0, 0.06))
        with self.area_of_view():
            bpy.ops.view3d.select(location=(int(at.x), int(at.y)))
        self.assertTrue(self.obj.select_get())
        yield from self.shot()
        self.assertGreater((np.abs(self.seen - plain) > 20.0).sum(), 300)

    def test_two_garments(self) -> Iterator[float]:
        yield from self.make()
        with sleeve.context():
            sleeve.make_active(self.obj)
            bpy.ops.object.duplicate()
            bpy.context.object.location.y = -0.25
        yield from self.until(lambda: len(preview._on_gpu) == 2)
        yield from self.shot()
        self.assertEqual(len(preview._on_gpu), 2)
        self.assertEqual([held.refused for held in preview._on_gpu.values()], [False, False])
        for obj, _ours in modifier.wrinkled_objects():
            self.assertTrue(registry.runtime(obj).inputs.stands_in)


class Meshes(FoldsCase):
    """When the fine mesh is made and when it is not, and that nobody gets the wrong one."""

    def test_while_it_plays_no_fine_mesh_is_made(self) -> Iterator[float]:
        yield from self.make()
        yield from self.settled()
        shown, show = [], WrinklePaths._show
        self.addCleanup(setattr, WrinklePaths, "_show", show)
        WrinklePaths._show = lambda *arguments: shown.append(1) or show(*arguments)
        for frame in range(2, sleeve.LAST + 1):
            sleeve.at(frame)
            self.assertEqual(len(sleeve.shown(self.obj)), len(self.obj.data.vertices))
            self.assertEqual(self.entry().inputs.frame, frame)
        self.assertEqual(shown, [])
        yield from self.shot()
        (held,) = preview._on_gpu.values()
        self.assertIs(held.inputs, self.entry().inputs)

    def test_the_stand_in_has_its_vertices_on_the_drawn_surface(self) -> Iterator[float]:
        yield from self.make()
        yield from self.settled()
        drawing = self.entry().picture.drawing
        for place in sleeve.shown(self.obj):
            self.assertLess(((drawing.smooth - place)**2).sum(1).min(), 1e-9)

    def test_other_shadings_modes_and_modifiers_get_the_fine_mesh(self) -> Iterator[float]:
        yield from self.make(gpu_preview=False)
        fine = sleeve.shown(self.obj)
        self.obj.rumple.paths.gpu_preview = True
        yield from self.settled()
        space = self.area.spaces.active

        def paint(on: bool) -> None:
            with self.area_of_view():
                bpy.ops.object.mode_set(mode="WEIGHT_PAINT" if on else "OBJECT")

        bpy.context.scene.render.engine = "BLENDER_WORKBENCH"  # EEVEE's first picture takes minutes without a GPU
        switches = (lambda on: setattr(space.shading, "type", "RENDERED" if on else "SOLID"),
                    lambda on: setattr(space.shading, "type", "WIREFRAME" if on else "SOLID"),
                    lambda on: setattr(space.shading, "show_xray", on), paint,
                    lambda on: setattr(self.obj.rumple.paths, "gpu_preview", not on))
        for number, switch in enumerate(switches):
            switch(True)
            yield from self.settled(False)
            np.testing.assert_array_equal(sleeve.shown(self.obj), fine, err_msg=str(number))
            switch(False)
            yield from self.settled()
            self.assertEqual(len(sleeve.shown(self.obj)), len(self.obj.data.vertices))

    def test_a_second_viewport_that_needs_the_fine_mesh_gets_it(self) -> Iterator[float]:
        yield from self.make()
        yield from self.settled()
        other = next(area for area in bpy.context.window_manager.windows[0].screen.areas if area != self.area
                     and area.type != "VIEW_3D")
        former, other.type = other.type, "VIEW_3D"
        yield 0.2
        other.spaces.active.shading.type = "SOLID"
        other.spaces.active.shading.show_xray = True
        yield from self.settled(False)
        other.spaces.active.shading.show_xray = False
        yield from self.settled()
        other.type = former

    def test_renders_have_the_fine_mesh(self) -> Iterator[float]:
        obj = shots.stage("BLENDER_WORKBENCH")
        with sleeve.context():
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method="PATHS")
        yield from self.view()
        self.obj, pictures = obj, []
        for on in (False, True):
            obj.rumple.paths.gpu_preview = on
            yield from self.settled(on)
            pictures.append(shots.still(sleeve.LAST))
        yield from self.settled()  # and the viewport has its own again
        np.testing.assert_array_equal(*pictures)

    def test_apply_and_bakes_have_the_fine_mesh(self) -> Iterator[float]:
        yield from self.make(gpu_preview=False)
        sleeve.play()
        fine = sleeve.shown(self.obj)
        self.obj.rumple.bake_end = sleeve.LAST
        baked = []
        with tempfile.TemporaryDirectory() as folder:
            with sleeve.context():
                bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / "bake.blend"))
            for on in (False, True):
                self.obj.rumple.paths.gpu_preview = on
                yield from self.settled(on)
                with sleeve.context():
                    sleeve.make_active(self.obj)
                    bpy.ops.object.rumple_bake()
                sleeve.at(sleeve.LAST)
                baked.append(sleeve.shown(self.obj))
                with sleeve.context():
                    bpy.ops.object.rumple_bake_free()
        self.assertEqual(len(baked[0]), len(fine))
        np.testing.assert_array_equal(*baked)
        sleeve.play()
        yield from self.settled()
        with sleeve.context():
            sleeve.make_active(self.obj)
            bpy.ops.object.rumple_apply()
        found = np.empty(3 * len(self.obj.data.vertices), np.float32)
        self.obj.data.vertices.foreach_get("co", found)
        np.testing.assert_array_equal(found.reshape(-1, 3), fine)

    def test_a_saved_file_shows_the_fine_mesh_without_the_add_on_and_the_preview_with_it(self) -> Iterator[float]:
        yield from self.make(gpu_preview=False)
        fine = sleeve.shown(self.obj)
        self.obj.rumple.paths.gpu_preview = True
        yield from self.settled()
        with tempfile.TemporaryDirectory() as folder:
            blend = str(Path(folder) / "preview.blend")
            with sleeve.context():
                bpy.ops.wm.save_as_mainfile(filepath=blend)
            yield from self.settled()
            handlers.unregister()
            try:
                with sleeve.context():
                    bpy.ops.wm.open_mainfile(filepath=blend)
                yield 0.3
                np.testing.assert_array_equal(sleeve.shown(bpy.data.objects["Sleeve"]), fine)
            finally:
                handlers.register()
            with sleeve.context():
                bpy.ops.wm.open_mainfile(filepath=blend)
            self.obj = bpy.data.objects["Sleeve"]
            yield from self.view()
            sleeve.at(sleeve.LAST)
            yield from self.settled()
            yield from self.shot()
            self.assertEqual([held.refused for held in preview._on_gpu.values()], [False])


class Refusals(FoldsCase):

    def test_a_driver_that_refuses_leaves_the_fine_mesh(self) -> Iterator[float]:
        yield from self.make(gpu_preview=False)
        yield from self.shot()
        fine = self.seen
        compile_, tried = gpu_paths._compile, []

        def refuse() -> None:
            tried.append(1)
            raise RuntimeError("a driver that does not like it")

        self.addCleanup(setattr, gpu_paths, "_compile", compile_)
        preview._clear()
        gpu_paths._compile = refuse
        self.obj.rumple.paths.gpu_preview = True
        yield from self.until(lambda: tried)
        yield from self.settled(False)
        yield from self.shot()
        self.assertLess(np.abs(self.seen - fine).max(), 8.0)
        self.assertEqual(len(tried), 1)
