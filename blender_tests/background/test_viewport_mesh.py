# SPDX-License-Identifier: GPL-3.0-or-later
"""Viewports show fewer vertices of the same folds, and renders are what they were."""
from __future__ import annotations

import os
import tempfile
import unittest
from unittest import mock
from typing import Any

import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.bake import clip
from rumple.blender.frame import clip_status
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.nodes.output_flags import Flag, is_set
from rumple.blender.objects import modifier, output_mesh, runtimes, viewport_mesh
from support import face, sleeve


class Recorder(bpy.types.RenderEngine):
    """A render engine that keeps the positions of the sleeve as renders have them."""

    bl_idname = "RUMPLE_RECORDER"
    bl_label = "Recorder"
    seen = []

    def update(self, _data: bpy.types.BlendData | None = None, depsgraph: bpy.types.Depsgraph | None = None) -> None:
        obj = bpy.data.objects["Sleeve"].evaluated_get(depsgraph)
        type(self).seen.append(compat.positions(obj.data).copy())

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        pass


def scene(viewport: int = 0, steps: int = 1, **settings: Any) -> bpy.types.Object:
    """The sleeve with smoothing steps; the frames begin at 1."""
    obj = sleeve.scene(wrinkles=False)
    mesh = obj.rumple.mesh
    mesh.density, mesh.level, mesh.display_steps, obj.rumple.viewport_steps = "LEVEL", 1, steps, viewport
    for name, value in settings.items():
        setattr(mesh, name, value)
    with sleeve.context():
        bpy.ops.object.rumple_add(method="MESH")
        bpy.context.view_layer.update()
    return obj


def rendered(frame: int) -> Any:
    """Positions in a render of one frame."""
    bpy.utils.register_class(Recorder)
    try:
        bpy.context.scene.render.engine, Recorder.seen = Recorder.bl_idname, []
        bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 8
        if bpy.context.scene.camera is None:
            bpy.context.scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
            bpy.context.scene.collection.objects.link(bpy.context.scene.camera)
        sleeve.at(frame)
        bpy.ops.render.render()
    finally:
        bpy.context.scene.render.engine = "CYCLES"
        bpy.utils.unregister_class(Recorder)
    return Recorder.seen[-1]


def hidden() -> int:
    """How many hidden objects of ours the file has."""
    return sum(output_mesh.KEY in obj for obj in bpy.data.objects)


