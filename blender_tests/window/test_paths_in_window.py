# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Paths with a window: what the overlay draws, an edited mesh in the preview, and curves while Blender plays,
undoes and renders."""
from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Iterator

import bmesh
import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.frame import path_curves
from rumple.blender.objects import runtimes
from rumple.blender.viewport import paths_overlay, preview
from support import curve_edges, sleeve, small_renders
from support.window_case import WindowCase


class PathsCase(WindowCase):

    def make(self, curves: bool = False) -> Iterator[float]:
        """The sleeve with Wrinkle Paths seen from above in a clean Solid viewport: self.obj and self.view."""
        self.obj = sleeve.scene(wrinkles=False)
        with sleeve.context():
            bpy.ops.object.rumple_add(method="PATHS")
            if curves:
                bpy.ops.object.rumple_curves_add()
        self.view = max(bpy.context.window_manager.windows[0].screen.areas, key=lambda a: a.width * a.height)
        self.view.type = "VIEW_3D"
        yield 0.2
        space = self.view.spaces.active
        self.clear_view(space)
        space.overlay.show_overlays = True
        region = space.region_3d
        region.view_rotation, region.view_location, region.view_distance = (1, 0, 0, 0), (0.25, 0.12, 0.0), 0.8
        region.view_perspective = "PERSP"
        yield 0.3

    def shot(self) -> Iterator[float]:
        """Leaves the viewport in self.seen, (height, width, 3) int, without the header."""
        bpy.context.window_manager.windows[0].cursor_warp(2, 2)
        self.view.tag_redraw()
        yield 0.5
        pixels = self.pixels().astype(int)
        top = len(pixels) - self.view.y - self.view.height
        self.seen = pixels[top + 40:top + self.view.height - 40, self.view.x + 60:self.view.x + self.view.width - 20]

    def coloured(self) -> list[int]:
        """Pixels that are clearly blue, green and red."""
        def stands_out(channel: int) -> int:
            others = np.delete(self.seen, channel, axis=2).max(axis=2)
            return int((self.seen[:, :, channel] - others > 25).sum())
        return [stands_out(channel) for channel in (2, 1, 0)]


class Overlay(PathsCase):

    def test_labels_and_ellipses_show_what_the_cloth_does(self) -> Iterator[float]:
        yield from self.make()
        sleeve.play(last=12)
        yield from self.shot()
        without = self.coloured()
        self.obj.rumple.paths.show_overlay = True
        yield from self.shot()
        self.screenshot("paths_overlay")
        blue, green, red = self.coloured()
        report = runtimes.of(self.obj).result.report
        self.assertGreater(min(report.compressed, report.stretched), 5)
        self.assertGreater(blue, without[0] + 500, "the inside of the bend")
        self.assertGreater(green, without[1] + 2000, "what keeps its shape")
        self.assertGreater(red, without[2] + 500, "the outside of the bend")
        self.view.spaces.active.overlay.show_overlays = False
        yield from self.shot()
        self.assertEqual(self.coloured(), without)

    def test_it_follows_the_frame_and_is_made_anew_only_then(self) -> Iterator[float]:
        yield from self.make()
        yield from self.shot()
        without = self.coloured()  # Blender's own icons
        self.obj.rumple.paths.show_overlay = True
        sleeve.play(last=12)
        yield from self.shot()
        moving, key = self.coloured(), compat.session_key(self.obj)
        held = paths_overlay._drawn[key]
        yield from self.shot()
        self.assertIs(paths_overlay._drawn[key], held)
        sleeve.at(1)
        yield from self.shot()
        still = self.coloured()
        self.assertEqual((still[0], still[2]), (without[0], without[2]), "the first frame has nothing to compare with")
        self.assertGreater(still[1], moving[1])
        with sleeve.context():
            bpy.ops.object.rumple_remove()
        yield from self.shot()
        self.assertEqual(paths_overlay._drawn, {})
        self.assertEqual(self.coloured(), without)

    def test_every_face_is_there(self) -> None:
        corners = np.array([[[0, 0, 0], [3, 0, 0], [0, 4, 0]]] * 2, np.float32)
        ellipses = np.array([[1, 1, 0, 0.5, 0, 0, 0, 1, 0]] * 2, np.float32)
        points, colours, triangles = paths_overlay.faces(corners, np.array([0, 2], np.uint8), ellipses, 0.5)
        self.assertEqual(triangles.max(), len(points) - 1)
        self.assertEqual(len(triangles), 2 * (1 + paths_overlay.CORNERS - 2))
        a, b, c = (points[triangles[2:, k], :2] for k in range(3))
        area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
        sixteen = paths_overlay.CORNERS / 2 * np.sin(2 * np.pi / paths_overlay.CORNERS)
        self.assertAlmostEqual(area, 2 * sixteen * 0.5 * 1.0, places=5)
        np.testing.assert_array_equal(colours[:3, :3], np.repeat(paths_overlay.COLOURS[:1], 3, axis=0))
        self.assertEqual(len(colours), len(points))
        self.assertEqual(colours[-1, :3].argmax(), 0, "stretched is red")


class Preview(PathsCase):

    def test_a_mesh_that_was_edited_is_drawn_until_it_is_made_anew(self) -> Iterator[float]:
        """Its UV map was looked up for corners that are gone."""
        yield from self.make()
        self.obj.rumple.paths.gpu_preview = True
        sleeve.play(last=12)
        yield from self.until(lambda: any(held.inputs is not None for held in preview._on_gpu.values()))
        (held,) = preview._on_gpu.values()
        self.assertTrue(held.drawing.has_uv)
        edited = bmesh.new()
        edited.from_mesh(self.obj.data)
        edited.faces.ensure_lookup_table()
        bmesh.ops.delete(edited, geom=edited.faces[-3:], context="FACES")
        edited.to_mesh(self.obj.data)
        edited.free()
        runtime = runtimes.of(self.obj)
        slots = np.zeros(len(runtime.evaluator.coarse_triangles()[1]), np.int32)
        self.assertTrue(held.drawing.update(self.obj, runtime, None, slots))
        self.assertFalse(held.drawing.has_uv)


class Curves(PathsCase):

    def test_they_play_undo_and_are_seen(self) -> Iterator[float]:
        yield from self.make(curves=True)
        child = curve_edges.child_of(self.obj)
        with self.area_context():
            bpy.ops.ed.undo_push(message="curves")
            bpy.ops.screen.animation_play()
        yield from self.until(lambda: bpy.context.scene.frame_current > 15)
        with self.area_context():
            bpy.ops.screen.animation_cancel(restore_frame=False)
        yield 0.2
        sleeve.at(18)
        with sleeve.context():
            self.assertGreater(curve_edges.same(self, self.obj, child), 1)
        child.modifiers.remove(child.modifiers[curve_edges.NAME])
        nodes_mod = path_curves.find(child)
        compat.set_modifier_input(nodes_mod, compat.group_sockets(nodes_mod.node_group, "INPUT")["Radius"], 0.003)
        child.update_tag()
        yield from self.shot()
        self.screenshot("paths_curves")
        with self.area_context():
            bpy.ops.ed.undo_push(message="thick")
            sleeve.make_active(self.obj)
            bpy.ops.object.rumple_remove()
            bpy.ops.ed.undo_push(message="removed")
            self.assertEqual(list(path_curves.all_curves()), [])
            bpy.ops.ed.undo()
        yield 0.5
        obj = bpy.data.objects["Sleeve"]
        sleeve.at(17)
        yield 0.3
        with sleeve.context():
            child = curve_edges.child_of(obj)
            compat.set_modifier_input(path_curves.find(child), compat.group_sockets(
                path_curves.find(child).node_group, "INPUT")["Radius"], 0.0)
            child.update_tag()
            sleeve.at(18)
            self.assertGreater(curve_edges.same(self, obj, child), 1)

    def area_context(self) -> object:
        return sleeve.context(area=self.view, region=next(r for r in self.view.regions if r.type == "WINDOW"))

    def test_a_render_job_shows_the_curves_of_its_frames_while_the_window_draws(self) -> Iterator[float]:
        obj = small_renders.stage("CYCLES")
        with sleeve.context():
            bpy.ops.object.rumple_remove()
            bpy.ops.object.rumple_add(method="PATHS")
            bpy.ops.object.rumple_curves_add()
        nodes_mod = path_curves.find(curve_edges.child_of(obj))
        compat.set_modifier_input(nodes_mod, compat.group_sockets(nodes_mod.node_group, "INPUT")["Radius"], 0.006)
        obj.is_holdout = True
        view, scene = bpy.context.preferences.view, bpy.context.scene
        self.addCleanup(setattr, view, "render_display_type", view.render_display_type)
        view.render_display_type = "NONE"
        yield 0.3
        with sleeve.context():
            sleeve.play()
        with tempfile.TemporaryDirectory() as folder:
            scene.render.filepath = os.path.join(folder, "f")
            yield from self.render_job(animation=True)
            found = {int(path.stem[1:]): small_renders.read(str(path)) for path in sorted(Path(folder).iterdir())}
        self.assertEqual(obj.rumple.message, "")
        for frame in (14, 20):
            still = small_renders.still(frame)
            self.assertGreater((still[..., 3] > 0.5).sum(), 15)
            np.testing.assert_allclose(found[frame], still, atol=0.02)
