# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip in pieces. The law: joined, it is byte for byte the one that one worker bakes where frames are independent or
the pre-roll is as long as the clip; else no farther from it than was asked, and --verify knows how it was made."""
from __future__ import annotations

import os
import re
from unittest import mock

import bpy
from rumple.blender.farm import bake, commands, pieces, source
from rumple.core.files import clip_file
from support import farm_scene, sleeve
from support.farm_case import FRAMES, Case

FREE, INNER, OUTER = farm_scene.FREE, farm_scene.INNER, farm_scene.OUTER


class Pieces(Case):

    def whole(self, name: str) -> bytes:
        """Of one worker; then it is gone."""
        for garment in (INNER, name):
            self.assertEqual(self.run_command("bake", "--resume", "--object", garment), 0, self.err)
        self.path = self.clip(name)
        data = self.path.read_bytes()
        self.path.unlink()
        return data

    def bake_pieces(self, name: str, count: int, *words: str) -> None:
        for number in reversed(range(1, count + 1)):  # in any order
            self.assertEqual(self.run_command("bake", "--object", name, "--piece", f"{number}/{count}", *words), 0,
                             self.err)
            self.assertFalse(self.path.exists())

    def join(self, name: str, count: int, *words: str) -> int:
        return self.run_command("bake", "--object", name, "--join", str(count), *words)

    def check_joined(self, name: str, *words: str, counts: tuple[int, ...] = (3,)) -> None:
        whole = self.whole(name)
        for count in counts:
            self.bake_pieces(name, count, *words)
            self.assertEqual(self.join(name, count, *words), 0, self.err)
            if "--pre-roll" not in words:
                self.assertTrue(self.path.read_bytes() == whole)
            self.assertEqual({path.suffix for path in self.clips.iterdir()}, {".pc2"})
            self.assertEqual(self.run_command("bake", "--verify", "--object", name), 0, self.err)
            if count != counts[-1]:
                self.path.unlink()

    def field(self, **settings: object) -> None:
        """A Wrinkle Field in place of the scarf, whose angles go on from sample to sample."""
        obj = bpy.data.objects[FREE]
        sleeve.make_active(obj)
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="FIELD")
        obj.rumple.bake_end, obj.rumple.bake_samples = FRAMES, 2
        for word, value in settings.items():
            setattr(obj.rumple.field, word, value)
        farm_scene.save(self.blend)

    # --- independent frames
    def test_independent_frames_joined_are_those_of_one_worker(self) -> None:
        self.check_joined(FREE, counts=(1, 3, FRAMES - 1))

    def test_angles_and_subframes_go_on_over_the_seams(self) -> None:
        self.field(stateless=True)
        with mock.patch.object(clip_file, "_unwrapped", lambda angles, before: angles):
            unwound = self.whole(FREE)
        self.assertFalse(self.whole(FREE) == unwound)  # there are turns to go on with
        self.check_joined(FREE)

    def test_a_piece_that_was_ended_goes_on(self) -> None:
        whole = self.whole(FREE)
        with mock.patch.object(bake, "_end_wanted", True):
            self.assertEqual(self.run_command("bake", "--object", FREE, "--piece", "2/2"), 143)
        self.assertEqual({path.suffix for path in self.clips.iterdir()} - {".pc2"}, {".partial", ".journal"})
        self.assertEqual(self.join(FREE, 2), 1)
        self.assertIn("there is no whole piece 1 of 2 of this file", self.err)
        words = ("bake", "--resume", "--object", FREE, "--piece")
        self.assertEqual(self.data(*words, "2/2")["garments"][FREE]["resumed"], 1)
        self.assertEqual(self.data(*words, "1/2")["garments"][FREE]["resumed"], 0)
        self.assertTrue(self.data(*words, "1/2")["garments"][FREE]["was_whole"])
        self.assertEqual(self.join(FREE, 2), 0)
        self.assertTrue(self.path.read_bytes() == whole)
        # Of what is joined no piece is baked again.
        self.assertTrue(self.data(*words, "1/2")["garments"][FREE]["was_whole"])
        self.assertEqual({path.suffix for path in self.clips.iterdir()}, {".pc2"})

    def test_pieces_of_another_file_or_damaged_ones_are_not_joined(self) -> None:
        self.whole(FREE)
        self.bake_pieces(FREE, 2)
        piece = next(self.clips.glob("*.piece-2-of-2"))
        good = piece.read_bytes()
        for place in (100, len(good) // 2):
            piece.write_bytes(good[:place] + bytes([good[place] ^ 1]) + good[place + 1:])
            self.assertEqual(self.join(FREE, 2), 1)
            self.assertIn("there is no whole piece 2 of 2", self.err)
        piece.write_bytes(good)
        farm_scene.save(self.blend.with_name("same.blend"))
        bpy.data.objects[FREE].rumple.mesh.bending = 0.1
        farm_scene.save(self.blend)
        self.assertEqual(self.join(FREE, 2), 1)
        self.assertIn("there is no whole piece 1 of 2 of this file", self.err)
        self.assertFalse(self.path.exists())

    def test_another_worker_keeps_its_piece_and_its_clip(self) -> None:
        self.whole(FREE)
        self.bake_pieces(FREE, 2)
        before = self.read_all()
        held = f'{{"host": "node_7", "process": {os.getppid()}, "started": "", "task": "x"}}'
        for locked, words in ((f"{self.path.stem}.piece-1-of-2", ("--piece", "1/2")),
                              (self.path.name, ("--join", "2"))):
            lock = self.clips / f".{locked}.lock"
            lock.write_text(held)
            self.assertEqual(self.run_command("bake", "--object", FREE, *words), 75)
            lock.unlink()
            self.assertEqual(self.read_all(), before)

    # --- frames that go on from one another
    def test_a_pre_roll_as_long_as_the_clip_gives_the_bits_of_one_worker(self) -> None:
        bpy.data.objects[INNER].rumple.bake_samples = 2
        farm_scene.save(self.blend)
        whole = self.whole(INNER)
        words = ("--pre-roll", str(FRAMES), "--tolerance", "0")
        self.check_joined(INNER, *words)
        before = clip_file.read_manifest(self.path)
        self.assertEqual((before.pre_roll, before.seams, before.format), (FRAMES, [3, 5], 5))
        end = clip_file.size_of(before)
        self.assertTrue(self.path.read_bytes()[:end] == whole[:end])

    def test_a_short_one_is_measured_at_each_seam_and_refused_beyond_the_tolerance(self) -> None:
        whole = self.whole(OUTER)
        words = ("--pre-roll", "1", "--tolerance")
        self.bake_pieces(OUTER, 2, *words, "0")
        self.assertEqual(self.join(OUTER, 2, "--pre-roll", "2", "--tolerance", "9"), 1)  # these have another one
        self.assertIn("there is no whole piece 1 of 2", self.err)
        self.assertEqual(self.join(OUTER, 2, *words, "0"), 1)
        found = re.search(r"at frame (\d+) piece 2 is ([\d.e-]+) mm from the one before it", self.err)
        assert found is not None, self.err
        self.assertEqual(int(found[1]), 4)
        apart = 1e-3 * float(found[2])
        self.assertFalse(self.path.exists())
        self.assertEqual(self.join(OUTER, 2, *words, f"{0.99 * apart:g}"), 1)
        self.assertEqual(self.join(OUTER, 2, *words, f"{1.01 * apart:g}"), 0, self.err)
        self.assertIn(f"at most {found[2]} mm apart, at frame 4", self.out)
        manifest = clip_file.read_manifest(self.path)
        self.assertEqual((manifest.pre_roll, manifest.seams), (1, [4]))
        size = clip_file.HEADER_BYTES + 3 * 12 * manifest.points
        self.assertTrue(self.path.read_bytes()[:size] == whole[:size])  # the first piece is played through
        self.assertFalse(self.path.read_bytes()[:clip_file.size_of(manifest)] == whole[:clip_file.size_of(manifest)])
        for count in ((), ("1",), ("2",), ("3",)):
            self.assertEqual(self.run_command("bake", "--verify", *count, "--object", OUTER), 0, self.err)
        # Who wants it played through gets that.
        self.assertEqual(self.run_command("bake", "--resume", "--object", OUTER), 0)
        self.assertTrue(self.path.read_bytes() == whole)

    def test_a_piece_behind_a_pre_roll_goes_on_behind_a_state(self) -> None:
        self.whole(INNER)
        words = ("--pre-roll", "2", "--tolerance", "1")
        self.bake_pieces(INNER, 2, *words)
        piece = next(self.clips.glob("*.piece-2-of-2"))
        whole = piece.read_bytes()
        piece.unlink()
        steps = iter(range(5))

        def end(lock: object) -> None:
            if next(steps, None) is None:
                raise KeyboardInterrupt
        with mock.patch("rumple.core.files.clip_lock.Lock.touch", end), \
                mock.patch.object(bake.FarmBake, "stop", lambda running: running.partial.keep()):
            self.assertRaises(KeyboardInterrupt, self.run_command, "bake", "--checkpoint", "0", "--object", INNER,
                              "--piece", "2/2", *words)
        found = self.data("bake", "--resume", "--object", INNER, "--piece", "2/2", *words)["garments"][INNER]
        self.assertEqual((found["resumed"], found["passed"]), (4, 4))
        self.assertTrue(piece.read_bytes() == whole)

    def test_what_was_solved_before_does_not_count(self) -> None:
        """A frame that is solved already, in front of those of the pre-roll, is not gone on from."""
        self.whole(INNER)
        words = ("--pre-roll", "1", "--tolerance", "1")
        self.bake_pieces(INNER, 2, *words)
        piece = next(self.clips.glob("*.piece-2-of-2"))
        first = clip_file.read_manifest(piece)
        commands.open_file(self.blend, False)
        obj = bpy.data.objects[INNER]
        bpy.context.scene.frame_set(2)
        options = bake.Options(piece=(2, 2), pre_roll=1, tolerance=1.0)
        pieces.bake_piece(bpy.context, obj, source.of_files(), options, lambda text: None)
        self.assertEqual(clip_file.read_manifest(piece).checksums, first.checksums)

    def test_what_cannot_be_cut_is_refused(self) -> None:
        roll = ("--pre-roll", "2", "--tolerance", "0.001")
        for name, said, words in (
                (INNER, "its frames go on from one another: bake it whole, or give --pre-roll", ()),
                (OUTER, "something wrinkled under it without a clip", roll),
                (FREE, "its frames 1 to 8 cannot be cut into 9 pieces, at most 7", ("--piece", "1/9"))):
            words = words if "--piece" in words else ("--piece", "1/2", *words)
            self.assertEqual(self.run_command("bake", "--object", name, *words), 1)
            self.assertIn(said, self.err)
        self.field()
        self.assertEqual(self.run_command("bake", "--object", FREE, "--piece", "1/2", *roll), 1)
        self.assertIn("its waves cannot be compared in metres", self.err)
        for said, words in (("go together", ("--piece", "1/2", "--pre-roll", "2")),
                            ("go together", ("--pre-roll", "2", "--tolerance", "1")),
                            ("--tolerance is metres", ("--join", "2", "--pre-roll", "2", "--tolerance", "nan")),
                            ("a piece is K/N", ("--piece", "3/2")), ("a piece is K/N", ("--piece", "0/2")),
                            ("not allowed with", ("--piece", "1/2", "--join", "2")),
                            ("leave --piece and --join out", ("--piece", "1/2", "--verify"))):
            self.assertEqual(self.run_command("bake", *words), 2, words)
            self.assertIn(said, self.err)
        self.assertFalse(any(self.clips.glob("*") if self.clips.exists() else ()))

    def test_what_may_be_cut_is_listed(self) -> None:
        cut = {row["name"]: row["cut"] for row in self.data("list")["garments"]}
        self.assertEqual(cut, {INNER: "pre-roll", OUTER: "pre-roll", FREE: "independent"})