class ViewportMesh(unittest.TestCase):

    def test_viewports_show_the_solved_vertices_themselves(self) -> None:
        """In one layer and in several. Renders, subdivided once more, have four times as many."""
        for layers in ("ONE", "CLOTH"):
            with self.subTest(layers):
                obj = scene(layers=layers)
                sleeve.play(1, 6)
                fine, shown = runtimes.of(obj).evaluator, sleeve.shown(obj)
                self.assertEqual(len(shown), fine.in_viewport.vertex_count)
                self.assertLess(len(shown), 0.3 * fine.vertex_count)
                self.assertGreater(np.abs(shown - fine.in_viewport.positions_rest).max(), 0.01)
                if layers == "CLOTH":
                    np.testing.assert_allclose(shown, fine.wrinkles_of(6.0).solved, atol=2e-6)

    def test_renders_do_not_depend_on_it(self) -> None:
        pictures = []
        for viewport in (0, 1):
            obj = scene(viewport, layers="CLOTH")
            sleeve.play(1, 6)
            pictures.append(rendered(6))
            self.assertEqual(len(pictures[-1]), runtimes.of(obj).evaluator.vertex_count)
        self.assertEqual(runtimes.of(obj).evaluator.in_viewport, None)
        np.testing.assert_array_equal(*pictures)

    def test_after_a_render_the_viewport_goes_on_as_it_was(self) -> None:
        shown = []
        for render in (False, True):
            obj = scene()
            sleeve.play(1, 4)
            if render:
                rendered(4)
            sleeve.play(5, 6)
            shown.append(sleeve.shown(obj))
        np.testing.assert_array_equal(*shown)

    def test_with_as_many_steps_there_is_one_mesh(self) -> None:
        obj = scene()
        self.assertEqual(hidden(), 2)
        for viewport, steps in ((1, 1), (2, 1), (0, 0)):
            with sleeve.context():
                obj.rumple.viewport_steps, obj.rumple.mesh.display_steps = viewport, steps
            sleeve.at(5)
            scheduler.sync_all()
            self.assertEqual(hidden(), 1, (viewport, steps))
            self.assertIsNone(modifier.viewport_output(modifier.find(obj)))
            self.assertEqual(len(sleeve.shown(obj)), runtimes.of(obj).evaluator.vertex_count)

    def test_stored_frames_outlive_another_smoothing(self) -> None:
        """The same folds are solved: of frames that were played nothing is solved again."""
        shown = []
        for first, second in ((0, 1), (1, 1), (1, 0), (0, 0)):
            with self.subTest(first=first, second=second):
                obj = scene(first, layers="CLOTH")
                sleeve.play(1, 6)
                with sleeve.context():
                    obj.rumple.viewport_steps = second
                sleeve.at(6)
                scheduler.sync_all()
                fine = runtimes.of(obj).evaluator
                self.assertEqual([frame for frame, _ in fine.frame_cache.frames()], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
                with mock.patch.object(fine, "_solve_over", side_effect=AssertionError):
                    sleeve.play(1, 6)
                self.assertEqual(obj.rumple.message, "")
                shown.append(sleeve.shown(obj))
        np.testing.assert_array_equal(shown[0], shown[1])
        np.testing.assert_array_equal(shown[2], shown[3])

    def test_it_inherits_what_the_mesh_of_renders_does(self) -> None:
        obj = scene()
        sleeve.at(3)
        render, viewport = (output.data for output in modifier.outputs(modifier.find(obj)))
        self.assertEqual(sleeve.names(viewport.uv_layers), sleeve.names(render.uv_layers))
        self.assertEqual(list(viewport.materials), list(render.materials))
        self.assertEqual(sleeve.names(modifier.viewport_output(modifier.find(obj)).vertex_groups),
                         sleeve.names(obj.vertex_groups))
        with sleeve.context():
            obj.data.materials.append(bpy.data.materials.new("Later"))
            obj.data.update_tag()
            bpy.context.view_layer.update()
        self.assertIn("Later", sleeve.names(viewport.materials))

    def test_a_duplicate_has_one_of_its_own(self) -> None:
        obj = scene()
        copy = obj.copy()
        bpy.context.scene.collection.objects.link(copy)
        sleeve.at(2)
        sleeve.at(3)
        outputs = {output for one in (obj, copy) for output in modifier.outputs(modifier.find(one))}
        self.assertEqual(len(outputs), 4)
        self.assertEqual(len(sleeve.shown(copy)), len(sleeve.shown(obj)))
        with sleeve.context():
            for one in (obj, copy):
                sleeve.make_active(one)
                bpy.ops.object.rumple_remove()
        self.assertEqual(hidden(), 0)


class TheMeshOfRenders(unittest.TestCase):
    """Where viewports show it."""

    def assert_shown(self, obj: bpy.types.Object) -> None:
        sleeve.at(5)
        sleeve.at(6)
        self.assertEqual(len(sleeve.shown(obj)), runtimes.of(obj).evaluator.vertex_count)

    def test_where_something_is_bound_to_its_points(self) -> None:
        obj = scene()
        patch = bpy.data.objects.new("Patch", bpy.data.meshes.new("Patch"))
        bpy.context.scene.collection.objects.link(patch)
        patch.modifiers.new("Bound", "SURFACE_DEFORM").target = obj
        self.assert_shown(obj)
        bpy.data.objects.remove(patch)
        sleeve.at(7)
        self.assertEqual(len(sleeve.shown(obj)), runtimes.of(obj).evaluator.in_viewport.vertex_count)

    def test_where_a_modifier_behind_keeps_what_it_saw(self) -> None:
        obj = scene()
        obj.modifiers.new("Collision", "COLLISION")
        self.assert_shown(obj)

    def test_under_wrinkle_maps(self) -> None:
        """Their masks are of its vertices."""
        obj, rig = face.scene()
        face.two_poses(obj, rig)
        face.animate(rig)
        mesh = obj.rumple.mesh
        mesh.density, mesh.level, mesh.display_steps = "LEVEL", 1, 1
        sleeve.make_active(obj)
        with sleeve.context():
            bpy.ops.object.rumple_add(method="MESH")
        self.assertIsNotNone(modifier.viewport_output(modifier.find(obj)))
        self.assert_shown(obj)
        self.assertEqual((obj.rumple.message, obj.rumple_maps.message), ("", ""))

    def test_where_it_is_applied(self) -> None:
        obj = scene()
        sleeve.play(1, 6)
        count = runtimes.of(obj).evaluator.vertex_count
        with sleeve.context():
            bpy.ops.object.rumple_apply()
        self.assertEqual(len(obj.data.vertices), count)
        self.assertEqual(hidden(), 0)

    def test_in_a_bake_and_in_its_clip(self) -> None:
        obj = scene()
        with tempfile.TemporaryDirectory() as folder:
            obj.rumple.bake_folder, obj.rumple.bake_start, obj.rumple.bake_end = folder, 1, 6
            with sleeve.context():
                bpy.ops.object.rumple_bake()
            about = clip_status.manifest(clip_status.clip_path(obj))
            self.assertEqual(about.vertices, runtimes.of(obj).evaluator.vertex_count)
            self.assert_shown(obj)
            baked = sleeve.shown(obj)
            clip.free(obj, delete_file=True)
        sleeve.play(1, 6)
        np.testing.assert_allclose(baked, rendered(6), atol=1e-6)
        sleeve.at(7)
        self.assertEqual(len(sleeve.shown(obj)), runtimes.of(obj).evaluator.in_viewport.vertex_count)

    def test_live_folds_in_place_of_a_lost_clip_move(self) -> None:
        """Also where the viewport mesh of a baked garment is not there, or should not be: in a duplicate, and in a
        file that was baked before there were any."""
        obj = scene()
        with tempfile.TemporaryDirectory() as folder:
            obj.rumple.bake_folder, obj.rumple.bake_start, obj.rumple.bake_end = folder, 1, 6
            with sleeve.context():
                bpy.ops.object.rumple_bake()
        modifier.set_viewport_output(modifier.find(obj), None)
        copy = obj.copy()
        bpy.context.scene.collection.objects.link(copy)
        for one in (obj, copy):
            sleeve.play(1, 2)
            before = sleeve.shown(one)
            sleeve.play(3, 5)
            self.assertIn("live folds are shown", one.rumple.message)
            self.assertGreater(np.abs(sleeve.shown(one) - before).max(), 0.01, one.name)

    def test_a_new_one_is_not_shown_before_it_is_known_who_minds(self) -> None:
        obj = scene()
        self.assertFalse(is_set(modifier.viewport_output(modifier.find(obj)), Flag.RENDER_MESH))
        with mock.patch.object(viewport_mesh, "show_in_viewports"):
            modifier.set_viewport_output(modifier.find(obj), None)
            with sleeve.context():
                runtimes.of(obj).stale = True
                scheduler.sync_all()
            self.assertTrue(is_set(modifier.viewport_output(modifier.find(obj)), Flag.RENDER_MESH))

    def test_a_saved_file_has_its_last_frame_in_both(self) -> None:
        """Without the add-on renders show it, although no frame of the mesh of renders was ever asked for."""
        obj = scene()
        sleeve.play(1, 6)
        with tempfile.TemporaryDirectory() as folder, sleeve.context():
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "scene.blend"))
        mesh = modifier.output_object(modifier.find(obj)).data
        saved = compat.read_attribute(mesh.attributes[wrinkle_tree.LOCAL_OFFSET]).copy()
        rendered(6)
        np.testing.assert_array_equal(saved, compat.read_attribute(mesh.attributes[wrinkle_tree.LOCAL_OFFSET]))
        self.assertGreater(np.abs(saved).max(), 0.001)


class Proxy(unittest.TestCase):
    """While all viewports draw the folds, they show the coarse mesh, moved; renders keep the fine one."""

    def test_in_viewports_alone(self) -> None:
        obj = sleeve.scene()
        sleeve.at(3)
        fine, mesh = sleeve.shown(obj), sleeve.output_object(obj).data
        for moved in (0.25, None, 0.5):
            with self.subTest(moved):
                count = len(obj.data.vertices)
                output_mesh.write_proxy(mesh, None if moved is None else np.full((count, 3), moved, np.float32))
                bpy.context.view_layer.update()
                if moved is None:
                    np.testing.assert_array_equal(sleeve.shown(obj), fine)
                else:
                    incoming = sleeve.attribute(obj, wrinkle_tree.BASE_POSITION)[:count]
                    np.testing.assert_allclose(sleeve.shown(obj), incoming + np.float32(moved), atol=1e-6)
        np.testing.assert_array_equal(rendered(3), fine)


if __name__ == "__main__":
    unittest.main()
