# SPDX-License-Identifier: GPL-3.0-or-later
"""No two objects, or files, share a clip, however they are named."""
from __future__ import annotations

import os
import unittest

import bpy
import numpy as np
from rumple.blender import scheduler
from rumple.blender.bake import clip as clip_bake
from rumple.blender.frame import clip_status
from support import sleeve
from test_clip_faults import Case


class OneName(Case):

    def test_two_objects_never_share_a_clip(self) -> None:
        self.obj.name = "A.001"
        bpy.ops.object.rumple_bake()
        sleeve.at(8)
        before = sleeve.shown(self.obj)
        bpy.ops.object.duplicate()
        other = bpy.context.object
        scheduler.sync_all()
        other.name = "A_001"
        other.rumple.mesh.radius = 3.0
        bpy.ops.object.rumple_bake()
        self.assertNotEqual(clip_status.clip_path(other), clip_status.clip_path(self.obj))
        sleeve.at(8)
        np.testing.assert_array_equal(sleeve.shown(self.obj), before)
        self.assertEqual(self.obj.rumple.message, "")

    def test_a_renamed_object_keeps_its_clip(self) -> None:
        """A clip is named after its object, so one with a former name of another was baked over the clip of that."""
        self.bake()
        first = self.clip(), self.clip().read_bytes()
        sleeve.at(8)
        before = sleeve.shown(self.obj)
        self.obj.name = "Sleeve_old"
        bpy.ops.object.duplicate()
        other = bpy.context.object
        scheduler.sync_all()
        other.name = "Sleeve"
        other.rumple.mesh.radius = 3.0
        for _ in range(2):  # the second bake goes where the first went
            bpy.ops.object.rumple_bake()
            self.assertEqual(first[0].read_bytes(), first[1])
            sleeve.at(8)
            np.testing.assert_array_equal(sleeve.shown(self.obj), before)
        self.assertEqual((self.obj.rumple.message, other.rumple.message), ("", ""))
        self.assertEqual(len(os.listdir(first[0].parent)), 2)
        place = clip_status.clip_path(other)
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_bake()  # to its present name: its former one is free
        self.assertEqual(clip_bake.new_clip_path(other), place)

    def test_a_duplicate_keeps_the_clip_that_both_play(self) -> None:
        self.bake()
        first = self.clip(), self.clip().read_bytes()
        bpy.ops.object.duplicate()
        scheduler.sync_all()
        copy = bpy.context.object
        sleeve.make_active(self.obj)
        self.obj.rumple.mesh.radius = 3.0
        bpy.ops.object.rumple_bake()
        self.assertNotEqual(self.clip(), first[0])
        self.assertEqual((clip_status.clip_path(copy), first[0].read_bytes()), first)

    def test_two_versions_of_a_file_never_share_a_clip(self) -> None:
        # Baking shot_v002 destroyed the bake of shot_v001.
        self.bake()
        first = self.clip().read_bytes(), self.clip()
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "shot_v002.blend"))
        self.obj.rumple.mesh.radius = 3.0
        bpy.ops.object.rumple_bake()
        self.assertNotEqual(self.clip(), first[1])
        self.assertEqual(first[1].read_bytes(), first[0])
        self.reopen()
        sleeve.at(3)
        self.assertEqual((self.obj.rumple.message, self.clip()), ("", first[1]))

    def test_freeing_deletes_no_clip_of_others(self) -> None:
        self.bake()
        clip = self.clip()
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "shot_v002.blend"))
        bpy.ops.object.rumple_bake_free(delete_file=True)
        self.assertTrue(clip.is_file(), "it is the bake of shot_v001")
        self.reopen()
        bpy.ops.object.duplicate()
        scheduler.sync_all()
        bpy.ops.object.rumple_bake_free(delete_file=True)
        self.assertTrue(clip.is_file(), "the original plays it")
        sleeve.make_active(self.obj)
        bpy.ops.object.rumple_bake_free(delete_file=True)
        self.assertFalse(clip.is_file())


if __name__ == "__main__":
    unittest.main()
