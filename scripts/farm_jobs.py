# SPDX-License-Identifier: GPL-3.0-or-later
"""What is to be baked, as tasks and arrays of tasks, in a folder that every node sees.

tasks.json: everything, written once. logs/: what the tasks say. starts/N: a line for every start of task N.
results/N.json: what became of it.
"""
from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

MOST_IN_ARRAY = 1000  # MaxArraySize of Slurm is 1001 where nobody changed it
LEAST_IN_ARRAY, ARRAYS = 50, 8  # what waits for nothing is in about so many arrays, none of them smaller


class Refused(Exception):
    """Nothing is submitted."""


@dataclass
class Task:
    """One garment, or a piece of it."""

    number: int
    file: str
    object: str
    needs: list[int]  # tasks of the garments that it rests on
    frames: int
    bytes: int  # about, of the clip
    piece: str = ""  # "2/4": one of four; "4": their joining; empty: the whole clip
    words: list[str] = field(default_factory=list)  # of its bake

    @property
    def name(self) -> str:
        """For reports."""
        return f"{self.object} {self.piece}" if "/" in self.piece else self.object


@dataclass
class Array:
    """Tasks that wait for the same ones."""

    tasks: list[int]
    needs: list[int]
    job: str = ""  # of the queue


@dataclass
class Jobs:
    """A folder of jobs."""

    folder: Path
    command: list[str]  # how Rumple is called
    options: list[str]  # of every bake
    tasks: list[Task] = field(default_factory=list)
    arrays: list[Array] = field(default_factory=list)
    faults: dict[str, str] = field(default_factory=dict)  # files that cannot be baked at all, and why

    @classmethod
    def read(cls, folder: Path) -> "Jobs":
        try:
            data = json.loads((folder / "tasks.json").read_text())
            return cls(folder, data["command"], data["options"], [Task(**task) for task in data["tasks"]],
                       [Array(**array) for array in data["arrays"]], data["faults"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise Refused(f"{folder} has no tasks of scripts/farm: {error}") from error

    def write(self) -> None:
        data = asdict(self)
        del data["folder"]
        write_whole(self.folder / "tasks.json", json.dumps(data, indent=1))

    def result(self, task: Task) -> dict[str, Any] | None:
        """What became of a task; None where it has not ended by itself."""
        try:
            data = json.loads((self.folder / "results" / f"{task.number}.json").read_text())
        except (OSError, ValueError):
            return None
        return data if isinstance(data, dict) else None

    def starts(self, task: Task) -> list[str]:
        """The node of every start."""
        try:
            return (self.folder / "starts" / str(task.number)).read_text().splitlines()
        except OSError:
            return []


def write_whole(file: Path, text: str) -> None:
    """By one rename."""
    temporary = file.with_name(f".{file.name}.{os.getpid()}")
    temporary.write_text(text)
    os.replace(temporary, file)


@dataclass
class Cut:
    """Into how many pieces clips are cut, where their frames allow it."""

    count: int = 1
    pre_roll: int = 0
    tolerance: float | None = None

    @classmethod
    def of(cls, chosen: argparse.Namespace) -> "Cut":
        """Raises Refused."""
        cut = cls(getattr(chosen, "pieces", 1), getattr(chosen, "pre_roll", 0), getattr(chosen, "tolerance", None))
        if cut.count < 1 or cut.pre_roll < 0 or cut.count > MOST_IN_ARRAY:
            raise Refused(f"--pieces is 1 to {MOST_IN_ARRAY}, and --pre-roll no less than 0 frames")
        if (cut.tolerance is None) != (cut.pre_roll == 0) or cut.count == 1 and cut.pre_roll:
            raise Refused("--pre-roll and --tolerance go together, and with --pieces")
        return cut

    def tasks(self, whole: Task, kind: str, frames: int, number: int) -> list[Task]:
        """The task itself, or its pieces and what joins them. kind: "independent", "pre-roll", or empty: not at all.
        frames: between its first and its last. number: of the first task."""
        count = min(self.count, frames) if kind == "independent" or (kind and self.pre_roll) else 1
        if count < 2:
            return [replace(whole, number=number)]
        words = [f"--pre-roll={self.pre_roll}", f"--tolerance={self.tolerance:g}"] if self.pre_roll else []
        pieces = [replace(whole, number=number + i, frames=whole.frames // count, bytes=whole.bytes // count,
                          piece=f"{i + 1}/{count}", words=[f"--piece={i + 1}/{count}", *words]) for i in range(count)]
        return [*pieces, replace(whole, number=number + count, frames=1, bytes=0, piece=str(count),
                                 needs=[piece.number for piece in pieces], words=[f"--join={count}", *words])]


def plan(chosen: argparse.Namespace) -> Jobs:
    """Opens every file once, here, and asks what rests on what. Raises Refused."""
    Cut.of(chosen)  # before anything is made
    folder = chosen.jobs.absolute()
    command = shlex.split(chosen.rumple)
    if chosen.blender and Path(command[0] if command else "").name != "rumple":
        raise Refused("--blender goes with scripts/rumple: another --rumple names its Blender itself")
    try:
        folder.mkdir(parents=True)
        for name in ("logs", "starts", "results"):
            (folder / name).mkdir()
    except OSError as error:
        raise Refused(f"{folder}: {os.strerror(error.errno or 0).lower()}: give a new folder with --jobs") from error
    options = ["--blender", chosen.blender] if chosen.blender else []
    if chosen.frames:
        options.append(f"--frames={chosen.frames}")
    if chosen.out:
        options.append(f"--out={chosen.out.absolute()}")
    if chosen.enable_autoexec:
        options.append("--enable-autoexec")
    jobs, cut = Jobs(folder, command, options), Cut.of(chosen)
    files = [file.absolute() for file in chosen.files]
    with ThreadPoolExecutor(os.cpu_count()) as pool:  # each waits for a Blender
        for file, (done, found) in zip(files, pool.map(lambda file: _listed(jobs, file), files)):
            _add_file(jobs, file, cut, done, found)
    jobs.arrays = _arrays(jobs.tasks)
    jobs.write()
    return jobs


Listed = tuple["subprocess.CompletedProcess[str]", "dict[str, Any] | None"]


def _listed(jobs: Jobs, file: Path) -> Listed:
    done = subprocess.run([*jobs.command, "list", str(file), "--json", *jobs.options], capture_output=True, text=True)
    return done, last_json(done.stdout)


def _add_file(jobs: Jobs, file: Path, cut: Cut, done: subprocess.CompletedProcess[str],
              found: dict[str, Any] | None) -> None:
    if done.returncode or found is None:
        said = [line.removeprefix("Rumple: ") for line in done.stderr.splitlines() if line.startswith("Rumple: ")]
        jobs.faults[str(file)] = " ".join(said) or f"exit code {done.returncode}"
        return
    numbers: dict[str, int] = {}
    for row in found["garments"]:  # each behind those that it rests on
        needs = [numbers[name] for name in row["needs"] if name in numbers]
        frames = (row["end"] - row["start"]) * row["samples"] + 1
        whole = Task(0, str(file), row["name"], needs, frames, row["bytes"])
        for task in cut.tasks(whole, row.get("cut", ""), row["end"] - row["start"], len(jobs.tasks)):
            jobs.tasks.append(task)
        numbers[row["name"]] = jobs.tasks[-1].number


def last_json(text: str) -> dict[str, Any] | None:
    """Of what a command said."""
    for line in reversed(text.splitlines()):
        line = line.removeprefix("Rumple: ")
        if line.startswith("{"):
            try:
                data = json.loads(line)
            except ValueError:
                return None
            return data if isinstance(data, dict) else None
    return None


def _arrays(tasks: list[Task]) -> list[Array]:
    """Of tasks that wait for the same ones, in the order in which they are submitted, and so begin.

    First is what has the most before it: a task, and the longest chain of those that wait for it. So each array is
    behind those that it waits for, and what waits for nothing is in several, for others to come between them.
    """
    ahead = _ahead(tasks)
    groups: dict[tuple[int, ...], list[int]] = {}
    for task in sorted(tasks, key=lambda task: -ahead[task.number]):
        groups.setdefault(tuple(sorted(task.needs)), []).append(task.number)
    arrays = []
    for needs, numbers in groups.items():
        size = min(MOST_IN_ARRAY, max(LEAST_IN_ARRAY, -(-len(numbers) // ARRAYS)))
        arrays += [Array(numbers[start:start + size], list(needs)) for start in range(0, len(numbers), size)]
    return sorted(arrays, key=lambda array: -ahead[array.tasks[0]])


def _ahead(tasks: list[Task]) -> list[float]:
    """For each task, what is to be done from its beginning on: bytes, or samples where a clip's size is not known."""
    by_bytes = all(task.bytes or task.piece for task in tasks)
    ahead = [float(max(task.bytes if by_bytes else task.frames, 1)) for task in tasks]
    for task in reversed(tasks):  # each is behind those that it waits for, and what waits for it is counted already
        for need in task.needs:
            own = tasks[need].bytes if by_bytes else tasks[need].frames
            ahead[need] = max(ahead[need], max(own, 1) + ahead[task.number])
    return ahead
