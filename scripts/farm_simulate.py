# SPDX-License-Identifier: GPL-3.0-or-later
"""A night of a farm in minutes: a Slurm of its own schedules tasks that sleep where bakes would solve.

Everything but the bakes is that of `scripts/farm slurm`: arrays, dependencies, tasks that put themselves back, the
report. How long a garment would take is what was measured (docs/farm.md, What it costs), times its samples.
"""
from __future__ import annotations

import argparse
import json
import random
import shutil
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import farm_jobs

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "blender_tests"))
from support import slurm_instance  # noqa: E402

MILLISECONDS = (114, 185, 33, 91)  # a sample: Wrinkle Mesh, Independent Frames, Field, Paths, on S1's shirt
SAMPLES = (240, 2400)  # of a garment: ten seconds of a shot, to fifty with two samples a frame
IN_A_SHOT, RESTING = 10, 3  # garments of a shot, and how many of these rest on another one
OPENING, CHECKPOINT = 2.0, 20.0  # seconds: Blender opens the file; between two states that are kept
TIMEOUT = 20  # seconds after which this Slurm takes a node for dead


@dataclass
class Found:
    """What became of it. Seconds of the bakes, not of the clock, but for those named so."""

    baked: int
    failed: int  # garments that are broken
    left: int  # that rest on these
    starts: int
    work: float
    lost: float
    ideal: float
    clock: float
    killed: int = 0
    dead: list[str] = field(default_factory=list)

    def text(self, chosen: argparse.Namespace) -> str:
        again, scale = self.starts - self.baked - self.failed, chosen.scale
        rows = [("garments, workers", f"{chosen.garments:,}, {chosen.workers:,}"),
                ("Blenders killed in mid-bake", f"{self.killed} ({100 * chosen.killed:g} % of the starts)"),
                ("nodes that died", f"{len(self.dead)}"), ("baked", f"{self.baked:,}"),
                ("broken garments; not started since they rest on these", f"{self.failed}; {self.left}"),
                ("starts that went on where another was ended", f"{again}"),
                ("work, hours of a processor", f"{self.work / 3600.0:.1f}"),
                ("solved twice", f"{self.lost:.0f} s, {100 * self.lost / self.work:.2f} % of the work"),
                (f"ideal, clock ({scale:g} s for one of the bakes)", f"{self.ideal * scale:.0f} s"),
                ("first start to last end, clock", f"{self.clock:.0f} s"),
                ("the workers solved", f"{100 * self.ideal * scale / self.clock:.0f} % of that time")]
        return "\n".join(["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows)])


# ---------------------------------------------------------------- what there is to do
def shots(folder: Path, chosen: argparse.Namespace) -> list[Path]:
    """The files of a farm that sleeps."""
    chance, files = random.Random(chosen.seed), []
    for first in range(0, chosen.garments, IN_A_SHOT):
        garments: dict[str, Any] = {}
        for number in range(first, min(first + IN_A_SHOT, chosen.garments)):
            names = list(garments)
            needs = [chance.choice(names[:3])] if len(names) >= IN_A_SHOT - RESTING else []
            garments[f"g{number}"] = dict(needs=needs, samples=chance.randint(*SAMPLES),
                                          milliseconds=chance.choice(MILLISECONDS),
                                          broken=chance.random() < chosen.broken)
        files.append(folder / f"shot_{first // IN_A_SHOT:03d}.json")
        files[-1].write_text(json.dumps(dict(scale=chosen.scale, seed=chosen.seed, killed=chosen.killed,
                                             opening=OPENING, checkpoint=CHECKPOINT, garments=garments)))
    return files


def seconds_of(one: dict[str, Any]) -> float:
    return float(one["samples"] * one["milliseconds"] / 1e3 + OPENING)


def ideal(garments: dict[str, dict[str, Any]], workers: int) -> tuple[float, float]:
    """(work, the least time): all workers busy to the end, and no chain of garments longer. Of those that are baked."""
    good = {name: one for name, one in garments.items()
            if not one["broken"] and not any(garments[need]["broken"] for need in one["needs"])}
    work = sum(map(seconds_of, good.values()))
    chains = [seconds_of(one) + sum(seconds_of(garments[need]) for need in one["needs"]) for one in good.values()]
    return work, max(work / workers, max(chains, default=0.0))


# ---------------------------------------------------------------- the night
class Reaper(threading.Thread):
    """Kills nodes that are at work, one after the other, while the farm works."""

    def __init__(self, slurm: slurm_instance.Slurm, chosen: argparse.Namespace, apart: float) -> None:
        super().__init__(daemon=True)
        self.slurm, self.count, self.apart = slurm, chosen.nodes_lost, apart
        self.chance = random.Random(chosen.seed)
        self.died: dict[str, float] = {}  # when

    def run(self) -> None:
        for _ in range(self.count):
            time.sleep(self.apart)
            busy = sorted({node for node in self.slurm.processes().values() if node} - self.died.keys())
            if busy:
                node = self.chance.choice(busy)
                self.died[node] = time.time()
                self.slurm.kill_node(node)


def simulate(chosen: argparse.Namespace) -> int:
    """The exit code: 0 where all that is whole was baked. Raises Refused."""
    _refuse(chosen)
    folder = Path(tempfile.mkdtemp(prefix="rumple-farm-"))
    slurm = slurm_instance.Slurm(folder, chosen.workers, TIMEOUT)
    try:
        files = shots(folder, chosen)
        garments = {name: one for file in files for name, one in json.loads(file.read_text())["garments"].items()}
        work, least = ideal(garments, chosen.workers)
        print(f"{len(garments):,} garments, {work / 3600.0:.1f} hours of a processor, {chosen.workers:,} workers: "
              f"about {least * chosen.scale:.0f} s", flush=True)
        slurm.start()
        reaper = Reaper(slurm, chosen, least * chosen.scale / (chosen.nodes_lost + 1))
        reaper.start()
        jobs = folder / "jobs"
        slurm.run(str(ROOT / "scripts" / "farm"), "slurm", *map(str, files), "--jobs", str(jobs), "--rumple",
                  f"{sys.executable} -IS {ROOT / 'scripts' / 'farm_sleeper.py'}", seconds=600.0)
        slurm.wait_for((jobs / "report.json").is_file, 60.0 + 20.0 * least * chosen.scale)
        found = measured(jobs, garments, work, least, reaper.died, chosen.scale)
        print(found.text(chosen))
        return 0 if found.baked + found.failed + found.left == len(garments) else 1
    finally:
        slurm.stop()
        if chosen.keep is not None:
            shutil.copytree(folder / "jobs", chosen.keep, dirs_exist_ok=True)
        shutil.rmtree(folder, ignore_errors=True)


def _refuse(chosen: argparse.Namespace) -> None:
    """Raises Refused."""
    lacks = slurm_instance.missing()
    if lacks:
        raise farm_jobs.Refused(f"there is no {', '.join(lacks)}: scripts/install farm brings Slurm")
    for name, least, most in (("garments", 1, 10_000), ("workers", 1, 1000), ("nodes_lost", 0, chosen.workers - 1)):
        if not least <= getattr(chosen, name) <= most:
            raise farm_jobs.Refused(f"--{name.replace('_', '-')} is {least} to {most}")
    for name in ("killed", "broken"):
        if not 0.0 <= getattr(chosen, name) <= 0.5:
            raise farm_jobs.Refused(f"--{name} is a share of 0 to 0.5")
    if not 0.0 < chosen.scale <= 1.0:
        raise farm_jobs.Refused("--scale is above 0 and at most 1")


def measured(folder: Path, garments: dict[str, dict[str, Any]], work: float, least: float, died: dict[str, float],
             scale: float) -> Found:
    report = json.loads((folder / "report.json").read_text())
    rows = report["tasks"]
    broken = [row for row in rows if garments[row["object"]]["broken"] and row["code"] == 1]
    left = [row for row in rows if row["why"].startswith("it rests on")]
    starts = [json.loads(line) for path in folder.parent.glob("*.starts") for line in path.read_text().splitlines()]
    deaths = [start["lost"] for start in starts if "lost" in start]
    began = min(row["began"] for row in rows if row["began"])
    return Found(report["baked"], len(broken), len(left), sum("node" in start for start in starts), work,
                 sum(deaths) + _lost_with_nodes(folder.parent, died, scale), least,
                 max(row["ended"] for row in rows) - began, len(deaths), list(died))


def _lost_with_nodes(folder: Path, died: dict[str, float], scale: float) -> float:
    """From the last state that was kept to the death of the node, and opening the file again."""
    lost = 0.0
    for path in folder.glob("*.starts"):
        lines = [json.loads(line) for line in path.read_text().splitlines()]
        for line, after in zip(lines, lines[1:]):
            if "node" in line and "node" in after and line["node"] in died:
                solved = (died[line["node"]] - line["time"]) / scale - OPENING
                lost += OPENING + (solved % CHECKPOINT if solved > 0.0 else solved)
    return lost
