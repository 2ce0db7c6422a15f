# SPDX-License-Identifier: GPL-3.0-or-later
"""Published USD, read by another program (tinyusdz, of npm): every frame is that of the baked clip."""
from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import numpy as np
from rumple.core.files import clip_file, clip_partial
from test_queues import ROOT, RUMPLE, Case, said_by

READER = ROOT / "blender_tests" / "support" / "read_usd.mjs"
VERSION = "0.9.0-rc10"
MOST = 1e-6  # object units, here metres


class Usd(Case):

    def read(self, file: Path) -> dict:
        library = self.folder / "npm"
        try:
            done = subprocess.run(["npm", "install", "--prefix", str(library), "--ignore-scripts", "--no-audit",
                                   "--omit=peer", f"tinyusdz@{VERSION}"], capture_output=True, text=True, timeout=120)
        except (OSError, subprocess.TimeoutExpired) as error:
            self.skipTest(f"NOT TESTED: npm: {error}")
        if done.returncode:
            self.skipTest(f"NOT TESTED: tinyusdz cannot be had: {done.stderr[-200:]}")
        return json.loads(said_by("node", READER, library, file))

    @staticmethod
    def samples(text: str, attribute: str) -> dict[int, np.ndarray]:
        """(n, 3) of every frame, as the reader has it."""
        block = re.search(rf" {attribute}\.timeSamples = {{\n(.*?)\n\s*}}", text, re.DOTALL)[1]
        return {int(frame): np.array(re.findall(r"-?[\d.]+(?:e-?\d+)?", values), float).reshape(-1, 3)
                for frame, values in re.findall(r"(\d+): \[(.*?)\]", block)}

    def test_another_reader_has_every_frame_of_the_clip(self) -> None:
        said_by(RUMPLE, "bake", self.blend)
        said_by(RUMPLE, "publish", self.blend, "--attributes", "--object", "Coat")
        (file,) = (self.folder / "publish").iterdir()
        self.assertRegex(file.name, r"^shot-Coat-[0-9a-f]{8}-1-6\.usda$")
        seen = self.read(file)
        self.assertEqual((seen["meshes"], seen["path"]), (1, "/Coat/mesh"))
        clip = next((self.folder / "rumple").glob("shot-Coat-*.pc2"))
        manifest = clip_file.read_manifest(clip)
        baked = [clip_partial.points_in(clip, manifest, sample)[:manifest.vertices].astype(float)
                 for sample in range(manifest.sample_count)]
        points, velocities = self.samples(seen["text"], "points"), self.samples(seen["text"], "velocities")
        self.assertEqual((list(points), list(velocities)), ([1, 2, 3, 4, 5, 6],) * 2)
        for frame, positions in enumerate(baked, 1):
            self.assertLess(np.abs(points[frame] - positions).max(), MOST)
        for frame, (first, last) in {1: (0, 1), 3: (1, 3), 6: (4, 5)}.items():
            moved = (baked[last] - baked[first]) * 24.0 / (last - first)
            self.assertLess(np.abs(velocities[frame] - moved).max(), 24.0 * MOST)
            self.assertGreater(np.abs(moved).max(), 0.01)
        for name in ("texCoord2f[] primvars:st", "primvars:rumple_offset", "normals.timeSamples", "rumple_source"):
            self.assertIn(name, seen["text"])
