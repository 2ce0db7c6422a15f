# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that keyed visibility hides: Blender does not evaluate them there, and says that it does."""
from __future__ import annotations

import os
import tempfile
import unittest
from unittest import mock

import bpy
import numpy as np
from rumple.blender import compat, scheduler
from rumple.blender.frame import path_curves
from rumple.blender.frame.garment_reader import GarmentReader
from rumple.blender.objects import modifier, posed_coarse, runtimes
from support import sleeve, small_renders


def key(obj: bpy.types.Object, hidden: dict[int, bool]) -> None:
    """From these frames on."""
    for frame, value in hidden.items():
        obj.hide_viewport = obj.hide_render = value
        for name in ("hide_viewport", "hide_render"):
            obj.keyframe_insert(name, frame=frame)


class Hidden(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.obj = sleeve.scene()
        self.path = os.path.join(folder.name, "shot.blend")
        bpy.ops.wm.save_as_mainfile(filepath=self.path)

    def frames(self) -> list[tuple[float, bool]]:
        return runtimes.of(self.obj).evaluator.frame_cache.frames()

    def test_hidden_frames_are_not_solved(self) -> None:
        """Each was solved in the pose of the last frame that showed it, and stored as final."""
        runtimes.of(self.obj).evaluator.frame_cache.clear()
        key(self.obj, {1: False, 4: True, 9: False})
        sleeve.play(1, 9)
        self.assertEqual(self.frames(), [(1.0, True), (2.0, True), (3.0, True), (9.0, False)])
        self.assertEqual(self.obj.rumple.message, "")

    def test_it_is_seen_again_after_it_was_hidden_and_its_modifier_off(self) -> None:
        """Nothing of it was shown: Blender had forgotten the fine mesh while the coarse one was made anew."""
        self.obj.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.004
        compat.move_modifier(self.obj, len(self.obj.modifiers) - 1, 0)
        nodes_mod = modifier.find(self.obj)
        scheduler.sync_all()
        for _ in range(2):  # then it is written already
            self.obj.hide_viewport = True
            sleeve.at(2)
            self.obj.hide_viewport, nodes_mod.show_viewport = False, False
            sleeve.at(3)
            nodes_mod.show_viewport = True
            bpy.context.view_layer.update()
            sleeve.at(3)
            scheduler.sync_all()
            sleeve.at(3)
            self.assertTrue(sleeve.is_fine(self.obj))
            self.assertEqual(self.obj.rumple.message, "")

    def test_one_that_is_worn_under_another_is_solved(self) -> None:
        """Blender evaluates it for that one's sake."""
        over = sleeve.another("Coat", 1.3)
        over.rumple.body = self.obj
        sleeve.at(2)
        runtimes.of(self.obj).evaluator.frame_cache.clear()
        key(self.obj, {1: False, 4: True, 9: False})
        sleeve.play(1, 9)
        self.assertEqual(self.frames(), [(float(frame), True) for frame in range(1, 10)])

    def test_a_bake_that_begins_hidden(self) -> None:
        """It broke off: nothing is solved at frame 1: see whether its modifier is on"""
        sleeve.play(6, 10)
        live = sleeve.shown(self.obj)
        key(self.obj, {1: True, 6: False})
        self.obj.rumple.bake_end = 10
        bpy.ops.object.rumple_bake()
        for frame in range(1, 11):
            sleeve.at(frame)
            self.assertEqual(self.obj.rumple.message, "")
        self.assertTrue(modifier.plays_clip(modifier.find(self.obj)))
        np.testing.assert_allclose(sleeve.shown(self.obj), live, atol=1e-6)

    def test_a_clip_stands_still_where_it_is_hidden(self) -> None:
        """A shutter that closes behind the last frame that shows it sees it where it was."""
        key(self.obj, {1: False, 4: True, 9: False})
        self.obj.rumple.bake_end = 10
        bpy.ops.object.rumple_bake()
        self.obj.animation_data_clear()
        self.obj.hide_viewport = False
        cache = modifier.cache_object(modifier.find(self.obj))
        seen = {}
        for frame in (3, 5, 8, 9):
            sleeve.at(frame)
            seen[frame] = sleeve.shown(cache)
        np.testing.assert_array_equal(seen[5], seen[3])
        np.testing.assert_array_equal(seen[8], seen[3])
        self.assertGreater(np.abs(seen[9] - seen[3]).max(), 1e-2)

    def test_curves_of_paths_too(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        self.obj.rumple.paths.detail = 2
        bpy.ops.object.rumple_add(method="PATHS")
        bpy.ops.object.rumple_curves_add()
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        key(self.obj, {1: True, 6: False})
        self.obj.rumple.bake_end = 10
        self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
        self.assertIsNotNone(modifier.mesh_cache(path_curves.of(self.obj)[0]))

    def test_a_bake_of_one_that_is_not_shown_at_all_says_so(self) -> None:
        self.obj.hide_viewport = True
        with self.assertRaisesRegex(RuntimeError, "Sleeve: nothing is solved at frame [0-9]+, it is hidden: show it"):
            bpy.ops.object.rumple_bake()


class WhileRendering(unittest.TestCase):
    """What Blender has forgotten is not written to let it be evaluated once more: the depsgraph of a render is being
    evaluated, and in 4.3 a write to that of a viewport meanwhile crashes."""

    def setUp(self) -> None:
        self.obj = small_renders.stage("CYCLES")
        sleeve.at(2)
        mask = self.obj.modifiers.new("Nothing", "MASK")  # as if Blender had forgotten the fine mesh
        mask.vertex_group, mask.threshold = "upper", 1.0
        self.enterContext(mock.patch.object(posed_coarse, "positions", return_value=None))
        self.asked = self.enterContext(mock.patch.object(GarmentReader, "_evaluate_outputs", return_value=True))

    def test_the_viewport_asks_for_it(self) -> None:
        sleeve.at(3)
        self.assertEqual(len(sleeve.shown(self.obj)), 0)
        self.asked.assert_called()

    def test_a_render_does_not(self) -> None:
        seen = []

        def look(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
            seen.append((depsgraph.mode, len(self.obj.evaluated_get(depsgraph).data.vertices)))

        bpy.app.handlers.frame_change_post.append(look)
        self.addCleanup(bpy.app.handlers.frame_change_post.remove, look)
        self.asked.side_effect = lambda *_: self.assertFalse(scheduler.rendering()) or True
        with tempfile.TemporaryDirectory() as folder:
            bpy.context.scene.render.filepath = os.path.join(folder, "still.png")
            bpy.ops.render.render(write_still=True)
        self.assertIn(("RENDER", 0), seen)
        self.assertEqual(self.obj.rumple.message, "")

    def test_nor_does_a_viewport_meanwhile(self) -> None:
        self.asked.reset_mock()
        with mock.patch.object(scheduler, "_render_running", True):
            sleeve.at(4)
        self.assertEqual(len(sleeve.shown(self.obj)), 0)
        self.asked.assert_not_called()


if __name__ == "__main__":
    unittest.main()
