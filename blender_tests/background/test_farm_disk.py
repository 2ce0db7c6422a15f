# SPDX-License-Identifier: GPL-3.0-or-later
"""A real disk that is full, or that nobody may write to: a sentence, and nothing is left on it. Mounting needs root."""
from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
from unittest import mock

from support import farm_case, farm_scene


class Disk(farm_case.Case):

    def mount(self, options: str, name: str = "rumple") -> None:
        """A file system of its own in the place of the clips, or of another folder beside the file."""
        folder = self.folder / name
        folder.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "rumple_test", str(folder)],
                              capture_output=True, text=True)
        if done.returncode:
            self.skipTest(f"NOT TESTED, no disk can be mounted here: {done.stderr.strip()}")
        # MNT_DETACH: Blender leaves a PNG open that it could not write. umount --lazy wants /proc, which chroots lack.
        self.addCleanup(lambda: self.assertEqual(ctypes.CDLL(None).umount2(bytes(folder), 2), 0))

    def test_exports_to_a_disk_that_becomes_full(self) -> None:
        """Of each size that is too small: whichever file is the one that does not fit."""
        self.assertEqual(self.run_command("bake", "--object", farm_scene.FREE), 0)
        for size in ("8k", "40k", "80k"):
            name = f"disk{size}"
            self.mount(f"size={size}", name)
            roomy = mock.patch("shutil.disk_usage", return_value=shutil._ntuple_diskusage(1 << 40, 0, 1 << 40))
            for words in (("vat", "--image", "both", "--to"), ("poses", "--count", "40", "--out")):
                with roomy:
                    self.assertEqual(self.run_command(words[0], "--object", farm_scene.FREE, *words[1:],
                                                      str(self.folder / name)), 1, (size, words))
                self.assertRegex(self.err, "is full: make room|cannot be written.* make room")
                self.assertNotRegex(" ".join(os.listdir(self.folder / name)), "_vat|block|part")
                for left in (self.folder / name).iterdir():  # what is whole of the poses: manifest and mesh
                    self.assertIn(left.name, ("manifest.json", "mesh.npz"))
                    left.unlink()

    def test_exports_to_a_disk_that_nobody_may_write_to(self) -> None:
        self.assertEqual(self.run_command("bake", "--object", farm_scene.FREE), 0)
        self.mount("ro", "disk")
        for words in (("vat", "--to"), ("publish", "--to"), ("poses", "--count", "4", "--out")):
            self.assertEqual(self.run_command(words[0], "--object", farm_scene.FREE, *words[1:],
                                              str(self.folder / "disk")), 1)
            self.assertIn("nothing can be written to", self.err)
        self.assertEqual(os.listdir(self.folder / "disk"), [])

    def test_a_disk_that_becomes_full(self) -> None:
        self.mount("size=400k")
        self.assertEqual(self.run_command("bake", "--object", farm_scene.INNER), 0)  # that one fits
        before = self.read_all()
        for said, free in (("make room, or choose another folder", None), ("is full: make room", 1 << 40)):
            usage = shutil.disk_usage if free is None else lambda path: shutil._ntuple_diskusage(free, 0, free)
            with mock.patch("shutil.disk_usage", usage):
                self.assertEqual(self.run_command("bake", "--object", farm_scene.FREE), 1)
            self.assertIn(said, self.err)
            self.assertEqual(self.read_all(), before)

    def test_a_disk_that_nobody_may_write_to(self) -> None:
        self.mount("ro")
        self.assertEqual(self.run_command("bake"), 1)
        self.assertIn("Sleeve FAILED: nothing can be written to", self.err)
        self.assertEqual(self.run_command("check"), 1)
        self.assertIn("nothing can be written to", self.err)
        self.assertEqual(os.listdir(self.clips), [])
