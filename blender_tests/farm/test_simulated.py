# SPDX-License-Identifier: GPL-3.0-or-later
"""A tenth of the simulated night: a hundred garments on twenty workers, with Blenders that die and garments that are
broken. Slurm schedules; nothing is left out and nothing is done twice that was kept."""
from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FARM = ROOT / "scripts" / "farm"
sys.path.insert(0, str(ROOT / "scripts"))
import farm_simulate  # noqa: E402


def simulate(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(FARM), "simulate", *words], capture_output=True, text=True, timeout=300)


class Simulated(unittest.TestCase):

    def test_all_that_is_whole_is_baked_and_what_rests_on_the_broken_is_left(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            done = simulate("--garments", "100", "--workers", "20", "--scale", "0.02", "--nodes-lost", "0",
                            "--killed", "0.1", "--broken", "0.05", "--keep", f"{folder}/jobs")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            print(done.stdout)
            rows = json.loads((Path(folder) / "jobs" / "report.json").read_text())["tasks"]
        self.assertEqual(len(rows), 100)
        why = {row["object"]: row["why"] for row in rows if row["why"]}
        broken = {name for name, text in why.items() if text.endswith("see whether its modifier is on")}
        self.assertGreater(len(broken), 1)
        for name, text in why.items():
            rests = {f"it rests on {one}, which was not baked" for one in broken}
            self.assertTrue(name in broken or text in rests, text)
        by_name = {row["object"]: row for row in rows}
        again = [row for row in rows if len(row["nodes"]) > 1]
        self.assertGreater(len(again), 2)
        self.assertGreater(sum(row["resumed"] for row in again), 0)
        for row in rows:
            if not row["why"]:
                self.assertEqual(row["code"], 0)
                self.assertGreater(row["samples"], 0)
        needs = [(row, by_name[need]) for row in rows for need in self.needs(row)]
        for row, need in needs:  # each behind what it rests on
            if row["began"]:
                self.assertGreaterEqual(row["began"], need["ended"])

    @staticmethod
    def needs(row: dict) -> list[str]:
        """As farm_simulate drew them."""
        with tempfile.TemporaryDirectory() as folder:
            chosen = farm_simulate.argparse.Namespace(seed=1, garments=100, broken=0.05, killed=0.1, scale=0.02)
            for file in farm_simulate.shots(Path(folder), chosen):
                garments = json.loads(file.read_text())["garments"]
                if row["object"] in garments:
                    return list(garments[row["object"]]["needs"])
        raise AssertionError(row["object"])

    def test_the_least_time_is_that_of_busy_workers_or_of_the_longest_chain(self) -> None:
        def one(samples: int, *needs: str, broken: bool = False) -> dict:
            return dict(samples=samples, milliseconds=1000, needs=list(needs), broken=broken)
        opening = farm_simulate.OPENING
        garments = dict(a=one(10), b=one(20), c=one(30, "b"), d=one(99, broken=True), e=one(50, "d"))
        work = 60.0 + 3.0 * opening
        self.assertEqual(farm_simulate.ideal(garments, 1), (work, work))
        self.assertEqual(farm_simulate.ideal(garments, 10), (work, 50.0 + 2.0 * opening))

    def test_what_is_lost_with_a_node_is_what_was_not_kept(self) -> None:
        """A state is kept every CHECKPOINT seconds; the file is opened again."""
        opening, checkpoint = farm_simulate.OPENING, farm_simulate.CHECKPOINT
        starts = [dict(time=100.0, node="n1"), dict(time=300.0, node="n2"), dict(time=500.0, node="n1")]
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "shot.a.starts").write_text("".join(json.dumps(start) + "\n" for start in starts))
            for died, scale, lost in (
                    ({"n1": 100.0 + opening + 2.5 * checkpoint}, 1.0, opening + 0.5 * checkpoint),
                    ({"n1": 100.0 + 0.1 * (opening + 2.5 * checkpoint)}, 0.1, opening + 0.5 * checkpoint),
                    ({"n1": 100.0 + 0.5 * opening}, 1.0, 0.5 * opening),  # before it was open
                    ({"n2": 300.0 + opening + 1.0}, 1.0, opening + 1.0), ({"n3": 400.0}, 1.0, 0.0), ({}, 1.0, 0.0)):
                self.assertAlmostEqual(farm_simulate._lost_with_nodes(Path(folder), died, scale), lost)

    def test_words_that_cannot_be_followed(self) -> None:
        for words, said in ((("--workers", "0"), "--workers is 1 to 1000"), (("--killed", "2"), "a share of 0 to 0.5"),
                            (("--scale", "nan"), "--scale is above 0"), (("--garments", "-5"), "--garments is 1 to"),
                            (("--workers", "3", "--nodes-lost", "3"), "--nodes-lost is 0 to 2")):
            done = simulate(*words)
            self.assertEqual((done.returncode, said in done.stderr), (2, True), done.stderr)
