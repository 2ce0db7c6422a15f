# SPDX-License-Identifier: GPL-3.0-or-later
"""The command without a window: all or those that are named, locked, verified. test_farm_ended.py: ended and resumed.
"""
from __future__ import annotations

import json
import os
import shutil
import sys
import time
from pathlib import Path
from unittest import mock

import bpy
from rumple.blender.farm import bake, command, commands, source
from rumple.blender.objects import modifier
from rumple.core.files import attached_files, clip_file, clip_folder
from support import farm_scene, sleeve
from support.farm_case import FRAMES, Case


class Bakes(Case):

    def test_a_garment_is_baked_after_those_it_rests_on_and_one_by_one_gives_the_same_bits(self) -> None:
        self.assertEqual(self.run_command("bake"), 0)
        order = [line.split(":")[1].strip() for line in self.out.splitlines() if " ms a sample" in line]
        self.assertLess(order.index(farm_scene.INNER), order.index(farm_scene.OUTER))
        self.assertEqual(len(order), 3)
        self.assertEqual([row["name"] for row in json.loads(bpy.context.scene.rumple_bake_order)], order)
        together = self.read_all()
        self.assertEqual(len(together), 3)
        shutil.rmtree(self.clips)
        for name in order:
            self.assertEqual(self.run_command("bake", "--object", name), 0)
        self.assertEqual(self.read_all(), together)
        self.assertEqual(self.run_command("bake", "--resume"), 0)
        self.assertEqual(self.out.count("is whole already"), 3)
        # The coat rests on the clip, not on live cloth: that is another surface.
        self.clip(farm_scene.INNER).unlink()
        self.assertEqual(self.run_command("bake", "--object", farm_scene.OUTER), 0)
        self.assertIn("of which there is no clip", self.out)
        self.assertNotEqual(self.read_all()[self.clip(farm_scene.OUTER).name],
                            together[self.clip(farm_scene.OUTER).name])

    def test_what_fails_is_named_what_rests_on_it_is_left_and_the_others_go_on(self) -> None:
        farm_scene.break_garment(farm_scene.INNER)
        farm_scene.save(self.blend)
        self.assertEqual(self.run_command("bake"), 1)
        self.assertIn("Sleeve FAILED: nothing is solved at frame 1: see whether its modifier is on", self.err)
        self.assertIn("Coat FAILED: it rests on Sleeve, which was not baked", self.err)
        self.assertEqual(list(self.read_all()), [self.clip(farm_scene.FREE).name])

    def test_names_and_folders_lead_nowhere_else(self) -> None:
        out = self.folder / "deep" / "x"
        self.assertEqual(self.run_command("bake", "--out", str(out), "--frames", "2-3"), 0)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["deep", "shot.blend"])
        self.assertEqual(len(list(out.iterdir())), 3)
        self.assertEqual(self.data("bake", "--out", str(out), "--frames", "2-3", "--resume")["garments"]
                         [farm_scene.FREE]["samples"], 2)
        # Alone it finds what it rests on there, too, and no more of its frames.
        together = self.read_all(out)
        words = ("bake", "--out", str(out), "--object", farm_scene.OUTER, "--frames")
        self.assertEqual(self.run_command(*words, "2-3"), 0)
        self.assertEqual(self.read_all(out), together)
        self.assertEqual(self.run_command(*words, "2-4"), 1)
        self.assertIn("it rests on Sleeve, whose clip has frames 2 to 3 only", self.err)

    def test_frames_below_zero(self) -> None:
        self.assertEqual(self.run_command("bake", "--frames", "-2--1", "--object", farm_scene.FREE), 0, self.err)
        self.assertEqual(self.data("bake", "--resume", "--object", farm_scene.FREE, "--frames", "-2-1")["garments"]
                         [farm_scene.FREE]["samples"], 4)
        self.assertEqual([command.frames_of(text) for text in ("1-250", "-5-20", "-5--2", "12", "-3")],
                         [(1, 250), (-5, 20), (-5, -2), (12, 12), (-3, -3)])

    def test_words_that_cannot_be_followed(self) -> None:
        for code, said, words in (
                (2, "there is no file", ["bake"]), (2, "before the first", ["bake", "--frames", "5-2"]),
                (2, "frames are A-B, not x", ["bake", "--frames", "x"]), (2, "invalid choice", ["boil"]),
                (2, "'X' is no wrinkled object of this scene; there is: Coat, Scarf/.. a, Sleeve",
                 ["bake", "--object", "X"])):
            here, self.blend = self.blend, self.folder / ("none" if "no file" in said else "shot.blend")
            self.assertEqual(self.run_command(*words), code, words)
            self.assertIn(said, self.err)
            self.blend = here
        broken = self.folder / "broken.blend"
        broken.write_bytes(b"BLENDER-v304" + bytes(100))
        self.blend = broken
        self.assertEqual(self.run_command("bake"), 2)
        sleeve.empty_file()
        self.blend = self.folder / "bare.blend"
        farm_scene.save(self.blend)
        self.assertEqual(self.run_command("bake"), 3)
        self.assertIn("no wrinkled objects", self.err)
        self.assertFalse(self.clips.exists())

    def test_a_clip_that_cannot_be_written_leaves_nothing(self) -> None:
        taken = self.folder / "taken"
        taken.write_text("a file")
        self.assertEqual(self.run_command("bake", "--out", str(taken)), 1)
        self.assertIn("is no folder, or leads through a file", self.err)
        with mock.patch("shutil.disk_usage", return_value=shutil._ntuple_diskusage(10, 10, 1000)):
            self.assertEqual(self.run_command("bake"), 1)
        self.assertIn("make room, or choose another folder", self.err)
        self.assertFalse(self.clips.exists())

    def test_attached_clips_are_shown_by_the_saved_file(self) -> None:
        self.assertEqual(self.run_command("attach"), 1)
        self.assertIn("there is no whole clip", self.err)
        self.run_command("bake")
        other = self.folder / "baked.blend"
        before = self.blend.read_bytes()
        self.assertEqual(self.run_command("attach", "--save-as", str(other)), 0)
        self.assertTrue(self.blend.read_bytes() == before)
        commands.open_file(other, False)
        for name in (farm_scene.INNER, farm_scene.OUTER, farm_scene.FREE):
            self.assertTrue(modifier.plays_clip(modifier.find(bpy.data.objects[name])))
        # What the command line says is not saved.
        self.assertEqual(self.run_command("bake", "--out", str(self.folder / "x"), "--frames", "2-3"), 0)
        self.assertEqual(self.run_command("attach", "--out", str(self.folder / "x"), "--frames", "2-3"), 0)
        about = bpy.data.objects[farm_scene.INNER].rumple
        self.assertEqual((about.bake_start, about.bake_end, about.bake_folder), (1, FRAMES, ""))
        self.assertEqual(self.run_command("check"), 0)


