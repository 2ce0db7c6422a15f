# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake will take is said before it is begun, by what was measured."""
from __future__ import annotations

import unittest
from unittest import mock

import bpy
from rumple.blender.bake import duration, operators, panel
from rumple.blender.objects import runtimes
from support import sleeve


class Duration(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene()

    def said(self) -> list[str]:
        """By the panel."""
        with mock.patch.object(panel, "draw_note") as note:
            panel.DATA_PT_rumple_bake.draw(mock.MagicMock(), bpy.context)
        return [call.args[1] for call in note.call_args_list if " takes about " in call.args[1]]

    def test_it_is_that_of_the_last_solved_frame_times_those_to_be_solved(self) -> None:
        self.obj.rumple.bake_end = 100_000
        runtimes.of(self.obj).frame_seconds = 0.0
        self.assertEqual(self.said(), [])  # nothing is known
        sleeve.play(1, 3)
        took = runtimes.of(self.obj).frame_seconds
        self.assertGreater(took, 0.0)
        self.assertEqual(self.said(), [
            f"A bake takes about {duration.in_words(100_000 * took)}, as the last frame took"])
        runtimes.of(self.obj).frame_seconds = 0.1
        self.obj.rumple.bake_start, self.obj.rumple.bake_end, self.obj.rumple.bake_samples = 101, 200, 2
        bpy.context.scene.frame_start = 1
        self.assertEqual(self.said(), ["A bake takes about 30 s, as the last frame took"])
        self.obj.rumple.bake_start = self.obj.rumple.bake_end = 1
        self.assertEqual(self.said(), [])  # a moment

    def test_what_is_not_solved_in_a_frame_does_not_count(self) -> None:
        sleeve.play(1, 3)
        runtimes.of(self.obj).frame_seconds = 7.0
        sleeve.at(2)  # a stored one
        self.obj.rumple.mesh.radius = 0.3
        bpy.context.view_layer.update()  # between frames
        self.assertEqual(runtimes.of(self.obj).frame_seconds, 7.0)
        sleeve.at(4)
        self.assertNotEqual(runtimes.of(self.obj).frame_seconds, 7.0)

    def test_all_of_the_scene(self) -> None:
        other = sleeve.another("Other", 1.5)
        sleeve.play(1, 2)
        for obj, seconds in ((self.obj, 1.0), (other, 0.5)):
            runtimes.of(obj).frame_seconds = seconds
            obj.rumple.bake_end = 20
        self.assertEqual(self.said(), ["A bake takes about 10 s, as the last frame took",
                                       "Bake All takes about 30 s, as the last frames took"])

    def test_what_is_left_of_one_that_runs(self) -> None:
        self.assertEqual(duration.left(0.0, 0, 100), "")
        self.assertEqual(duration.left(20.0, 10, 100), "3 min")
        self.assertEqual(duration.left(20.0, 99, 100), "")
        bake = mock.Mock(_began=0.0, every=False, _running=mock.Mock(done=10, playback=mock.Mock(count=100)))
        with mock.patch.object(operators.time, "perf_counter", return_value=20.0):
            context = mock.Mock()
            operators.OBJECT_OT_rumple_bake._show_progress(bake, context)
        bake.show_status.assert_called_with(
            context, "Baking wrinkles: 10 of 100 samples, about 3 min left. Esc cancels")

    def test_words(self) -> None:
        for seconds, text in ((8.26, "8.3 s"), (43.0, "43 s"), (119.0, "120 s"), (121.0, "2 min"), (7400.0, "2.1 h"),
                              (720_000.0, "200 h")):
            self.assertEqual(duration.in_words(seconds), text)


if __name__ == "__main__":
    unittest.main()
