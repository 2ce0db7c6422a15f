# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker lacks is said in words, each with its kind for machines; where nothing is, the exit code is 0."""
from __future__ import annotations

import shutil
from unittest import mock

import bpy
from rumple.blender.farm import check, commands, source
from rumple.blender.nodes import wrinkle_tree
from support import farm_case, farm_scene


class Check(farm_case.Case):

    def kinds(self, *words: str) -> dict[str, str]:
        """Text of what is lacking, by kind."""
        return {found["kind"]: found["text"] for found in self.data("check", *words)["findings"] if found["lacks"]}

    def test_nothing_is_lacking(self) -> None:
        self.assertEqual(self.run_command("check"), 0)
        self.assertIn("nothing is lacking for 3 wrinkled objects", self.out)
        self.assertEqual(self.err, "")

    def test_files_that_are_missing(self) -> None:
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "rig.blend"), copy=True)
        with bpy.data.libraries.load(str(self.folder / "rig.blend"), link=True) as (_, here):
            here.objects = ["Arm"]
        bpy.context.scene.collection.objects.link(here.objects[0])
        image = bpy.data.images.new("cloth", 4, 4)
        image.source, image.filepath, image.use_fake_user = "FILE", "//cloth.png", True
        cache = bpy.data.objects["Sleeve"].modifiers.new("Points", "MESH_CACHE")
        cache.filepath, cache.show_viewport, cache.cache_format = "//points.pc2", False, "PC2"
        farm_scene.save(self.blend)
        self.assertIn("points.pc2 is missing", self.kinds()["cache"])
        (self.folder / "rig.blend").unlink()
        found = {entry["kind"]: entry for entry in self.data("check")["findings"]}
        self.assertIn("rig.blend is missing: everything from it is too", found["linked"]["text"])
        self.assertFalse(found["image"]["lacks"])
        self.assertEqual(self.run_command("check"), 1)

    def test_what_rests_on_a_file_counts_wherever_the_files_lie(self) -> None:
        """They were put together by their paths, whose order another system may have otherwise: nothing was resumed."""
        for name in ("a", "b"):
            bpy.data.objects["Arm"].location.x = ord(name)
            bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / f"{name}.blend"), copy=True)
            with bpy.data.libraries.load(str(self.folder / f"{name}.blend"), link=True) as (_, here):
                here.objects = ["Arm"]
            bpy.context.scene.collection.objects.link(here.objects[0])
        before = source.of_files()
        (self.folder / "a.blend").rename(self.folder / "c.blend")
        self.assertNotEqual(source.of_files(), before)
        next(library for library in bpy.data.libraries if "a.blend" in library.filepath).filepath = "//c.blend"
        self.assertEqual(source.of_files(), before)

    def test_a_file_is_missing_once_however_its_path_is_written(self) -> None:
        """Blender writes slashes where Python on Windows has backslashes."""
        self.run_command("bake")
        self.run_command("attach")
        clip = self.clip(farm_scene.FREE)
        clip.unlink()
        with mock.patch.object(bpy.utils, "blend_paths", return_value=[f"{clip.parent}/./{clip.name}"]):
            found = self.data("check")["findings"]
        self.assertEqual([finding["kind"] for finding in found], ["clip"])

    def test_clips_that_are_stale_damaged_or_gone(self) -> None:
        self.run_command("bake")
        self.run_command("attach")
        self.assertEqual(self.run_command("check"), 0)
        clip = self.clip(farm_scene.FREE)
        good = clip.read_bytes()
        clip.write_bytes(good[:-100])
        self.assertIn("cut short", self.kinds()["clip"])
        clip.unlink()
        self.assertIn("is missing", self.kinds()["clip"])
        clip.write_bytes(good)
        commands.open_file(self.blend, False)
        bpy.data.objects[farm_scene.FREE].rumple.mesh.bending = 0.2
        farm_scene.save(self.blend)
        self.assertIn("changed since the bake", self.kinds()["clip"])
        # Else no queue would ever bake it again.
        self.assertEqual((self.run_command("check"), self.run_command("check", "--to-bake")), (1, 0))
        self.assertEqual(self.kinds("--object", farm_scene.INNER), {})

    def test_programs_disk_and_folder(self) -> None:
        with mock.patch.object(check.lib, "open", side_effect=check.NativeMissing("This installation cannot run")):
            self.assertEqual(self.kinds()["library"], "This installation cannot run")
        with mock.patch.object(wrinkle_tree, "VERSION", 1), mock.patch("rumple.blender.scheduler.sync_all"):
            self.assertIn("made by a later Rumple", self.kinds().get("addon", ""))
        with mock.patch("shutil.disk_usage", return_value=shutil._ntuple_diskusage(10, 10, 1000)):
            self.assertRegex(self.kinds()["disk"], r"need about 0\.\d MB, and the disk of .* has 0\.0 MB left")
        taken = self.folder / "taken"
        taken.write_text("a file")
        self.assertIn("is no folder", self.kinds("--out", str(taken / "x"))["folder"])
        with mock.patch("rumple.core.clip_folder.can_write", return_value=False):
            self.assertIn("nothing can be written", self.kinds()["folder"])

    def test_a_file_of_a_later_blender(self) -> None:
        newer = mock.Mock(wraps=bpy.data)
        newer.version = (9, 1, 0)
        newer.libraries, newer.objects, newer.node_groups = bpy.data.libraries, bpy.data.objects, bpy.data.node_groups
        with mock.patch.object(check, "bpy", mock.Mock(wraps=bpy, data=newer, app=bpy.app)):
            texts = [finding.text for finding in check._programs()]
        self.assertIn("the file was saved by Blender 9.1", texts[0])

    def test_a_garment_that_cannot_be_baked(self) -> None:
        farm_scene.break_garment(farm_scene.INNER)
        farm_scene.save(self.blend)
        self.assertIn("is off in the viewport", self.kinds()["garment"])
