# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Time Stretching: frames follow one another, though the animation goes faster or slower."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender.objects import modifier, runtimes
from support import sleeve


class Stretched(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.obj = sleeve.scene()
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder.name, "shot.blend"))

    def stretch(self, old: int, new: int) -> None:
        render = bpy.context.scene.render
        render.frame_map_old, render.frame_map_new = old, new

    def test_each_frame_goes_on_from_the_one_before(self) -> None:
        """What the animation shows was taken for the frame: of 1.11 and 2.22 none is the one before the other."""
        for old, new in ((100, 90), (100, 200), (100, 37)):
            self.stretch(old, new)
            runtimes.of(self.obj).evaluator.frame_cache.clear()
            sleeve.play(1, 8)
            frames = runtimes.of(self.obj).evaluator.frame_cache.frames()
            self.assertEqual(frames, [(float(frame), True) for frame in range(1, 9)])
            self.assertAlmostEqual(runtimes.of(self.obj).inputs.frame_rate, 24.0 * new / old)
            self.assertEqual(self.obj.rumple.message, "")

    def test_twice_as_slow_it_shows_the_same_poses(self) -> None:
        sleeve.at(5)
        posed = runtimes.of(self.obj).inputs.positions.copy()
        self.stretch(100, 200)
        sleeve.at(10)
        np.testing.assert_array_equal(runtimes.of(self.obj).inputs.positions, posed)

    def test_a_bake_is_refused_and_a_clip_that_is_there_is_stretched(self) -> None:
        self.stretch(100, 200)
        with self.assertRaisesRegex(RuntimeError, r"Sleeve: Time Stretching is on \(100 to 200\): bake with both"):
            bpy.ops.object.rumple_bake()
        self.stretch(100, 100)
        bpy.ops.object.rumple_bake()
        shown = {}
        for frame in (3, 5):
            sleeve.at(frame)
            shown[frame] = sleeve.shown(self.obj)
        self.stretch(100, 200)
        for frame, expected in shown.items():
            sleeve.at(2 * frame)
            np.testing.assert_allclose(sleeve.shown(self.obj), expected, atol=1e-6)
            self.assertEqual(self.obj.rumple.message, "")
        self.assertTrue(modifier.plays_clip(modifier.find(self.obj)))


if __name__ == "__main__":
    unittest.main()
