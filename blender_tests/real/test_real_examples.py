# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples that need ../shared/data: each is small, says whose it is, opens and folds."""
from __future__ import annotations

import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from rumple.blender.nodes import wrinkle_tree
from rumple.blender.objects import modifier
from rumple.blender.ui import examples
from support import sleeve

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
PLAYED = 6  # frames
LEAST_FOLD = 0.001  # metres: that something of the cloth is moved, at least


class CapturedScenes(unittest.TestCase):
    def opens(self, name: str, *credits: str) -> None:
        sys.path[:0] = [] if str(SCRIPTS) in sys.path else [str(SCRIPTS)]
        import examples_run
        with tempfile.TemporaryDirectory() as folder:
            examples_run.make(name, Path(folder) / f"{name}.blend")  # refuses what is too large
            with mock.patch.object(examples, "FOLDER", Path(folder)):
                self.assertEqual(bpy.ops.wm.rumple_open_example(name=name), {"FINISHED"})
        for word in ("CC0 1.0", *credits):
            self.assertIn(word, bpy.data.texts["Read Me"].as_string())

    def opens_and_folds(self, name: str, credit: str, *garments: str) -> None:
        self.opens(name, credit)
        sleeve.play(20, 20 + PLAYED)
        for garment in garments:
            obj = bpy.data.objects[garment]
            self.assertEqual(obj.rumple.message, "", garment)
            self.assertIsNotNone(modifier.find(obj))
            smooth = sleeve.attribute(obj, wrinkle_tree.BASE_POSITION)
            moved = np.linalg.norm(sleeve.shown(obj) - smooth, axis=1)
            self.assertGreater(np.percentile(moved, 99), LEAST_FOLD, garment)

    def test_walk(self) -> None:
        self.opens_and_folds("Walk", "mocap.cs.cmu.edu", "trousers", "shirt")

    def test_jump(self) -> None:
        self.opens_and_folds("Jump", "Copyright (c) Meta Platforms", "trousers", "sweater")

    def test_dance(self) -> None:
        self.opens_and_folds("Dance", "mocap.cs.cmu.edu", "skirt")
        self.assertEqual(bpy.context.scene.frame_end, 110)

    def test_expressions_bring_their_maps_along(self) -> None:
        self.opens("Expressions")
        settings = bpy.data.objects["Head"].rumple_maps
        self.assertEqual([pose.name for pose in settings.poses], ["Surprise", "Anger"])
        for pose in settings.poses:
            self.assertIsNotNone(pose.image.packed_file)
            texels = np.empty(len(pose.image.pixels), np.float32)
            pose.image.pixels.foreach_get(texels)
            self.assertGreater(np.abs(texels.reshape(-1, 4)[:, :2] - 0.5).max(), 0.2, pose.name)
        sleeve.play(1, 20)
        self.assertEqual(bpy.data.objects["Head"].rumple.message, "")


if __name__ == "__main__":
    unittest.main()
