# SPDX-License-Identifier: GPL-3.0-or-later
"""In a window stored frames go to disk while nothing moves, and the panel says how it went."""
from __future__ import annotations

import os
import tempfile
import unittest
from pathlib import Path
from typing import Iterator

import bpy
from rumple.blender.frame import disk_frames
from support import sleeve
from support.window_case import WindowCase


class DiskFrames(WindowCase):
    def test_they_are_written_when_nothing_moves(self) -> Iterator[float | None]:
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        obj = sleeve.scene()
        with sleeve.context():
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(place.name, "shot.blend"))
        obj = bpy.data.objects["Sleeve"]
        obj.rumple.keep_frames = True
        yield 0.5
        for frame in range(1, 7):
            sleeve.at(frame)
            self.assertEqual(self.files(place.name), [])  # never in a frame
            yield
        yield from self.until(lambda: len(self.files(place.name)) >= 6, 30.0)
        self.assertEqual(disk_frames.of(obj).note, "")
        self.assertEqual(obj.rumple.message, "")

    def files(self, folder: str) -> list[Path]:
        return list(Path(folder).glob("rumple/*.frames/*.frame"))


if __name__ == "__main__":
    unittest.main()
