# SPDX-License-Identifier: GPL-3.0-or-later
"""With a window: panels draw, the viewport plays, timers rebuild, undo works."""
from __future__ import annotations

import os
import tempfile
from typing import Iterator

import bpy
import numpy as np
from rumple.blender.bake import clip
from rumple.blender.frame import baking
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier, runtimes
from support import sleeve
from support.window_case import WindowCase


def big_properties() -> Iterator[float]:
    """Turns the biggest area into the modifier tab, so that every panel is drawn."""
    areas = bpy.context.window_manager.windows[0].screen.areas
    area = max(areas, key=lambda a: a.width * a.height)
    area.type = "PROPERTIES"
    yield
    area.spaces.active.context = "MODIFIER"


class Panels(WindowCase):

    def make(self, wrinkles: bool = True) -> bpy.types.Object:
        return sleeve.scene(wrinkles=wrinkles)

    def test_every_panel_draws(self) -> Iterator[float]:
        obj = self.make()
        yield from big_properties()
        yield 0.3
        self.screenshot("panel_closed")
        for source, rest in (("REGULAR", "FRAME"), ("EDGE_LENGTH", "SHAPE_KEY"), ("OBJECT", "REST_POSE")):
            obj.rumple.mesh.source, obj.rumple.mesh.rest_shape = source, rest
            yield 0.5
        self.screenshot("panel_refusal")
        self.assertNotEqual(obj.rumple.message, "")
        obj.rumple.mesh.source = "SUBDIVISION"
        yield 0.6
        self.assertEqual(obj.rumple.message, "")

    def test_button_draws_without_wrinkles(self) -> Iterator[float]:
        self.make(wrinkles=False)
        yield from big_properties()
        yield 0.3
        self.screenshot("panel_button")


