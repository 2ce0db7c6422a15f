# SPDX-License-Identifier: GPL-3.0-or-later
"""The GPU preview of the Wrinkle Paths: its pictures against the fine mesh, its manners."""
from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Iterator

import bpy
import numpy as np
from rumple.blender.objects import modifier, runtimes
from rumple.blender.viewport import preview, preview_paths
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support import sleeve, small_renders
from support.preview_case import PreviewCase, smooth


class FoldsCase(PreviewCase):
    method = "PATHS"

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
        self.assertGreater(self.runtime().result.report.paths, 0)
        here = np.abs(self.fine - self.fine[5, 5]) > 8.0
        difference = np.abs(self.drawn - self.fine)[here]
        self.assertLess(np.median(difference), 4.0)
        self.assertLess(difference.mean(), 8.0)
        detail = [np.abs(picture - smooth(picture))[here].mean() for picture in (self.drawn, self.fine)]
        self.assertAlmostEqual(detail[0] / detail[1], 1.0, delta=0.3)
        # Without folds less is to be seen.
        self.obj.rumple.paths.height = 0.0
        yield from self.until(lambda: self.runtime().inputs.settings.height == 0.0)  # a busy machine takes its time
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

    def test_bones_stay_over_the_folds(self) -> Iterator[float]:
        """It once lay over all that Blender had drawn."""
        yield from self.make()
        yield from self.both()
        self.show_overlays(True)
        self.obj.select_set(False)  # the fine mesh has its outline elsewhere
        yield from self.shot()
        above = self.seen
        self.screenshot("overlays_over_folds")
        self.obj.rumple.paths.gpu_preview = False
        yield from self.settled(False)
        yield from self.shot()
        bones = np.abs(self.seen - self.fine) > 60.0
        self.assertGreater(bones.sum(), 300)
        self.assertGreater((np.abs(above - self.drawn)[bones] > 30.0).mean(), 0.9)
        self.assertLess(np.median(np.abs(above - self.seen)[bones]), 4.0)

    def test_two_garments(self) -> Iterator[float]:
        yield from self.make()
        with sleeve.context():
            sleeve.make_active(self.obj)
            bpy.ops.object.duplicate()
            bpy.context.object.location.y = -0.25
        yield from self.until(lambda: len(preview._on_gpu) == 2)
        yield from self.shot()
        self.assertEqual(len(preview._on_gpu), 2)
        self.assertEqual([held.refusal for held in preview._on_gpu.values()], ["", ""])
        for obj, _ours in modifier.wrinkled_objects():
            self.assertTrue(runtimes.of(obj).inputs.for_preview)


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
            self.assertEqual(self.runtime().inputs.frame, frame)
        self.assertEqual(shown, [])
        yield from self.shot()
        (held,) = preview._on_gpu.values()
        self.assertIs(held.inputs, self.runtime().inputs)

    def test_the_proxy_has_its_vertices_on_the_drawn_surface(self) -> Iterator[float]:
        yield from self.make()
        yield from self.settled()
        drawing = self.runtime().result.drawing
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

    def test_what_is_bound_to_its_points_gets_the_fine_mesh(self) -> Iterator[float]:
        """It was bound to points that were not shown any more, and stood still."""
        yield from self.make(gpu_preview=False)
        fine = sleeve.shown(self.obj)
        badge = bpy.data.objects.new("Badge", bpy.data.meshes.new("Badge"))
        badge.data.from_pydata([(0.2, 0.0, 0.07), (0.21, 0.0, 0.07), (0.21, 0.01, 0.07)], [], [(0, 1, 2)])
        bpy.context.scene.collection.objects.link(badge)
        badge.modifiers.new("Glue", "SURFACE_DEFORM").target = self.obj
        self.obj.rumple.paths.gpu_preview = True
        yield from self.settled(False)
        np.testing.assert_array_equal(sleeve.shown(self.obj), fine)
        badge.modifiers.clear()
        yield from self.settled()

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
        obj = small_renders.stage("BLENDER_WORKBENCH")
        with sleeve.context():
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method="PATHS")
        yield from self.view()
        self.obj, pictures = obj, []
        for on in (False, True):
            obj.rumple.paths.gpu_preview = on
            yield from self.settled(on)
            pictures.append(small_renders.still(sleeve.LAST))
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
            yield from self.opened_again(blend, fine)
            yield from self.view()
            sleeve.at(sleeve.LAST)
            yield from self.settled()
            yield from self.shot()
            self.assertEqual([held.refusal for held in preview._on_gpu.values()], [""])


class Refusals(FoldsCase):

    def test_a_driver_that_refuses_leaves_the_fine_mesh(self) -> Iterator[float]:
        yield from self.make(gpu_preview=False)
        yield from self.shot()
        fine = self.seen
        tried = self.refuse(preview_paths)
        self.obj.rumple.paths.gpu_preview = True
        yield from self.until(lambda: tried)
        yield from self.settled(False)
        yield from self.shot()
        self.assertLess(np.abs(self.seen - fine).max(), 8.0)
        self.assertEqual(len(tried), 1)
