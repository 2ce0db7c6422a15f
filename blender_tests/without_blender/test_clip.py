# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips on disk: what they say of themselves is believed only where it fits, and whatever happens while one is written
the former one stays."""
from __future__ import annotations

import errno
import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest
from dataclasses import asdict
from pathlib import Path
from unittest import mock
from typing import Any

import numpy as np

from rumple.core.files import clip_file, clip_folder, clip_manifest
from rumple.core.files.clip_manifest import ClipFault, Manifest

POINTS, SAMPLES = 7, 5


def manifest() -> Manifest:
    return Manifest(object="A", vertices=4, points=POINTS, coarse_vertices=3, start=2, end=2 + SAMPLES - 1, samples=1,
                    inputs="hash", file="shot", poses=[[0.5] * 9] * SAMPLES)


def sample(number: int) -> np.ndarray:
    return (np.arange(3 * POINTS, dtype=np.float32) + 100.0 * number).reshape(POINTS, 3)


def write(clip: Path, offset: int = 0) -> None:
    writer = clip_file.SampleWriter(clip, manifest())
    for number in range(SAMPLES):
        writer.add_points(sample(number + offset))
    writer.seal()
    writer.commit()


class OnDisk(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.clip = self.folder / "a.pc2"

    def fault(self) -> str:
        with self.assertRaises(ClipFault) as caught:
            clip_file.read_manifest(self.clip)
        return str(caught.exception)


class Reading(OnDisk):

    def test_what_was_written_comes_back(self) -> None:
        write(self.clip)
        read = clip_file.read_manifest(self.clip)
        self.assertEqual({**asdict(read), "checksums": 0}, {**asdict(manifest()), "checksums": 0})
        self.assertTrue(all(clip_file.sample_is_whole(self.clip, read, n) for n in range(SAMPLES)))
        data = self.clip.read_bytes()
        self.assertEqual(struct.unpack("<12siiffi", data[:32]), (b"POINTCACHE2\0", 1, POINTS, 2.0, 1.0, SAMPLES))
        for number in range(SAMPLES):  # where any reader of PC2 looks for it
            values = np.frombuffer(data, "<f4", 3 * POINTS, 32 + 12 * POINTS * number).reshape(-1, 3)
            np.testing.assert_array_equal(values, sample(number))

    def test_whatever_is_cut_off_is_noticed(self) -> None:
        write(self.clip)
        data = self.clip.read_bytes()
        for length in range(len(data)):
            self.clip.write_bytes(data[:length])
            if length == 32 + 12 * POINTS * SAMPLES:
                self.assertIsNone(clip_file.read_manifest(self.clip), "a whole PC2 as other programs write it")
            else:
                self.fault()

    def test_every_byte_that_is_another_is_noticed(self) -> None:
        # By size alone a clip of zeros passed for whole.
        write(self.clip)
        good, samples_end = self.clip.read_bytes(), 32 + 12 * POINTS * SAMPLES
        for place in range(len(good)):
            bad = bytearray(good)
            bad[place] ^= 0x41
            self.clip.write_bytes(bad)
            if 32 <= place < samples_end:
                read = clip_file.read_manifest(self.clip)
                whole = [clip_file.sample_is_whole(self.clip, read, n) for n in range(SAMPLES)]
                self.assertEqual(whole, [n != (place - 32) // (12 * POINTS) for n in range(SAMPLES)])
            else:
                self.fault()

    def test_a_clip_of_format_3_is_read_with_the_manifest_beside_it(self) -> None:
        write(self.clip)
        data = self.clip.read_bytes()[:32 + 12 * POINTS * SAMPLES]
        older = {k: v for k, v in asdict(manifest()).items() if k not in ("file", "checksums", "curves")}
        self.clip.write_bytes(data)
        clip_file.manifest_path(self.clip).write_text(json.dumps({**older, "format": 3}))
        read = clip_file.read_manifest(self.clip)
        self.assertEqual((read.format, read.points), (3, POINTS))
        self.assertTrue(clip_file.sample_is_whole(self.clip, read, 2))
        self.clip.write_bytes(data[:-1])
        self.assertIn("cut short", self.fault())


class Manifests(unittest.TestCase):

    def test_nothing_is_taken_but_known_entries_of_known_types(self) -> None:
        good = asdict(manifest()) | {"checksums": [1] * SAMPLES}
        clip_manifest.read(json.dumps(good))
        bad = [dict(end=None), dict(end="x"), dict(end=1), dict(samples=0), dict(samples=-1), dict(samples=10**9),
               dict(vertices="9"), dict(vertices=0), dict(vertices=True), dict(start=-10**30), dict(points=1e308),
               dict(points=1 << 31, vertices=1 << 31),
               dict(points=3), dict(coarse_vertices=-1), dict(poses=None), dict(poses=[]), dict(poses=["x"] * SAMPLES),
               dict(poses=[[1, 2]] * SAMPLES), dict(poses=[[float("nan")] * 9] * SAMPLES), dict(object=5),
               dict(inputs=[]), dict(file=None), dict(evil=1), dict(format=99), dict(format="4"), dict(checksums=[]),
               dict(checksums=None), dict(checksums=["1"] * SAMPLES), dict(checksums=[-1] * SAMPLES),
               dict(checksums=[1 << 32] * SAMPLES), dict(curves=1.5), dict(curves="x")]
        for change in bad:
            with self.subTest(change), self.assertRaises(ClipFault):
                clip_manifest.read(json.dumps(good | change))
        for name in ("object", "vertices", "points", "coarse_vertices", "start", "end", "samples", "inputs"):
            with self.subTest(name), self.assertRaises(ClipFault):
                clip_manifest.read(json.dumps({k: v for k, v in good.items() if k != name}))

    def test_no_text_makes_it_raise_anything_else(self) -> None:
        good = json.dumps(asdict(manifest()))
        texts = ["", "{", "null", "[]", "5", "\0" * 100, "[" * 200_000, '{"a":' * 200_000, b"\xff\xfe{}",
                 good.replace('"points": 7', '"points": ' + "9" * 5000)]
        for text in texts:
            with self.subTest(text[:20]), self.assertRaises(ClipFault):
                clip_manifest.read(text)

    def test_a_frame_needs_the_samples_on_both_sides(self) -> None:
        about = manifest()
        around = [about.samples_around(frame) for frame in (2.0, 3.25, 6.0, -50.0, 99.0)]
        self.assertEqual(around, [[0], [1, 2], [4], [0], [4]])


class Names(unittest.TestCase):

    def test_no_two_objects_or_files_share_one(self) -> None:
        # "A.001" and "A_001" overwrote one another, and so did the objects of two files in one folder.
        names = ["A.001", "A_001", "A 001", "a.001", "A-001", "Ä", "Ö", "", "x" * 80, "x" * 80 + "y", "\ud800"]
        files = ["shot_v001", "shot_v002", "shot.v001", "", "shot_v001-A"]
        all_names = [clip_folder.clip_name(file, name, place) for file in files for name in names
                     for place in ("", "/one", "/two")]
        self.assertEqual(len({name.lower() for name in all_names}), len(all_names))
        for name in all_names:
            self.assertRegex(name, r"^[\w-]{1,140}\.pc2$")

    def test_the_same_object_of_the_same_file_keeps_its_name(self) -> None:
        self.assertEqual(clip_folder.clip_name("shot", "A"), clip_folder.clip_name("shot", "A"))


class Full:
    """A file on a disk that has so many bytes left. What is buffered may fail again when it is closed."""

    def __init__(self, file: Any, left: int) -> None:
        self.file, self.left, self.waiting = file, left, b""

    def write(self, data: bytes) -> None:
        self.waiting += data

    def flush(self) -> None:
        if len(self.waiting) > self.left:
            raise OSError(errno.ENOSPC, "No space left on device")
        self.left -= len(self.waiting)
        self.file.write(self.waiting)
        self.waiting = b""

    def fileno(self) -> int:
        return self.file.fileno()

    def close(self) -> None:
        try:
            self.flush()
        finally:
            self.file.close()


class Writing(OnDisk):

    def test_a_disk_that_fills_up_at_any_byte_leaves_the_former_clip_and_nothing_else(self) -> None:
        # Samples below the buffer: closing the file raised again, and the .part stayed on the full disk.
        write(self.clip)
        before = self.clip.read_bytes()
        for left in (0, 31, 32, 100, 32 + 12 * POINTS * SAMPLES, len(before) - 60):
            opened = open
            with mock.patch("builtins.open", lambda *a, left=left: Full(opened(*a), left)):
                writer = clip_file.SampleWriter(self.clip, manifest())
                with self.assertRaisesRegex(ClipFault, "the disk of .* is full: make room") as caught:
                    for number in range(SAMPLES):
                        writer.add_points(sample(number + 9))
                    writer.seal()
                self.assertNotIn("Errno", str(caught.exception))
                writer.discard()
            self.assertEqual(self.clip.read_bytes(), before)
            self.assertEqual(os.listdir(self.folder), ["a.pc2"])

    def test_a_disk_without_room_is_said_before_anything_is_solved(self) -> None:
        usage = mock.Mock(free=10)
        with mock.patch("shutil.disk_usage", return_value=usage):
            with self.assertRaisesRegex(ClipFault, r"needs .* MB .* has .* MB left: make room"):
                clip_file.SampleWriter(self.clip, manifest())
        self.assertEqual(os.listdir(self.folder), [])

    def test_bad_folders_are_said_with_what_to_do(self) -> None:
        plain = self.folder / "plain"
        plain.write_text("")
        for folder in (plain, plain / "under", Path("/proc/nope"), self.folder / ("y" * 300), Path("/a\0b")):
            with self.subTest(str(folder)[:40]), self.assertRaisesRegex(ClipFault, "choose another folder") as caught:
                clip_file.SampleWriter(folder / "a.pc2", manifest())
            self.assertNotIn("Errno", str(caught.exception))

    def test_names_in_files_are_plain_and_no_two_are_the_same(self) -> None:
        names = ["Shirt", "Coat.001", "A.001", "A_001", "a_001", "x" * 60, "x" * 61]
        found = [clip_folder.readable_beside(name, [other for other in names if other != name]) for name in names]
        self.assertEqual(found[:2], ["Shirt", "Coat_001"])  # where nothing else is like it, as they always were
        self.assertEqual(len({name.casefold() for name in found}), len(names))
        of_library = clip_folder.readable_beside("A", ["A"], "//b.blend")
        self.assertNotEqual(clip_folder.readable_beside("A", ["A"]), of_library)

    def test_no_file_has_the_name_of_a_device_of_windows(self) -> None:
        for name in ("CON", "aux", "Nul", "com1", "LPT9"):
            self.assertEqual(clip_folder.readable(name), f"{name}_")
        for name in ("Cone", "aux_2", "com", "com12"):
            self.assertEqual(clip_folder.readable(name), name)

    def test_what_windows_refuses_is_said_with_its_own_reasons(self) -> None:
        deep, plain = Path("C:/" + "d" * 250), Path("C:/clips")
        away = FileNotFoundError(errno.ENOENT, "")
        away.winerror = 59  # type: ignore[attr-defined]
        for error, folder, words in (
                (FileNotFoundError(errno.ENOENT, ""), deep, "is too long for Windows"),
                (FileNotFoundError(errno.ENOENT, "", str(plain / ("n" * 240))), plain, "is too long for Windows"),
                (FileNotFoundError(errno.ENOENT, ""), plain, "connect its disk"),
                (PermissionError(errno.EACCES, ""), plain, "close the program that has a file of it open, change its"),
                (away, plain, "connect its disk"), (OSError(errno.ENOSPC, ""), deep, "is full")):
            with mock.patch("rumple.native.platforms.ON_WINDOWS", True):
                self.assertIn(words, clip_folder.in_words(error, folder))
        self.assertNotIn("Windows", clip_folder.in_words(FileNotFoundError(errno.ENOENT, ""), deep))

    def test_a_folder_that_vanishes_while_it_is_written_is_said(self) -> None:
        writer = clip_file.SampleWriter(self.folder / "gone" / "a.pc2", manifest())
        for number in range(SAMPLES):
            writer.add_points(sample(number))
        writer.seal()
        writer.temporary.unlink()
        writer.clip.parent.rmdir()
        with self.assertRaisesRegex(ClipFault, "is gone or cannot be made: connect its disk"):
            writer.commit()
        writer.discard()

    def test_killed_at_any_moment_the_former_clip_is_whole_and_the_next_bake_sweeps(self) -> None:
        write(self.clip)
        before = self.clip.read_bytes()
        code = ("import os, signal, sys; from pathlib import Path; from unittest import mock\n"
                "import test_clip as t\n"
                "step, moments = int(sys.argv[2]), iter(range(1000))\n"
                "def moment(real):\n"
                "    def call(*a, **k):\n"
                "        if next(moments) == step: os.kill(os.getpid(), signal.SIGKILL)\n"
                "        return real(*a, **k)\n"
                "    return call\n"
                "for owner, name in ((os, 'replace'), (os, 'fsync'), (t.clip_file.SampleWriter, 'add_points'),\n"
                "                    (t.clip_file.SampleWriter, '_seal'), (t.clip_file.SampleWriter, 'commit')):\n"
                "    setattr(owner, name, moment(getattr(owner, name)))\n"
                "t.write(Path(sys.argv[1]), 50)\n")
        here = str(Path(__file__).parent)
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([here, *sys.path])}
        ends = []
        for step in range(SAMPLES + 5):
            child = subprocess.run([sys.executable, "-c", code, str(self.clip), str(step)], env=environment)
            ends.append(child.returncode)
            if ends[-1] == 0:
                break
            self.assertEqual(self.clip.read_bytes(), before, step)
            self.assertEqual(len(list(self.folder.glob(".*.part"))), 1, "it swept what the one before it left")
        self.assertEqual(ends, [-9] * (SAMPLES + 4) + [0])
        self.assertNotEqual(self.clip.read_bytes(), before)
        self.assertEqual(os.listdir(self.folder), ["a.pc2"])

    def test_only_files_of_gone_processes_of_this_machine_are_swept(self) -> None:
        gone = subprocess.Popen([sys.executable, "-c", ""])
        gone.wait()
        here = clip_folder.temporary(self.clip).name.split(".")[3]
        names = {f".a.pc2.{here}.{os.getpid()}-0.part": True, f".a.pc2.other.{gone.pid}-0.part": True,
                 f".a.pc2.{here}.{gone.pid}-0.part": False, ".mine.part": True, f".a.pc2.{gone.pid}.part": True}
        for name in names:
            (self.folder / name).write_text("")
        clip_folder.sweep(self.folder)
        self.assertEqual({name: (self.folder / name).exists() for name in names}, names)


if __name__ == "__main__":
    unittest.main()
