# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that were ended: what is kept is used where it is whole, of the same bake, and what is solved now; and the clip
is then, byte for byte, the one that was never ended."""
from __future__ import annotations

import os
import re
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from rumple.core.files.checkpoint import Checkpoint
from rumple.core.files.clip_manifest import Manifest
from rumple.core.files.clip_partial import PartialWriter
from rumple.core.mesh.frame_result import FrameResult

POINTS, SAMPLES, MADE_BY = 7, 6, "this"


class Case(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.clip = Path(folder.name) / "a.pc2"
        self.manifest = Manifest(object="A", vertices=POINTS, points=POINTS, coarse_vertices=2, start=1, end=SAMPLES,
                                 samples=1, inputs="hash", file="shot", source="of this file")

    def writer(self, resume: bool = True, made_by: str = MADE_BY, **entries: object) -> PartialWriter:
        return PartialWriter(self.clip, replace(self.manifest, poses=[], checksums=[], **entries), (), resume, made_by)

    @staticmethod
    def add(writer: PartialWriter, first: int, last: int, shift: float = 0.0) -> None:
        """Samples of numbers from first to before last. shift: solved otherwise."""
        for number in range(first, last):
            points = np.arange(3 * POINTS, dtype=np.float32).reshape(-1, 3) + np.float32(number + shift)
            writer.add(FrameResult(points, points, {}), points[:2])

    def finish(self, writer: PartialWriter, first: int = 0) -> bytes:
        self.add(writer, first, SAMPLES)
        writer.seal()
        writer.commit()
        self.assertEqual(os.listdir(self.clip.parent), [self.clip.name])
        return self.clip.read_bytes()

    def end_after(self, samples: int, shift: float = 0.0, **entries: object) -> Path:
        """The samples of a bake that is ended."""
        writer = self.writer(resume=False, **entries)
        self.add(writer, 0, samples, shift)
        writer.keep()
        return writer.temporary

    def test_it_goes_on_behind_what_is_kept(self) -> None:
        whole = self.finish(self.writer())
        for ended in (1, 4, SAMPLES):
            self.clip.unlink()
            self.end_after(ended)
            writer = self.writer()
            self.assertEqual(writer.kept, ended)
            writer.pass_over(ended)
            self.assertEqual(self.finish(writer, ended), whole)

    def test_what_is_solved_otherwise_now_is_written_anew_from_there(self) -> None:
        whole = self.finish(self.writer())
        self.clip.unlink()
        self.end_after(4, shift=0.5)
        writer = self.writer()
        self.assertEqual(writer.kept, 4)
        self.assertEqual(self.finish(writer), whole)

    def test_nothing_of_another_bake_is_kept(self) -> None:
        for entries in (dict(inputs="other"), dict(source="other"), dict(end=SAMPLES + 1), dict(object="B")):
            self.end_after(4, **entries)
            writer = self.writer()
            self.assertEqual(writer.kept, 0, entries)
            writer.discard()
        self.end_after(4)
        writer = self.writer(made_by="another Blender")
        self.assertEqual(writer.kept, 0)
        writer.discard()
        self.assertEqual(os.listdir(self.clip.parent), [])

    def test_what_was_cut_short_or_changed_ends_it(self) -> None:
        size = 12 * POINTS

        def harm(file: Path, kept: int, change: object) -> None:
            data = bytearray(file.read_bytes())
            change(data)  # type: ignore[operator]
            file.write_bytes(data)
            writer = self.writer()
            self.assertEqual(writer.kept, kept)
            writer.discard()

        def flip(data: bytearray) -> None:
            data[32 + 2 * size + 5] ^= 1

        samples = self.end_after(4)
        harm(samples, 2, flip)
        harm(self.end_after(4), 3, lambda data: data.__delitem__(slice(-3, None)))
        harm(self.end_after(4), 0, lambda data: data.__setitem__(slice(0, 4), b"NONE"))
        for cut, kept in ((3, 3), (1, 3)):  # in the middle of a line, and only its end
            file = self.end_after(4)
            harm(file.with_name(file.name.removesuffix(".partial") + ".journal"), kept,
                 lambda data: data.__delitem__(slice(-cut, None)))
        file = self.end_after(4)
        harm(file.with_name(file.name.removesuffix(".partial") + ".journal"), 0, lambda data: data.__setitem__(0, 0xff))
        file = self.end_after(4)  # a checksum that no integer is
        harm(file.with_name(file.name.removesuffix(".partial") + ".journal"), 0,
             lambda data: data.__setitem__(slice(None), re.sub(rb"\n\[\d+", b"\n[Infinity", data, count=1)))

    def test_a_state_is_of_samples_that_are_whole_and_of_this_bake(self) -> None:
        def end_with_state(sample: int) -> PartialWriter:
            writer = self.writer(resume=False)
            self.add(writer, 0, 4)
            writer.save(Checkpoint(sample, {"a": np.arange(5)}))
            writer.keep()
            return writer

        end_with_state(2)
        for _ in range(2):  # who goes on has it at once, and hands it on where it is ended before its own
            writer = self.writer()
            self.assertIsNotNone(writer.checkpoint)
            self.assertEqual((writer.checkpoint.sample, writer.kept), (2, 4))
            np.testing.assert_array_equal(writer.checkpoint.arrays["a"], np.arange(5))
            writer.keep()
        self.finish(self.writer())  # nothing of it is left
        self.clip.unlink()
        end_with_state(4)  # behind samples that the disk has lost
        self.assertIsNone(self.writer().checkpoint)
        end_with_state(2)
        writer = self.writer(inputs="other")
        self.assertIsNone(writer.checkpoint)
        writer.discard()
        self.assertEqual(os.listdir(self.clip.parent), [])

    def test_a_state_that_cannot_be_written_is_left_out(self) -> None:
        writer = self.writer(resume=False)
        self.add(writer, 0, 4)
        writer.save(Checkpoint(1, {"a": np.arange(5)}))
        with mock.patch("os.replace", side_effect=OSError(28, "")):
            writer.save(Checkpoint(3, {"a": np.arange(5)}))
        self.assertEqual({path.suffix for path in self.clip.parent.iterdir()}, {".partial", ".journal", ".state"})
        writer.keep()
        again = self.writer()
        self.assertEqual(again.checkpoint.sample, 1)
        self.finish(again)

    def test_of_several_the_longest_is_used_and_all_are_removed(self) -> None:
        first = self.end_after(3)
        aside = {path: path.read_bytes() for path in (first, first.with_suffix(".journal"))}
        self.end_after(5)
        for path, data in aside.items():
            path.write_bytes(data)
        writer = self.writer()
        self.assertEqual(writer.kept, 5)
        self.finish(writer)
        self.end_after(2)
        self.finish(self.writer(resume=False))  # a bake that does not resume leaves nothing of them either


if __name__ == "__main__":
    unittest.main()
