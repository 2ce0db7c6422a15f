# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored frames that are kept on disk: a file that is opened again jumps to the frames it had."""
from __future__ import annotations

import math
import os
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from rumple.blender.frame import disk_frames
from rumple.blender.objects import clip_place, properties, runtimes
from rumple.core.files.kept_frames import KeptFrames
from support import sleeve

LAST = 10


class Kept(unittest.TestCase):
    def setUp(self) -> None:
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.path = os.path.join(place.name, "shot.blend")

    def made(self, method: str = "MESH", keep: bool = True) -> bpy.types.Object:
        obj = sleeve.scene(wrinkles=False)
        obj.rumple.field.output = "GEOMETRY"
        obj.rumple.mesh.density, obj.rumple.mesh.level, obj.rumple.mesh.display_steps = "LEVEL", 1, 0
        for settings in (obj.rumple.mesh, obj.rumple.field, obj.rumple.paths):
            settings.base_cloth = "SWING"
        bpy.ops.object.rumple_add(method=method)
        self.saved()
        obj.rumple.keep_frames = keep
        return obj

    def saved(self) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=self.path)

    def opened(self) -> bpy.types.Object:
        bpy.ops.wm.open_mainfile(filepath=self.path)
        obj = bpy.data.objects["Sleeve"]
        sleeve.make_active(obj)
        return obj

    def played(self, obj: bpy.types.Object) -> dict[int, np.ndarray]:
        found = {}
        for frame in range(1, LAST + 1):
            sleeve.at(frame)
            found[frame] = sleeve.shown(obj)
        return found

    def files(self) -> list[Path]:
        return sorted(Path(self.path).parent.glob("rumple/*.frames/*.frame"))

    def test_the_time_for_writing_is_that_of_all_objects_together(self) -> None:
        """A file of ten garments took ten times as long to save."""
        given: list[float] = []

        class Slow:
            note = ""

            def write(self, seconds: float) -> bool:
                given.append(seconds)
                time.sleep(0.02)
                return len(given) == 1

        with mock.patch.object(disk_frames, "_all", lambda: iter([Slow(), Slow(), Slow()])):
            self.assertTrue(disk_frames._write(0.03))
            self.assertLess(given[1], 0.011)
            self.assertEqual(given[2], 0.0)
            self.assertFalse(disk_frames._write(math.inf))
        self.assertEqual(given[3:], [math.inf] * 3)

    def test_a_jump_in_the_opened_file_shows_what_was_played(self) -> None:
        for method in ("MESH", "FIELD", "PATHS"):
            with self.subTest(method):
                played = self.played(self.made(method))
                self.saved()
                self.assertGreaterEqual(len(self.files()), LAST)
                obj = self.opened()
                for frame in (8, 3, LAST):
                    sleeve.at(frame)
                    self.assertTrue(sleeve.picture(obj).replayed)
                    np.testing.assert_array_equal(sleeve.shown(obj), played[frame])
                self.assertEqual((obj.rumple.message, runtimes.of(obj).unplayed), ("", ""))

    def test_a_jump_behind_a_pose_that_was_changed_since(self) -> None:
        """Play, save, edit, play, save, reopen, jump: it showed the frame from before the edit."""
        obj = self.made()
        upper = bpy.data.objects["Arm"].pose.bones["upper"]
        upper.rotation_mode = "XYZ"
        for frame in range(1, LAST + 1):  # so that a key changes one frame only
            upper.keyframe_insert("rotation_euler", frame=frame)
        old = self.played(obj)
        self.saved()
        upper.rotation_euler.z = 0.2
        upper.keyframe_insert("rotation_euler", frame=3)
        played = self.played(obj)
        self.saved()
        self.assertEqual(len(self.files()), LAST)
        obj = self.opened()
        sleeve.at(8)
        self.assertTrue(sleeve.picture(obj).replayed)
        self.assertEqual(runtimes.of(obj).unplayed, "")
        np.testing.assert_array_equal(sleeve.shown(obj), played[8])
        self.assertGreater(np.abs(played[8] - old[8]).max(), 1e-5)

    def test_another_smoothing_of_the_viewport_reads_the_same_frames(self) -> None:
        """The same is solved: what was kept is not solved again."""
        self.played(self.made())
        self.saved()
        obj = self.opened()
        obj.rumple.viewport_steps = 1
        sleeve.at(LAST)
        before = self.files()
        fine = runtimes.of(obj).evaluator
        self.assertEqual([frame for frame, final in fine.frame_cache.frames() if final], [float(LAST)])
        self.saved()
        self.assertEqual(self.files(), before)

    def test_without_the_option_nothing_is_written(self) -> None:
        self.played(self.made(keep=False))
        self.saved()
        self.assertEqual(self.files(), [])

    def test_other_settings_and_another_mesh_never_show_an_old_frame(self) -> None:
        obj = self.made()
        self.played(obj)
        self.saved()

        def begin_at_2(obj: bpy.types.Object) -> None:
            bpy.context.scene.frame_start = obj.rumple.bake_start = 2

        changes = {
            "a setting": lambda o: setattr(o.rumple.mesh, "radius", 0.3), "slack": lambda o: setattr(
                o.rumple.mesh, "slack", 1.2), "the mesh": lambda o: setattr(o.data.vertices[100].co, "x", 0.31),
            "the unit": lambda o: setattr(bpy.context.scene.unit_settings, "scale_length", 0.5),
            "its level": lambda o: setattr(o.rumple.mesh, "level", 2),
            "paint": lambda o: o.vertex_groups.new(name="Rumple Room").add(range(60), 0.4, "REPLACE"),
            "the first frame": begin_at_2}
        for name, change in changes.items():
            with self.subTest(name):
                obj = self.opened()
                change(obj)
                obj.data.update_tag()
                obj.update_tag()
                bpy.context.view_layer.update()
                sleeve.at(7)
                found = sleeve.shown(obj)
                self.assertFalse(sleeve.picture(obj).replayed)
                with mock.patch.object(KeptFrames, "read", lambda *_: None):  # as without frames on disk
                    runtimes.of(obj).evaluator.frame_cache.clear()
                    sleeve.at(20)
                    runtimes.of(obj).evaluator.frame_cache.clear()
                    sleeve.at(7)
                np.testing.assert_array_equal(found, sleeve.shown(obj))

    def test_another_scene_with_another_rate_and_unit_keeps_its_own(self) -> None:
        obj = self.made()
        played = self.played(obj)
        self.saved()
        self.assertEqual(len(self.files()), LAST)
        other = bpy.data.scenes.new("Second")
        other.collection.objects.link(obj)
        other.render.fps, other.unit_settings.scale_length = 12, 2.0
        other.frame_start, other.frame_end = 1, sleeve.LAST
        self.saved()
        obj = self.opened()
        other = bpy.data.scenes["Second"]
        other.frame_set(5)
        sleeve.at(6)
        np.testing.assert_array_equal(sleeve.shown(obj), played[6])
        self.assertTrue(sleeve.picture(obj).replayed)

    def test_a_damaged_file_is_said_in_a_sentence(self) -> None:
        obj = self.made()
        played = self.played(obj)
        self.saved()
        for path in self.files():
            path.write_bytes(path.read_bytes()[:-20])
        obj = self.opened()
        for frame in range(1, LAST + 1):
            sleeve.at(frame)
            np.testing.assert_array_equal(sleeve.shown(obj), played[frame])
        self.assertIn("damaged", disk_frames.of(obj).note)
        self.assertEqual(obj.rumple.message, "")
        self.saved()
        obj = self.opened()
        sleeve.at(9)
        self.assertTrue(sleeve.picture(obj).replayed)

    def test_a_folder_that_cannot_be_made_is_said_and_the_file_is_saved(self) -> None:
        obj = self.made()
        Path(self.path).parent.joinpath("a file").write_text("of another kind")
        obj.rumple.bake_folder = "//a file"
        self.played(obj)
        self.saved()
        self.assertIn("not kept", disk_frames.of(obj).note)
        obj = self.opened()
        self.assertTrue(obj.rumple.keep_frames)
        sleeve.at(4)
        self.assertEqual(obj.rumple.message, "")

    def test_the_limit_holds(self) -> None:
        obj = self.made()
        self.played(obj)
        kept = disk_frames.of(obj)
        self.assertEqual(kept.limit_bytes, properties.DEFAULT_DISK << 20)
        obj.rumple.disk_limit = 16
        sleeve.at(LAST + 1)
        self.assertEqual(kept.limit_bytes, 16 << 20)
        kept.write()
        size = self.files()[0].stat().st_size
        kept.limit_bytes = 3 * size + 10
        sleeve.at(LAST + 2)
        kept.limit_bytes = 3 * size + 10  # the frame has read the setting again
        kept.write()
        self.assertLessEqual(sum(path.stat().st_size for path in self.files()), 3 * size + 10)

    def test_clearing_the_stored_frames_clears_the_disk(self) -> None:
        obj = self.made()
        self.played(obj)
        self.saved()
        self.assertEqual(len(self.files()), LAST)
        bpy.ops.object.rumple_clear_frames()
        self.assertEqual(self.files(), [])

    def test_a_file_saved_under_another_name_has_its_own(self) -> None:
        obj = self.made()
        self.played(obj)
        self.saved()
        first = clip_place.of(obj)
        self.path = os.path.join(os.path.dirname(self.path), "shot_2.blend")
        self.saved()
        self.assertNotEqual(clip_place.of(obj), first)
        self.assertEqual(len(self.files()), 2 * LAST)
        obj = self.opened()
        sleeve.at(6)
        self.assertTrue(sleeve.picture(obj).replayed)

    def test_an_unsaved_file_keeps_none_and_does_not_complain(self) -> None:
        obj = sleeve.scene()
        obj.rumple.keep_frames = True
        sleeve.play(1, 4)
        self.assertIsNone(disk_frames.of(obj))
        self.assertEqual(obj.rumple.message, "")


if __name__ == "__main__":
    unittest.main()
