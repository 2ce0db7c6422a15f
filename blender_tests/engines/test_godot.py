# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample for Godot plays an exported garment: its picture is that of the published USD, drawn here triangle by
triangle. 512 x 512 pixels over 0.9 m, from above; colours are normals."""
from __future__ import annotations

import os
import re
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np
from PIL import Image
from support.godot_project import ROOT, GodotProject, said_by

RUMPLE = ROOT / "scripts" / "rumple"
OUT = Path(os.environ["RUMPLE_OUT"])
SIZE, HALF, MIDDLE = 512, 0.45, (0.25, 0.15)  # main.gd
FRAMES = 12


class Stage:
    """What the test needs of a published USD."""

    def __init__(self, file: Path) -> None:
        text = file.read_text()
        self.points, self.normals = self._samples(text, r"points"), self._samples(text, r"normals")
        counts, corners = (np.array(re.search(rf"int\[\] {name} = \[(.*?)\]", text)[1].split(","), int)
                           for name in ("faceVertexCounts", "faceVertexIndices"))
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        self.triangles = np.array([(corners[start], corners[start + k], corners[start + k + 1])
                                   for start, count in zip(starts, counts) for k in range(1, count - 1)])

    @staticmethod
    def _samples(text: str, name: str) -> list[np.ndarray]:
        block = re.search(rf" {name}\.timeSamples = {{\n(.*?)\n\s*}}", text, re.DOTALL)[1]
        return [np.array(re.findall(r"-?[\d.]+(?:e-?\d+)?", values), float).reshape(-1, 3)
                for values in re.findall(r"\d+: \[(.*?)\]", block)]

    def drawn(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """(covered, normals of 0..1) of a frame: the highest triangle at the middle of each pixel."""
        height = np.full((SIZE, SIZE), -np.inf)
        shown = np.zeros((SIZE, SIZE, 3))
        points, normals = self.points[frame], self.normals[frame]
        flat = ((points[:, :2] - MIDDLE) * (1.0, -1.0) / HALF + 1.0) * SIZE / 2.0 - 0.5  # pixels
        for triangle in self.triangles:
            a, b, c = flat[triangle]
            size = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
            low, high = np.ceil(flat[triangle].min(0)).astype(int), np.floor(flat[triangle].max(0)).astype(int) + 1
            if abs(size) < 1e-9 or (high <= low).any():
                continue
            x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
            second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / size
            third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / size
            weights = np.stack([1.0 - second - third, second, third], -1)
            z = weights @ points[triangle, 2]
            found = (weights >= 0.0).all(-1) & (z > height[y, x])
            height[y[found], x[found]] = z[found]
            shown[y[found], x[found]] = (weights @ normals[triangle])[found]
        lengths = np.linalg.norm(shown, axis=-1, keepdims=True)
        return np.isfinite(height), shown / np.where(lengths > 0.0, lengths, 1.0) * 0.5 + 0.5


class Godot(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        blend = cls.folder / "shot.blend"
        said_by("blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                ROOT / "blender_tests" / "support" / "farm_scene.py", "--", f"{blend}:{FRAMES}")
        for words in (("bake", "--frames", f"1-{FRAMES}"), ("vat", "--image", "exr"), ("publish",),
                      ("vat", "--image", "exr", "--in-place", "--to", cls.folder / "in_place")):
            said_by(RUMPLE, words[0], blend, "--object", "Sleeve", *words[1:])
        cls.stage = Stage(next((cls.folder / "publish").glob("*.usda")))
        cls.project = GodotProject(cls.folder)
        cls.without = cls.project.play(SIZE, "--picture=none.png", code=1)
        shutil.copytree(next((cls.folder / "publish").glob("*_vat")), cls.project.path / "garment")
        cls.project.import_all()

    def picture(self, frame: int) -> np.ndarray:
        """(512, 512, 3) of 0..1."""
        file = OUT / f"godot_{frame}.png"
        self.project.play(SIZE, f"--picture={file}", f"--frame={frame}", "--normals", f"--x={MIDDLE[0]}",
                          f"--y={MIDDLE[1]}")
        return np.asarray(Image.open(file).convert("RGB")) / 255.0

    def test_pictures_of_frames_are_those_of_the_clip(self) -> None:
        """At most 1 % of the covered pixels are covered in one picture alone; colours inside: 99 % within 0.03."""
        first, _ = self.stage.drawn(0)
        for frame in (0, 5, FRAMES - 1):
            covered, normals = self.stage.drawn(frame)
            shown = self.picture(frame)
            seen = shown.max(-1) > 0.02
            apart = (covered ^ seen).sum() / (covered | seen).sum()
            errors = np.abs(shown - normals).max(-1)[covered & seen]
            print(f"frame {frame}: {100 * apart:.2f} % of the silhouette differ, colours by {np.median(errors):.4f} "
                  f"(median), {np.quantile(errors, 0.99):.4f} (99 %)")
            self.assertGreater(covered.sum(), 5000)
            self.assertLess(apart, 0.01)
            self.assertLess(np.quantile(errors, 0.99), 0.03)
            if frame:  # the law could fail: other frames have other pictures
                self.assertGreater((first ^ seen).sum() / (first | seen).sum(), 0.1)

    def test_a_garment_in_place_goes_its_way(self) -> None:
        covered, _ = self.stage.drawn(FRAMES - 1)
        (folder,) = (self.folder / "in_place").iterdir()
        garment = self.project.path / "garment"
        self.addCleanup(shutil.copytree, next((self.folder / "publish").glob("*_vat")), garment, dirs_exist_ok=True)
        shutil.copytree(folder, garment, dirs_exist_ok=True)
        seen = self.picture(FRAMES - 1).max(-1) > 0.02
        self.assertLess((covered ^ seen).sum() / (covered | seen).sum(), 0.01)
        (garment / "Sleeve-remap_info.json").write_text(
            (garment / "Sleeve-remap_info.json").read_text().replace('"way"', '"no_way"'))
        seen = self.picture(FRAMES - 1).max(-1) > 0.02
        self.assertGreater((covered ^ seen).sum() / (covered | seen).sum(), 0.02)

    def test_parts_of_frames_lie_between(self) -> None:
        before, middle, after = (self.picture(frame).max(-1) > 0.02 for frame in (8, 8.5, 9))
        for side in (before, after):
            self.assertLess((side ^ middle).sum(), (before ^ after).sum())
            self.assertGreater((side ^ middle).sum(), 0)

    def test_without_a_garment_it_says_so(self) -> None:
        self.assertIn("There is no garment: copy what Rumple has exported", self.without)
