# SPDX-License-Identifier: GPL-3.0-or-later
"""Publishing: only whole clips, into the folder that is named, whole or not at all."""
from __future__ import annotations

from unittest import mock

import bpy
from rumple.blender.farm import commands
from rumple.core import usd_text
from support import farm_case, farm_scene


class Publish(farm_case.Case):

    def test_without_a_whole_clip_nothing_is_published(self) -> None:
        self.assertEqual(self.run_command("publish"), 1)
        self.assertEqual(self.err.count("there is no whole clip of this file: bake first"), 3)
        self.assertFalse((self.folder / "publish").exists())

    def test_each_garment_is_a_file_of_its_own_in_that_folder(self) -> None:
        self.run_command("bake", "--frames", "2-4")
        data = self.data("publish", "--scheme", "catmullClark", "--to", str(self.folder / "out"))
        self.assertEqual({name: found["frames"] for name, found in data["garments"].items()},
                         {farm_scene.INNER: 3, farm_scene.OUTER: 3, farm_scene.FREE: 3})
        files = sorted((self.folder / "out").iterdir())
        self.assertEqual(len(files), 3)
        text = next(file for file in files if "Scarf" in file.name).read_text()
        self.assertIn('def Xform "Scarf____a"', text)
        self.assertIn('string rumple_object = "Scarf/.. a"', text)
        self.assertIn('subdivisionScheme = "catmullClark"', text)
        self.assertNotIn("normals", text)

    def test_no_two_uv_maps_have_one_name(self) -> None:
        self.assertEqual(usd_text.uv_names(["UV.1", "UV_1", "st", "UV 1"]), ["st", "UV_1", "st_1", "UV_1_1"])

    def test_a_changing_number_of_points_and_a_full_disk_leave_nothing(self) -> None:
        self.run_command("bake")
        self.run_command("attach")
        commands.open_file(self.blend, False)
        build = bpy.data.objects[farm_scene.FREE].modifiers.new("Build", "BUILD")
        build.frame_start, build.frame_duration = -4, 8
        farm_scene.save(self.blend)
        self.assertEqual(self.run_command("publish", "--object", farm_scene.FREE), 1)
        self.assertRegex(self.err, "changes its number of points at frame 2")
        with mock.patch.object(usd_text.StageWriter, "_sample", side_effect=OSError(28, "")):
            self.assertEqual(self.run_command("publish", "--object", farm_scene.INNER), 1)
        self.assertIn("is full: make room", self.err)
        self.assertEqual(list((self.folder / "publish").iterdir()), [])
