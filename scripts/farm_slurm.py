# SPDX-License-Identifier: GPL-3.0-or-later
"""Job arrays for Slurm: written into the folder of the jobs, so that they can be read, and submitted by sbatch."""
from __future__ import annotations

import shlex
import subprocess
from pathlib import Path

from farm_jobs import Array, Jobs, Refused

FARM = Path(__file__).resolve().parent / "farm"


def script(jobs: Jobs, number: int | None, more: list[str]) -> str:
    """Of an array, or of the report (None)."""
    log = jobs.folder / "logs"
    options = [f"--output={log}/report-%j.log", "--job-name=rumple-report"]
    words = [str(FARM), "report", str(jobs.folder)]
    if number is not None:
        # A worker that dies: the task starts again elsewhere. A garment that fails: what rests on it never starts.
        options = [f"--array=0-{len(jobs.arrays[number].tasks) - 1}", f"--output={log}/%A_%a.log",
                   f"--job-name=rumple-{number}", "--requeue", "--open-mode=append", "--kill-on-invalid-dep=yes"]
        words = [str(FARM), "run", str(jobs.folder), str(number)]
    lines = ["#!/bin/bash", *(f"#SBATCH {shlex.quote(option)}" for option in ["--ntasks=1", *options, *more])]
    return "\n".join([*lines, f"exec {shlex.join(words)}", ""])


def write_scripts(jobs: Jobs, more: list[str]) -> None:
    """more: options for sbatch, of every job."""
    for number in range(len(jobs.arrays)):
        _path(jobs, number).write_text(script(jobs, number, more))
    _path(jobs, None).write_text(script(jobs, None, more))


def _path(jobs: Jobs, number: int | None) -> Path:
    return jobs.folder / ("report.sh" if number is None else f"array-{number}.sh")


def submit(jobs: Jobs) -> int:
    """Every array behind those that it waits for, or none. The exit code. Raises Refused."""
    try:
        return _submit(jobs)
    except Refused:
        submitted = [array.job for array in jobs.arrays if array.job]
        if submitted:
            subprocess.run(["scancel", *submitted])
        raise


def _submit(jobs: Jobs) -> int:
    started: dict[int, str] = {}  # by task: job and index
    for number, array in enumerate(jobs.arrays):
        wait = [f"--dependency=afterok:{':'.join(started[task] for task in array.needs)}"] if array.needs else []
        array.job = _sbatch(_path(jobs, number), wait)
        started |= {task: f"{array.job}_{index}" for index, task in enumerate(array.tasks)}
        jobs.write()
        after = f", after {', '.join(started[task] for task in array.needs)}" if array.needs else ""
        print(f"job {array.job}: {len(array.tasks)} {_what(jobs, array)}{after}")
    for file, why in jobs.faults.items():
        print(f"{file} FAILED: {why}")
    ids = ":".join(array.job for array in jobs.arrays)
    last = _sbatch(_path(jobs, None), [f"--dependency=afterany:{ids}"] if ids else [])
    print(f"job {last}: the report, {jobs.folder / 'report.md'}")
    return 1 if jobs.faults else 0


def _what(jobs: Jobs, array: Array) -> str:
    return "pieces" if any("/" in jobs.tasks[task].piece for task in array.tasks) else "garments"


def _sbatch(file: Path, options: list[str]) -> str:
    """The number of the job."""
    try:
        done = subprocess.run(["sbatch", "--parsable", *options, str(file)], capture_output=True, text=True)
    except OSError as error:
        raise Refused(f"sbatch cannot be run ({error}): submit where Slurm is installed, or give --dry-run") from error
    if done.returncode:
        raise Refused(f"sbatch refused {file}: {done.stderr.strip()}")
    return done.stdout.strip().split(";")[0]
