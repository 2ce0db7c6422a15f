# SPDX-License-Identifier: GPL-3.0-or-later
"""Publishing: only whole clips, into the folder that is named, whole or not at all."""
from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable
from unittest import mock

import bpy
from rumple.blender.farm import alembic, commands, poses, verify
from rumple.core.files import usd_text
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

    def test_two_garments_never_share_a_file(self) -> None:
        """No file name has the dot of an object's, and many disks do not tell "A" from "a"."""
        for name, other in ((farm_scene.INNER, "A.001"), (farm_scene.OUTER, "A_001"), (farm_scene.FREE, "a_001")):
            bpy.data.objects[name].name = other
        farm_scene.save(self.blend)
        self.run_command("bake", "--frames", "2-3")
        self.assertEqual(self.run_command("publish", "--to", str(self.folder / "out")), 0, self.err)
        files = list((self.folder / "out").iterdir())
        self.assertEqual(len({file.name.casefold() for file in files}), 3)
        self.assertEqual(sorted(name for name in ("A.001", "A_001", "a_001") for file in files
                                if f'rumple_object = "{name}"' in file.read_text()), ["A.001", "A_001", "a_001"])

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

    def test_what_nobody_foresaw_is_said_and_the_others_go_on(self) -> None:
        """It ended the command, with a traceback and without a word of the others."""
        self.run_command("bake")
        with mock.patch.object(usd_text.StageWriter, "_sample", side_effect=KeyError("a")):
            self.assertEqual(self.run_command("publish"), 1)
        self.assertEqual(self.err.count("FAILED: KeyError: 'a'"), 3)
        with mock.patch.object(verify, "verify", side_effect=OSError(13, "", "clips/a")):
            self.assertEqual(self.run_command("bake", "--verify"), 1)
        self.assertEqual(self.err.count("FAILED: nothing can be written to clips/a: change its permissions"), 3)
        with mock.patch.object(poses, "make", side_effect=KeyError("b")):
            self.assertEqual(self.run_command("poses", "--count", "1", "--object", farm_scene.FREE), 1)
        self.assertIn("FAILED: KeyError: 'b'", self.err)

    def test_a_hidden_garment_is_refused(self) -> None:
        """It was published as its bare mesh, which stood still."""
        self.run_command("bake")
        self.run_command("attach")
        commands.open_file(self.blend, False)
        bpy.data.objects[farm_scene.FREE].hide_viewport = True
        farm_scene.save(self.blend)
        for words in (["publish"], ["vat"]):
            self.assertEqual(self.run_command(*words, "--object", farm_scene.FREE), 1)
            self.assertIn("nothing of it is shown at frame 1, it is hidden: show it", self.err)
        self.assertEqual(list((self.folder / "publish").glob("*")), [])
        self.assertEqual((self.run_command("check"), self.run_command("check", "--to-bake")), (0, 1))
        self.assertIn("Scarf/.. a: it is hidden", self.err)


class Alembic(farm_case.Case):
    """Debian's Blenders have no exporter: a stand-in has its interface, and writes what its file begins with."""

    def setUp(self) -> None:
        super().setUp()
        for name in (farm_scene.INNER, farm_scene.FREE):
            bpy.data.objects[name].rumple.bake_samples = 2
        farm_scene.save(self.blend)
        self.run_command("bake", "--frames", "2-4")
        self.asked: list[dict[str, Any]] = []

    def publish(self, write: Callable[[Path], Any], *words: str) -> int:
        def export(**asked: Any) -> None:
            chosen = [obj.name for obj in bpy.context.view_layer.objects if obj.select_get()]
            self.asked.append(dict(asked, chosen=chosen))
            write(Path(asked["filepath"]))
        here = SimpleNamespace(app=SimpleNamespace(alembic=SimpleNamespace(supported=True)),
                               ops=SimpleNamespace(wm=SimpleNamespace(alembic_export=export)))
        with mock.patch.object(alembic, "bpy", here):
            return self.run_command("publish", "--format", "alembic", *words)

    def left(self) -> list[str]:
        folder = self.folder / "publish"
        return sorted(path.name for path in folder.iterdir()) if folder.exists() else []

    def test_a_blender_without_it_says_so_and_writes_nothing(self) -> None:
        self.assertFalse(bpy.app.alembic.supported)  # where one has it, the other tests are to be run with it
        self.assertEqual(self.run_command("publish", "--format", "alembic"), 1)
        self.assertEqual(self.err.count("this Blender was built without Alembic: publish USD"), 3)
        self.assertEqual(self.left(), [])

    def test_each_garment_alone_with_the_samples_of_its_bake(self) -> None:
        self.assertEqual(self.publish(lambda path: path.write_bytes(b"Ogawa\xff\0\1")), 0, self.err)
        self.assertEqual(sorted(found["chosen"] for found in self.asked),
                         sorted([name] for name in (farm_scene.INNER, farm_scene.OUTER, farm_scene.FREE)))
        for found in self.asked:
            samples = 1 if found["chosen"] == [farm_scene.OUTER] else 2
            self.assertEqual([found[word] for word in ("start", "end", "gsamples", "xsamples", "selected", "uvs")],
                             [2, 4, samples, samples, True, True])
        self.assertEqual(len(self.left()), 3)
        for name in self.left():
            self.assertRegex(name, r"^shot-\w+-[0-9a-f]+-2-4\.abc$")

    def test_what_is_not_whole_is_not_left(self) -> None:
        def fails(path: Path) -> None:
            raise RuntimeError("Error: no room\n")
        for write, said in ((lambda path: path.write_bytes(b"Ogawa\0\0\1"), "was not written as a whole"),
                            (lambda path: None, "was not written as a whole"), (fails, "exporter failed: Error: no")):
            self.assertEqual(self.publish(write, "--object", farm_scene.FREE), 1)
            self.assertIn(said, self.err)
            self.assertEqual(self.left(), [])

    def test_what_is_of_usd_is_refused(self) -> None:
        for words in (["--attributes"], ["--scheme", "catmullClark"]):
            self.assertEqual(self.run_command("publish", "--format", "alembic", *words), 2)
            self.assertIn("are of USD", self.err)