class Attached(Case):
    """`attach` saves the file, so its bytes are others than those that the clips were baked from. They are told by
    their digest: what was attached was of another file from then on, and was baked anew."""

    def test_a_file_that_was_attached_has_its_clips(self) -> None:
        self.run_command("bake")
        before, unattached = self.clip_bytes(), self.blend.read_bytes()
        for _ in range(2):
            self.assertEqual(self.run_command("attach"), 0, self.err)
            self.assertFalse(self.blend.read_bytes() == unattached)
        self.assertEqual(self.run_command("bake", "--resume"), 0)
        self.assertEqual(self.out.count("is whole already"), 3, self.out)
        # What rests on another one finds its clip.
        self.assertEqual(self.run_command("bake", "--object", farm_scene.OUTER), 0)
        self.assertNotIn("of which there is no clip", self.out)
        self.assertEqual(self.clip_bytes(), before)
        # Where it lies does not count, as for any file.
        copied = self.blend.read_bytes()
        self.blend.unlink()
        self.blend.write_bytes(copied)
        self.assertEqual(self.data("bake", "--resume")["garments"][farm_scene.OUTER]["was_whole"], True)

    def test_what_was_saved_since_is_another_file(self) -> None:
        self.run_command("bake")
        self.run_command("attach")
        commands.open_file(self.blend, False)
        bpy.data.objects["Arm"].location.x += 0.1
        farm_scene.save(self.blend)
        self.assertEqual(self.run_command("attach"), 1)
        self.assertEqual(self.err.count("there is no whole clip"), 3)
        garments = self.data("bake", "--resume")["garments"]
        self.assertEqual([about["was_whole"] for about in garments.values()], [False] * 3)

    def test_a_note_that_is_damaged_or_cannot_be_written_only_bakes_again(self) -> None:
        self.run_command("bake")
        with mock.patch.object(attached_files, "write_note", side_effect=OSError(28, "")):
            self.assertEqual(self.run_command("attach"), 0)
        self.assertIn("is full: make room", self.err)
        self.assertEqual(self.run_command("bake"), 0)
        self.assertEqual(self.run_command("attach"), 0)
        (note,) = self.clips.glob(".attached-*")
        good = note.read_text()
        for text in ("", good[:-1], good + "0", "x" * len(good), "\u00e9"):
            note.write_text(text, encoding="utf-8")
            self.assertEqual(source.of_file(self.blend), source.content(self.blend), text)
        note.write_text(good)
        self.assertEqual(source.of_file(self.blend).hex(), good)
        self.blend.unlink()
        self.assertEqual(source.of_file(self.blend), b"none")

    def clip_bytes(self) -> dict[str, str]:
        return {name: digest for name, digest in self.read_all().items() if name.endswith(".pc2")}


