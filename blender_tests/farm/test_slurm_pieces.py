# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips in pieces on a real Slurm: pieces are tasks, joining waits for them, and what rests on a garment for that."""
from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from support.slurm_instance import Slurm

ROOT = Path(__file__).resolve().parents[2]
FRAMES = 12


def run(*command: object) -> None:
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=200, env=os.environ)
    if done.returncode:
        raise AssertionError(done.stdout)


class Pieces(unittest.TestCase):

    def test_joined_clips_have_the_samples_of_one_machine(self) -> None:
        """The pre-roll is as long as the clip; the scarf, whose frames are independent, needs none."""
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        blend, jobs, clips = folder / "shot.blend", folder / "jobs", folder / "rumple"
        run("blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
            ROOT / "blender_tests" / "support" / "farm_scene.py", "--", f"{blend}:{FRAMES}")
        run(ROOT / "scripts" / "rumple", "bake", blend)
        alone = self.samples(clips)
        shutil.rmtree(clips)
        slurm = Slurm(folder / "slurm", 3)
        (folder / "slurm").mkdir()
        self.addCleanup(slurm.stop)
        slurm.start()
        said = slurm.run(str(ROOT / "scripts" / "farm"), "slurm", str(blend), "--jobs", str(jobs), "--pieces", "2",
                         "--pre-roll", str(FRAMES), "--tolerance", "0")
        self.assertIn("4 pieces", said)
        slurm.wait_for((jobs / "report.json").is_file, 240.0)
        report = json.loads((jobs / "report.json").read_text())
        self.assertEqual((report["baked"], report["failed"]), (9, 0), report)
        rows = {(row["object"], row["piece"]): row for row in report["tasks"]}
        for name in ("Sleeve", "Coat", "Scarf/.. a"):
            for piece in ("1/2", "2/2"):
                self.assertGreaterEqual(rows[name, "2"]["began"], rows[name, piece]["ended"])
                self.assertLess(rows[name, piece]["samples"], FRAMES)
        self.assertGreaterEqual(rows["Coat", "1/2"]["began"], rows["Sleeve", "2"]["ended"])
        self.assertEqual({path.suffix for path in clips.iterdir()}, {".pc2"})
        self.assertEqual(self.samples(clips), alone)

    def samples(self, clips: Path) -> dict[str, int]:
        """By clip: a hash of them, without the manifest behind them."""
        found = {}
        for path in clips.iterdir():
            data = path.read_bytes()
            points, samples = (int.from_bytes(data[at:at + 4], "little") for at in (16, 28))
            self.assertEqual(samples, FRAMES)
            found[path.name] = hash(data[:32 + 12 * points * samples])
        self.assertEqual(len(found), 3)
        return found