class Viewport(WindowCase):

    def view(self) -> None:
        areas = bpy.context.window_manager.windows[0].screen.areas
        area = max(areas, key=lambda a: a.width * a.height)
        area.type = "VIEW_3D"

    def make(self) -> bpy.types.Object:
        obj = sleeve.scene()
        self.view()
        return obj

    def test_settings_rebuild_from_a_timer(self) -> Iterator[float]:
        obj = self.make()
        yield 0.3
        coarse = runtimes.of(obj).evaluator.vertex_count
        obj.rumple.mesh.level = 2
        yield from self.until(lambda: runtimes.of(obj).evaluator.vertex_count > 3 * coarse)
        self.assertGreater(runtimes.of(obj).evaluator.vertex_count, 3 * coarse)
        np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-6)

    def test_playback_solves_every_frame_it_shows(self) -> Iterator[float]:
        obj = self.make()
        yield 0.2
        with self.area("VIEW_3D"):
            bpy.ops.screen.animation_play()
        yield from self.until(lambda: len(runtimes.of(obj).evaluator.frame_cache.frames()) > 3)
        with self.area("VIEW_3D"):
            bpy.ops.screen.animation_cancel(restore_frame=False)
        yield 0.2
        self.assertGreater(len(runtimes.of(obj).evaluator.frame_cache.frames()), 3)
        np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-6)

    def test_playback_draws_no_coarse_mesh(self) -> Iterator[float]:
        """The first pass of a frame has it (frame/first_pass.py), before anything is drawn."""
        obj = self.make()
        yield 0.2
        drawn = []
        handle = bpy.types.SpaceView3D.draw_handler_add(
            lambda: drawn.append((bpy.context.scene.frame_current, len(sleeve.shown(obj)))), (), "WINDOW", "POST_VIEW")
        try:
            with self.area("VIEW_3D"):
                bpy.ops.screen.animation_play()
            yield from self.until(lambda: len({frame for frame, _ in drawn}) > 5)
            with self.area("VIEW_3D"):
                bpy.ops.screen.animation_cancel(restore_frame=False)
        finally:
            bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
        self.assertGreater(len({frame for frame, _ in drawn}), 5)
        self.assertEqual({count for _, count in drawn}, {len(sleeve.shown(obj))})
        self.assertGreater(len(sleeve.shown(obj)), len(obj.data.vertices))

    def test_duplicates_are_split_by_the_timer(self) -> Iterator[float]:
        obj = self.make()
        yield 0.3
        with self.area("VIEW_3D"):
            bpy.ops.object.duplicate()
        copy = next(o for o in bpy.data.objects if o != obj and modifier.find(o))
        yield from self.until(lambda: sleeve.output_object(copy) != sleeve.output_object(obj))
        self.assertNotEqual(sleeve.output_object(copy), sleeve.output_object(obj))

    def test_a_follower_of_another_wrinkled_object_is_settled_by_the_timer(self) -> Iterator[float]:
        cuff = sleeve.cuff(self.make(), "SURFACE_DEFORM", "Cuff")
        yield 0.3
        sleeve.at(15)
        yield from self.until(lambda: self.is_settled(cuff))
        self.assertTrue(self.is_settled(cuff))
        seen = sleeve.shown(cuff)
        sleeve.at(15)
        np.testing.assert_array_equal(sleeve.shown(cuff), seen)

    def is_settled(self, obj: bpy.types.Object) -> bool:
        """Whether its folds are those for the coarse mesh that is shown."""
        posed = sleeve.attribute(obj, wrinkle_tree.BASE_POSITION)[:len(obj.data.vertices)]
        return np.array_equal(runtimes.of(obj).inputs.positions, posed)

    def test_undo_and_redo_of_adding_and_removing(self) -> Iterator[float]:
        obj = self.make()
        yield 0.3
        for _ in range(2):
            with self.area("VIEW_3D"):
                bpy.ops.ed.undo_push(message="before")
                bpy.ops.object.rumple_remove()
                bpy.ops.ed.undo_push(message="removed")
            yield 0.3
            with self.area("VIEW_3D"):
                bpy.ops.ed.undo()
            yield 0.4
            obj = bpy.data.objects["Sleeve"]
            self.assertIsNotNone(modifier.find(obj))
            sleeve.at(15)
            self.assertEqual(obj.rumple.message, "")
            with self.area("VIEW_3D"):
                bpy.ops.ed.redo()
            yield 0.3
            obj = bpy.data.objects["Sleeve"]
            self.assertIsNone(modifier.find(obj))
            with self.area("VIEW_3D"):
                bpy.ops.ed.undo()
            yield 0.4
            obj = bpy.data.objects["Sleeve"]
        sleeve.at(12)
        yield from self.until(lambda: sleeve.picture(obj) is not None)
        np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=1e-6)

    def test_weight_paint_with_the_modifier_on(self) -> Iterator[float]:
        obj = self.make()
        yield 0.3
        with self.area("VIEW_3D"):
            bpy.ops.object.rumple_paint(group="radius")
        yield from self.until(lambda: "Rumple Radius" in sleeve.output_object(obj).vertex_groups)
        self.assertEqual(obj.mode, "WEIGHT_PAINT")
        self.assertIn("Rumple Radius", sleeve.output_object(obj).vertex_groups)
        self.screenshot("weight_paint")
        obj.vertex_groups["Rumple Radius"].add(range(len(obj.data.vertices)), 0.0, "REPLACE")
        obj.data.update()
        sleeve.at(20)
        yield from self.until(lambda: np.abs(sleeve.attribute(obj, "rumple_offset")).max() < 1e-6)
        np.testing.assert_allclose(sleeve.attribute(obj, "rumple_offset"), 0.0, atol=1e-6)
        with self.area("VIEW_3D"):
            bpy.ops.object.mode_set(mode="OBJECT")

    def test_bake_runs_modal_and_can_be_cancelled(self) -> Iterator[float]:
        obj = self.make()
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(os.environ["RUMPLE_OUT"], "window_bake.blend"))
        yield 0.3
        with self.area("VIEW_3D"):
            self.assertEqual(bpy.ops.object.rumple_bake("INVOKE_DEFAULT"), {"RUNNING_MODAL"})
        window = bpy.context.window_manager.windows[0]
        for _ in range(100):
            yield 0.05
            if modifier.is_baked(modifier.find(obj)):
                break
        self.assertTrue(modifier.is_baked(modifier.find(obj)))
        obj.rumple.bake_end = 5000
        with self.area("VIEW_3D"):
            bpy.ops.object.rumple_bake("INVOKE_DEFAULT")
        yield 0.2
        window.event_simulate("ESC", "PRESS", x=400, y=400)
        window.event_simulate("ESC", "RELEASE", x=400, y=400)
        yield 0.5
        self.assertTrue(modifier.is_baked(modifier.find(obj)))
        sleeve.at(20)
        yield 0.2
        self.assertEqual(obj.rumple.message, "")

    def test_a_bake_whose_window_is_closed_ends_and_leaves_nothing(self) -> Iterator[float]:
        """Nobody ended it: every garment stayed bare, and the clip locked."""
        obj = self.make()
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(own.name, "window_bake.blend"))
        obj.rumple.bake_end = 5000
        folder, frame = clip.new_clip_path(obj).parent, bpy.context.scene.frame_current
        with sleeve.context():
            bpy.ops.wm.window_new()
        yield 0.5
        second = bpy.context.window_manager.windows[-1]
        with sleeve.context(window=second, area=second.screen.areas[0]):
            self.assertEqual(bpy.ops.object.rumple_bake("INVOKE_DEFAULT"), {"RUNNING_MODAL"})
        yield from self.until(lambda: bpy.context.scene.frame_current > frame + 2)
        self.assertEqual(len(os.listdir(folder)), 2)  # the clip that is written, and its lock
        with sleeve.context(window=second):
            bpy.ops.wm.window_close()
        yield 0.5
        self.assertEqual(len(bpy.context.window_manager.windows), 1)
        self.assertEqual(os.listdir(folder) if folder.is_dir() else [], [])
        self.assertEqual((baking.is_running(), bpy.context.scene.frame_current), (False, frame))
        sleeve.at(5)
        yield 0.2
        self.assertTrue(sleeve.is_fine(obj))

    def test_a_bake_whose_object_is_deleted_ends_and_leaves_nothing(self) -> Iterator[float]:
        """ReferenceError escaped its timer: this went on for ever, and the file that was being written stayed."""
        obj = self.make()
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(own.name, "window_bake.blend"))
        obj.rumple.bake_end = 5000
        folder = clip.new_clip_path(obj).parent
        yield 0.3
        frame = bpy.context.scene.frame_current
        with self.area("VIEW_3D"):
            self.assertEqual(bpy.ops.object.rumple_bake("INVOKE_DEFAULT"), {"RUNNING_MODAL"})
        for _ in range(100):
            yield 0.05
            if bpy.context.scene.frame_current > frame + 2:
                break
        self.assertEqual(len([name for name in os.listdir(folder) if name.endswith(".part")]), 1)
        bpy.data.objects.remove(obj)
        yield 0.5
        self.assertEqual(os.listdir(folder) if folder.is_dir() else [], [])
        stopped = bpy.context.scene.frame_current
        yield 0.3
        self.assertEqual((stopped, bpy.context.scene.frame_current), (frame, frame))