class Locked(Case):

    def setUp(self) -> None:
        super().setUp()
        self.run_command("bake")
        self.before = self.read_all()
        self.lock = self.clips / f".{self.clip(farm_scene.FREE).name}.lock"

    def hold(self, **holder: object) -> None:
        self.lock.write_text(json.dumps(dict(host=clip_folder.HOST, process=os.getppid(), started="", task="")
                                        | holder))

    def test_another_worker_is_named_and_keeps_its_clip(self) -> None:
        self.hold(host="node_7", process=4711, task="slurm 12_3")
        with mock.patch.dict(os.environ, RUMPLE_TASK="slurm 12_4"):
            self.assertEqual(self.run_command("bake", "--resume", "--object", farm_scene.FREE), 75)
        self.assertRegex(self.err, r"is being baked by process 4711 on node_7 \(task slurm 12_3\), last heard of \d+ s")
        self.lock.unlink()
        self.assertEqual(self.read_all(), self.before)

    def test_a_lock_that_nobody_holds_is_taken_over(self) -> None:
        old = time.time() - 601.0
        holders = [(dict(process=1 << 29), None), (dict(started="long ago"), None), (dict(host="node_7"), old),
                   (dict(host="node_7", task="slurm 12_3"), None)]
        if sys.platform == "linux" and not Path("/proc/self/stat").exists():  # else nothing tells when it started
            del holders[1]
        for holder, touched in holders:
            self.hold(**holder)
            if touched is not None:
                os.utime(self.lock, (touched, touched))
            with mock.patch.dict(os.environ, RUMPLE_TASK="slurm 12_3"):
                self.assertEqual(self.run_command("bake", "--object", farm_scene.FREE), 0, holder)
            self.assertEqual(self.read_all(), self.before)

    def test_who_lost_its_lock_leaves_the_clip_alone(self) -> None:
        step = bake.FarmBake.step

        def lose(running: bake.FarmBake) -> bool:
            self.hold(host="node_7")
            return step(running)

        with mock.patch.object(bake.FarmBake, "step", lose):
            self.assertEqual(self.run_command("bake", "--object", farm_scene.FREE), 75)
        self.assertIn("was taken over by process", self.err)
        self.lock.unlink()
        self.assertEqual(self.read_all(), self.before)


class Verified(Case):

    def harm(self, name: str, sample: int, checksums: bool) -> None:
        """One bit of a sample; the checksum says so or does not."""
        clip = self.clip(name)
        manifest = clip_file.read_manifest(clip)
        data = bytearray(clip.read_bytes())
        place, length = clip_file.HEADER_BYTES + sample * manifest.points * 12, manifest.points * 12
        data[place + 1] ^= 1
        if checksums:
            writer = clip_file.SampleWriter(clip, manifest)
            manifest.checksums.clear()
            for number in range(manifest.sample_count):
                start = clip_file.HEADER_BYTES + number * length
                writer.add_points(clip_file.np.frombuffer(bytes(data[start:start + length]), "<f4").reshape(-1, 3))
            writer.seal()
            writer.commit()
        else:
            clip.write_bytes(data)

    def test_the_first_frame_that_differs_is_named(self) -> None:
        self.run_command("bake")
        self.assertEqual(self.run_command("bake", "--verify"), 0)
        self.assertEqual(self.out.count(f"{FRAMES} samples were solved again"), 3)
        for name in (farm_scene.OUTER, farm_scene.FREE):
            self.harm(name, 4, True)
            self.assertEqual(self.run_command("bake", "--verify", "--object", name), 4)
            self.assertIn(f"{name}: frame 5 is the first that differs from the clip, by at most ", self.err)
            self.assertEqual(self.run_command("bake", "--verify", "2", "--object", name), 0)  # the first and the last
        self.harm(farm_scene.FREE, 2, False)
        self.assertEqual(self.data("bake", "--verify", "--object", farm_scene.FREE)["garments"][farm_scene.FREE],
                         dict(code=4, compared=2, frame=3.0, farthest=0.0, damaged=True))
        self.clip(farm_scene.FREE).unlink()
        self.assertEqual(self.run_command("bake", "--verify", "--object", farm_scene.FREE), 1)
        self.assertIn("bake first", self.err)
