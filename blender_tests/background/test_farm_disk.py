# SPDX-License-Identifier: GPL-3.0-or-later
"""A real disk that is full, or that nobody may write to: a sentence, and nothing is left on it. Mounting needs root."""
from __future__ import annotations

import os
import shutil
import subprocess
from unittest import mock

import test_farm
from support import farm_scene


class Disk(test_farm.Case):

    def mount(self, options: str) -> None:
        """A file system of its own in the place of the clips."""
        self.clips.mkdir()
        done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "rumple_test", str(self.clips)],
                              capture_output=True, text=True)
        if done.returncode:
            self.skipTest(f"NOT TESTED, no disk can be mounted here: {done.stderr.strip()}")
        self.addCleanup(subprocess.run, ["umount", str(self.clips)], check=True)

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
