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
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

MOST_IN_ARRAY = 1000  # MaxArraySize of Slurm is 1001 where nobody changed it


class Refused(Exception):
    """Nothing is submitted."""


@dataclass
class Task:
    """One garment."""

    number: int
    file: str
    object: str
    needs: list[int]  # tasks of the garments that it rests on
    frames: int
    bytes: int  # about, of the clip


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


def plan(chosen: argparse.Namespace) -> Jobs:
    """Opens every file once, here, and asks what rests on what. Raises Refused."""
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
    jobs = Jobs(folder, command, options)
    files = [file.absolute() for file in chosen.files]
    with ThreadPoolExecutor(os.cpu_count()) as pool:  # each waits for a Blender
        for file, (done, found) in zip(files, pool.map(lambda file: _listed(jobs, file), files)):
            _add_file(jobs, file, done, found)
    jobs.arrays = _arrays(jobs.tasks)
    jobs.write()
    return jobs


Listed = tuple["subprocess.CompletedProcess[str]", "dict[str, Any] | None"]


def _listed(jobs: Jobs, file: Path) -> Listed:
    done = subprocess.run([*jobs.command, "list", str(file), "--json", *jobs.options], capture_output=True, text=True)
    return done, last_json(done.stdout)


def _add_file(jobs: Jobs, file: Path, done: subprocess.CompletedProcess[str], found: dict[str, Any] | None) -> None:
    if done.returncode or found is None:
        said = [line.removeprefix("Rumple: ") for line in done.stderr.splitlines() if line.startswith("Rumple: ")]
        jobs.faults[str(file)] = " ".join(said) or f"exit code {done.returncode}"
        return
    numbers: dict[str, int] = {}
    for row in found["garments"]:  # each behind those that it rests on
        numbers[row["name"]] = number = len(jobs.tasks)
        frames = (row["end"] - row["start"]) * row["samples"] + 1
        jobs.tasks.append(Task(number, str(file), row["name"], [numbers[name] for name in row["needs"]
                                                                if name in numbers], frames, row["bytes"]))


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
    """One for all that wait for nothing, and one for each set of tasks that others wait for."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for task in tasks:
        groups.setdefault(tuple(sorted(task.needs)), []).append(task.number)
    return [Array(numbers[start:start + MOST_IN_ARRAY], list(needs))
            for needs, numbers in sorted(groups.items(), key=lambda group: max(group[0], default=-1))
            for start in range(0, len(numbers), MOST_IN_ARRAY)]
