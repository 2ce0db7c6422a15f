# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame range of a bake follows the scene's until it is edited, or a bake was made."""
from __future__ import annotations

import os
import tempfile
import unittest
from pathlib import Path

import bpy
from rumple.blender import scheduler
from rumple.blender.frame import clip_status
from rumple.blender.objects import runtimes, units
from support import sleeve


class Range(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "shot.blend")
        self.obj = sleeve.scene()
        self.scene = bpy.context.scene
        self.about = self.obj.rumple

    def set_scene(self, start: int, end: int) -> None:
        self.scene.frame_start, self.scene.frame_end = start, end

    def reopened(self) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        bpy.ops.wm.open_mainfile(filepath=self.path)
        self.obj, self.scene = bpy.data.objects["Sleeve"], bpy.context.scene
        self.about = self.obj.rumple

    def range(self) -> tuple[int, int]:
        return units.bake_range(self.obj, self.scene)

    def first(self) -> int:
        return units.first_frame(self.obj, self.scene)

    def final_frames(self) -> list[float]:
        return [frame for frame, final in runtimes.of(self.obj).evaluator.frame_cache.frames() if final]

    def kept(self) -> int:
        return len(list(Path(self.path).parent.glob("rumple/*.frames/*.frame")))

    def test_it_follows_the_scene(self) -> None:
        self.assertEqual((self.range(), self.first()), ((1, 20), 1))
        self.set_scene(1001, 1010)
        self.assertEqual((self.range(), self.first()), ((1001, 1010), 1001))
        sleeve.play(1001, 1004)
        self.assertEqual(self.final_frames(), [1001.0, 1002.0, 1003.0, 1004.0])
        self.assertEqual(runtimes.of(self.obj).unplayed, "")
        self.set_scene(0, 3)
        self.assertEqual((self.range(), self.first()), ((0, 3), 0))

    def test_stored_frames_are_kept_on_disk_there(self) -> None:
        """None was: none was final."""
        self.about.keep_frames = True
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        self.set_scene(1001, 1010)
        before = self.kept()
        sleeve.play(1001, 1004)
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        self.assertEqual(self.kept() - before, 4)

    def test_a_part_of_it_is_no_other_clip(self) -> None:
        """Also of a range that came after the click."""
        for first, last in ((1, 20), (1001, 1010)):
            self.set_scene(first, last)
            scheduler.sync_all()    # in a window the timer does
            self.set_scene(last - 3, last - 1)
            self.assertEqual((self.range(), self.first()), ((last - 3, last - 1), first))
            scheduler.sync_all()
            self.reopened()
            self.assertEqual(self.first(), first)
        self.about.bake_scene_range = False
        self.about.bake_scene_range = True
        self.assertEqual(self.first(), self.scene.frame_start)

    def test_who_edits_it_has_a_range_of_his_own(self) -> None:
        self.set_scene(5, 30)
        self.about.bake_end = 12
        self.set_scene(1, 40)
        self.assertEqual((self.range(), self.about.bake_scene_range), ((5, 12), False))
        self.about.bake_scene_range = True
        self.assertEqual(self.range(), (1, 40))
        self.about.bake_start = 3
        self.assertEqual(self.range(), (3, 40))

    def test_a_click_leaves_a_range_that_was_edited(self) -> None:
        self.about.bake_start = 7
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual(self.range(), (7, 20))

    def test_after_a_bake_it_stays(self) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        self.set_scene(3, 6)
        self.about.bake_scene_range = False
        self.about.bake_scene_range = True
        bpy.ops.object.rumple_bake()
        about = clip_status.manifest(clip_status.clip_path(self.obj))
        self.assertEqual((about.start, about.end), (3, 6))
        self.set_scene(1, 20)
        self.assertEqual(self.range(), (3, 6))

    def test_after_the_bake_of_a_part_the_clip_still_begins_before_it(self) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=self.path)
        self.set_scene(3, 6)
        bpy.ops.object.rumple_bake()
        self.assertEqual(self.first(), 1)
        self.set_scene(1, 20)
        self.assertEqual(self.range(), (1, 20))

    def test_a_file_of_an_older_rumple_keeps_its_range(self) -> None:
        self.about.bake_start, self.about.bake_end = 2, 9
        self.about.property_unset("bake_scene_range")   # no such property was in it
        self.about.property_unset("bake_known_range")
        self.set_scene(30, 40)
        scheduler.sync_all()
        self.reopened()
        sleeve.at(31)
        self.assertEqual((self.range(), self.first()), ((2, 9), 2))


if __name__ == "__main__":
    unittest.main()
