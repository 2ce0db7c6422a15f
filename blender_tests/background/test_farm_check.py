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
        with mock.patch("rumple.core.files.clip_folder.can_write", return_value=False):
            self.assertIn("nothing can be written", self.kinds()["folder"])

    def test_a_file_of_a_later_blender(self) -> None:
        newer = mock.Mock(wraps=bpy.data)
        newer.version = (9, 1, 0)
        newer.libraries, newer.objects, newer.node_groups = bpy.data.libraries, bpy.data.objects, bpy.data.node_groups
        with mock.patch.object(check, "bpy", mock.Mock(wraps=bpy, data=newer, app=bpy.app)):
            texts = [finding.text for finding in check._programs()]
        self.assertIn("the file was saved by Blender 9.1", texts[0])

    def test_python_that_was_not_run_makes_another_clip(self) -> None:
        """A clip that was baked with its drivers off was kept by --resume."""
        curve = bpy.data.objects["Arm"].pose.bones["upper"].driver_add("location", 0)
        curve.driver.expression = "sum([0.01 * i for i in (1, 2)])"
        farm_scene.save(self.blend)
        free = ("bake", "--object", farm_scene.FREE)
        self.assertEqual(self.run_command(*free), 0)
        self.assertIn("Python of the file was not run", self.err)
        self.assertEqual(self.run_command(*free, "--resume"), 0)
        self.assertIn("is whole already", self.out)
        self.assertEqual(self.run_command(*free, "--resume", "--enable-autoexec"), 0)
        self.assertNotIn("is whole already", self.out)
        self.assertEqual(self.err, "")

    def test_images_and_simulations_that_move_a_mesh_count(self) -> None:
        """A clip was kept by --resume where the image of its Displace was another one."""
        for name in ("push", "map"):
            image = bpy.data.images.new(name, 4, 4)
            image.filepath_raw, image.file_format = str(self.folder / f"{name}.png"), "PNG"
            image.save()
        texture = bpy.data.textures.new("push", "IMAGE")
        texture.image = bpy.data.images["push"]
        bpy.data.objects["Sleeve"].modifiers.new("Push", "DISPLACE").texture = texture
        cloth = bpy.data.objects["Coat"].modifiers.new("Cloth", "CLOTH")
        cloth.show_viewport = False
        cloth.point_cache.use_external, cloth.point_cache.filepath = True, str(self.folder / "points")
        bpy.data.images["map"].use_fake_user = True
        farm_scene.save(self.blend)
        (self.folder / "points").mkdir()
        for name, counts in (("push.png", True), ("map.png", False), ("points/a_000001_00.bphys", True)):
            before = source.of_files()
            (self.folder / name).write_bytes(b"another")
            self.assertEqual(source.of_files() != before, counts, name)
        for name in ("push.png", "map.png"):
            (self.folder / name).unlink()
        shutil.rmtree(self.folder / "points")
        lacks = {found["text"].rpartition("/")[2]: found["lacks"] for found in self.data("check")["findings"]}
        self.assertEqual(lacks, {"push.png is missing": True, "map.png is missing": False, "points is missing": True})

    def test_a_garment_that_cannot_be_baked(self) -> None:
        farm_scene.break_garment(farm_scene.INNER)
        farm_scene.save(self.blend)
        self.assertIn("is off in the viewport", self.kinds()["garment"])
