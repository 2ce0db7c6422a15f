# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample for Godot plays exported Wrinkle Maps: its pictures are Blender's. 256 x 256 pixels over 0.14 m, from the
front; colours are normals."""
from __future__ import annotations

import json
import os
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image
from support.godot_project import ROOT, GodotProject, said_by

OUT = Path(os.environ["RUMPLE_OUT"])
SIZE, FRAMES = 256, (1, 6, 11)


class Maps(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.exported = cls.folder / "exported"
        said_by("blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                ROOT / "blender_tests" / "support" / "maps_scene.py", "--", cls.exported, *FRAMES)
        cls.project = GodotProject(cls.folder)
        cls.without = cls.play("--picture=none.png", code=1)
        (cls.project.path / "face").mkdir()
        for file in cls.exported.glob("face*"):
            shutil.copy(file, cls.project.path / "face")
        cls.project.import_all()

    @classmethod
    def play(cls, *words: str, code: int = 0) -> str:
        return cls.project.play(SIZE, "maps.tscn", *words, code=code)

    def picture(self, frame: float) -> np.ndarray:
        """(256, 256, 3) of 0..1."""
        file = OUT / f"godot_maps_{frame:g}.png"
        self.play(f"--picture={file}", f"--frame={frame:g}", "--normals")
        return np.asarray(Image.open(file).convert("RGB")) / 255.0

    def blender(self, frame: int) -> np.ndarray:
        return np.asarray(Image.open(self.exported / f"blender_{frame}.png").convert("RGB")) / 255.0

    def test_pictures_of_frames_are_those_of_blender(self) -> None:
        """99 % of the pixels within 0.02; and the maps appear: from frame to frame more differs by far."""
        first = self.blender(FRAMES[0])
        for frame in FRAMES:
            found, expected = self.picture(frame), self.blender(frame)
            covered = expected.max(-1) > 0.02
            self.assertGreater(covered.sum(), 40000)
            self.assertLess(((found.max(-1) > 0.02) ^ covered).mean(), 0.005)
            errors = np.abs(found - expected).max(-1)[covered]
            print(f"frame {frame}: normals differ by {np.median(errors):.4f} (median), "
                  f"{np.quantile(errors, 0.99):.4f} (99 %), {errors.max():.4f} (most)")
            self.assertLess(np.quantile(errors, 0.99), 0.02)
            if frame != FRAMES[0]:
                self.assertGreater(np.abs(expected - first).max(-1).max(), 0.1)
                self.assertGreater((np.abs(found - first).max(-1) > 0.05).sum(), 1000)

    def test_parts_of_frames_lie_between(self) -> None:
        one, middle, other = (self.picture(frame) for frame in (6, 6.5, 7))
        apart = np.abs(one - other).max()
        self.assertGreater(apart, 0.02)
        np.testing.assert_allclose(middle, (one + other) / 2.0, atol=0.5 * apart)

    def test_each_file_counts(self) -> None:
        """The map, the strength, the gain, the kind of maps and the influences: without one the picture is another."""
        whole = self.picture(11)
        path = self.project.path / "face" / "face.json"
        text = path.read_text()
        self.addCleanup(path.write_text, text)
        for harm in (lambda rig: rig["poses"][0].update(map=""), lambda rig: rig["poses"][0].update(strength=0.3),
                     lambda rig: rig.update(gain=0.3 * rig["gain"]), lambda rig: rig.update(
                         maps="wrinkles" if rig["maps"] == "whole" else "whole"),
                     lambda rig: rig.update(neutral_map=""), lambda rig: rig["bones"][1].update(name="nobody")):
            rig = json.loads(text)
            harm(rig)
            path.write_text(json.dumps(rig))
            self.assertGreater(np.abs(self.picture(11) - whole).max(), 0.05)
        rig = json.loads(text)
        rig["poses"] *= 5
        path.write_text(json.dumps(rig))
        self.assertIn("This sample shows 8 poses, the face has 10", self.play("--picture=x.png", code=1))

    def test_without_a_face_it_says_so(self) -> None:
        self.assertIn("There is no face: copy what Rumple has exported", self.without)
