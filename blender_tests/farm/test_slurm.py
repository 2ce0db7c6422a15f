# SPDX-License-Identifier: GPL-3.0-or-later
"""A real Slurm bakes four small shots on four nodes, while a node dies, another is drained, and a garment is broken."""
from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from support.slurm_instance import Slurm

ROOT = Path(__file__).resolve().parents[2]
FRAMES = {"shot_a": 120, "shot_b": 20, "shot_c": 20, "shot_d": 20}
BROKEN = "shot_d"  # its Sleeve is
GARMENTS = 3
KEPT = 15  # samples, at least, of what is killed


class Farm(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.files = [cls.folder / "shots" / f"{name}.blend" for name in FRAMES]
        scenes = [f"{file}:{FRAMES[file.stem]}" + ":Sleeve" * (file.stem == BROKEN) for file in cls.files]
        cls.files[0].parent.mkdir()
        _run("blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
             str(ROOT / "blender_tests" / "support" / "farm_scene.py"), "--", *scenes)
        shutil.copytree(cls.files[0].parent, cls.folder / "alone")
        (cls.folder / "slurm").mkdir()
        cls.slurm = Slurm(cls.folder / "slurm", 4)
        cls.addClassCleanup(cls.slurm.stop)
        cls.slurm.start()

    def test_all_but_the_broken_end_whole_with_the_bits_of_one_machine(self) -> None:
        jobs, slurm = self.folder / "jobs", self.slurm
        said = slurm.run(str(ROOT / "scripts" / "farm"), "slurm", *map(str, self.files), "--jobs", str(jobs))
        self.assertIn("8 garments", said)
        killed, (victim, survivor) = self.wait_for_two_long_bakes()
        drained = next(node for node in slurm.nodes if node not in (victim, survivor))
        before = self.drain(drained, jobs)
        slurm.kill_node(victim)
        os.kill(killed, signal.SIGKILL)  # Blender alone, on a node that lives on
        slurm.wait_for((jobs / "report.json").is_file, 600.0)  # a minute, where the machine is idle
        report = json.loads((jobs / "report.json").read_text())
        if "RUMPLE_OUT" in os.environ:
            shutil.copy(jobs / "report.md", Path(os.environ["RUMPLE_OUT"]) / "slurm_report.md")
        self.check_failures(report)
        self.assertEqual(self.hashes(self.folder / "shots"), self.hashes_alone())
        self.check_nodes(report, jobs, (victim, survivor), drained, before)

    def wait_for_two_long_bakes(self) -> tuple[int, list[str]]:
        """Two garments of the first shot have some frames: the process of the second, and the nodes of both.

        Whoever is first is stopped until the other is there: on a fast machine it would be done by then.
        """
        clips, held = self.folder / "shots" / "rumple", set[int]()

        def both_held() -> bool:
            for path in clips.glob(".shot_a-*.journal"):
                process = int(path.name.rsplit(".", 2)[1].split("-")[0])
                if process not in held and len(path.read_bytes().splitlines()) > KEPT:
                    os.kill(process, signal.SIGSTOP)
                    held.add(process)
            return len(held) == 2

        self.slurm.wait_for(both_held, 120.0)
        nodes = self.slurm.processes()
        return max(held), [nodes[process] for process in (min(held), max(held))]

    def drain(self, node: str, jobs: Path) -> int:
        """What had started there. A job that Slurm had given to the node before may write that it starts after."""
        self.slurm.run("scontrol", "update", f"NodeName={node}", "State=DRAIN", "Reason=test")
        self.slurm.wait_for(lambda: self.slurm.run("sinfo", "-h", "-n", node, "-o", "%T").strip() == "drained", 120.0)
        return self.starts(jobs).count(node)

    @staticmethod
    def starts(jobs: Path) -> list[str]:
        """The nodes of all starts so far."""
        return [node for path in (jobs / "starts").iterdir() for node in path.read_text().split()]

    def check_failures(self, report: dict) -> None:
        """Those of the broken garment, and why."""
        self.assertEqual((report["baked"], report["failed"]), (GARMENTS * len(FRAMES) - 2, 2))
        failed = {(Path(row["file"]).stem, row["object"]): row["why"] for row in report["tasks"] if row["why"]}
        self.assertEqual(set(failed), {(BROKEN, "Sleeve"), (BROKEN, "Coat")})
        self.assertIn("nothing is solved at frame 1: see whether its modifier is on", failed[BROKEN, "Sleeve"])
        self.assertEqual(failed[BROKEN, "Coat"], "it rests on Sleeve, which was not baked")

    def hashes_alone(self) -> dict[str, str]:
        """The same files on one machine."""
        files = sorted((self.folder / "alone").glob("*.blend"))
        bakes = [subprocess.Popen([ROOT / "scripts" / "rumple", "bake", file], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL) for file in files]
        self.assertEqual([bake.wait(120) for bake in bakes], [int(file.stem == BROKEN) for file in files])
        return self.hashes(self.folder / "alone")

    def hashes(self, folder: Path) -> dict[str, str]:
        """By clip. Nothing else is left in the folder."""
        found = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in (folder / "rumple").iterdir()}
        self.assertEqual({Path(name).suffix for name in found}, {".pc2"})
        self.assertEqual(len(found), GARMENTS * len(FRAMES) - 2)
        return found

    def check_nodes(self, report: dict, jobs: Path, died: tuple[str, str], drained: str, before: int) -> None:
        """What died was started again, not on the node that is gone, and went on; the drained node got nothing new."""
        again = [row for row in report["tasks"] if len(row["nodes"]) > 1]
        self.assertLessEqual(set(died), {row["nodes"][0] for row in again})  # a slow machine may lose more
        for row in again:
            self.assertNotIn(died[0], row["nodes"][1:])
            if Path(row["file"]).stem == "shot_a" and row["nodes"][0] in died:
                self.assertGreaterEqual(row["resumed"], KEPT)
        self.assertEqual(self.starts(jobs).count(drained), before)


def _run(*command: str) -> None:
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120,
                          env=os.environ)
    if done.returncode:
        raise AssertionError(done.stdout)
