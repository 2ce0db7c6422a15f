# SPDX-License-Identifier: GPL-3.0-or-later
"""A wrinkled object that follows another wrinkled one: a cuff over the sleeve."""
from __future__ import annotations

import contextlib
import io
import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.frame import clip_status
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import runtimes
from rumple.blender.ui import panels
from support import sleeve

FRAMES = (2, 6, 7, 15, 20)


class Follower:

    follow: str

    def setUp(self) -> None:
        self.sleeve = sleeve.scene()
        self.cuff = self.follower("Cuff")
        scheduler.sync_all()

    def follower(self, name: str) -> bpy.types.Object:
        return sleeve.cuff(self.sleeve, self.follow, name)

    def pose(self) -> np.ndarray:
        """The coarse cuff as the second pass has it."""
        count = len(self.cuff.data.vertices)
        return sleeve.attribute(self.cuff, wrinkle_tree.BASE_POSITION)[:count]

    def solved_for(self) -> np.ndarray:
        return runtimes.of(self.cuff).inputs.positions

    def settled(self, frame: int) -> np.ndarray:
        sleeve.at(frame)
        sleeve.at(frame)
        return sleeve.shown(self.cuff)

    def test_a_frame_set_twice_is_solved_for_the_sleeve_that_is_shown(self) -> None:
        for frame in FRAMES:
            seen = self.settled(frame)
            np.testing.assert_array_equal(self.solved_for(), self.pose())
            np.testing.assert_allclose(seen, sleeve.picture(self.cuff).positions, atol=1e-6)
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.shown(self.cuff), seen)
        self.assertEqual(self.cuff.rumple.message, "")

    def test_a_frame_set_once_has_the_right_pose_and_only_its_folds_are_late(self) -> None:
        # Blender evaluates both, calls the handler, which solves both, and evaluates both again: the sleeve is right
        # then, and so is the coarse cuff on it; the folds of the cuff are for the cuff of the first pass.
        late = 0.0
        for frame in FRAMES:
            sleeve.at(frame)
            pose, under, solved = self.pose(), sleeve.shown(self.sleeve), self.solved_for()
            self.settled(frame)
            np.testing.assert_array_equal(self.pose(), pose)
            np.testing.assert_array_equal(sleeve.shown(self.sleeve), under)
            late = max(late, float(np.abs(solved - pose).max()))
        self.assertGreater(late, 1e-4)  # else Blender has learnt to ask three times, and the warnings can go

    def test_the_sleeve_does_not_know_that_it_is_followed(self) -> None:
        seen = {}
        for frame in FRAMES:
            sleeve.at(frame)
            seen[frame] = sleeve.shown(self.sleeve)
        sleeve.scene()
        for frame in FRAMES:
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.shown(bpy.data.objects["Sleeve"]), seen[frame])

    def test_the_order_of_names_does_not_matter(self) -> None:
        self.settled(6)
        seen = self.settled(7)
        self.sleeve = sleeve.scene()
        self.cuff = self.follower("Zzz")
        scheduler.sync_all()
        self.settled(6)
        np.testing.assert_array_equal(self.settled(7), seen)

    def test_a_bake_is_not_late(self) -> None:
        sleeve.play()  # the sleeve is the same from here on
        bpy.ops.object.rumple_clear_frames()
        right = {frame: self.settled(frame) for frame in range(1, sleeve.LAST + 1)}
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "scene.blend"))
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
            for frame in FRAMES:
                sleeve.at(frame)
                np.testing.assert_allclose(sleeve.shown(self.cuff), right[frame], atol=1e-6, err_msg=f"frame {frame}")

    def test_that_renders_are_late_is_said_until_it_is_baked(self) -> None:
        sleeve.at(3)
        self.assertIn("Bake it", " ".join(text for text, _icon in panels.status_lines(self.cuff)))
        self.assertIn("Cuff: it follows Sleeve", self.said_before_a_render())
        with tempfile.TemporaryDirectory() as folder:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "scene.blend"))
            bpy.ops.object.rumple_bake()
            self.assertEqual(self.said_before_a_render(), "")

    def said_before_a_render(self) -> str:
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            clip_status.check_before_render()
        return said.getvalue()


class Shrinkwrapped(Follower, unittest.TestCase):
    follow = "SHRINKWRAP"


class SurfaceDeformed(Follower, unittest.TestCase):
    follow = "SURFACE_DEFORM"


if __name__ == "__main__":
    unittest.main()
