# SPDX-License-Identifier: GPL-3.0-or-later
"""A task on a node: bakes one garment, goes on where a former start of it was ended, and leaves what became of it."""
from __future__ import annotations

import hashlib
import json
import os
import platform
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Mapping

from farm_jobs import Jobs, Task, last_json, write_whole

HELD = 75  # of rumple bake: another worker has the clip
MOST_STARTS = 4
PATIENCE = 30.0  # seconds before another worker's clip is tried again


def run(jobs: Jobs, array: int, environment: Mapping[str, str]) -> int:
    """The exit code of the bake."""
    task = jobs.tasks[jobs.arrays[array].tasks[int(environment["SLURM_ARRAY_TASK_ID"])]]
    node = environment.get("SLURMD_NODENAME") or platform.node()
    with open(jobs.folder / "starts" / str(task.number), "a") as starts:
        starts.write(f"{node}\n")
    began = time.time()
    code, said, complaints = _bake(jobs, task)
    if (code == HELD or code < 0) and _starts_again(jobs, task, code, environment):
        return 0  # the queue ends this start now
    result = dict(code=code, node=node, began=began, ended=time.time(), errors=complaints)
    if said is not None:
        result |= said.get("garments", {}).get(task.object, {})
        if result.get("clip"):
            result["sha256"] = _digest(Path(str(result["clip"])))
    result["code"] = code
    write_whole(jobs.folder / "results" / f"{task.number}.json", json.dumps(result, indent=1))
    return code if code >= 0 else 128 - code


def _digest(clip: Path) -> str:
    """In blocks: a clip may be larger than the memory of a job."""
    digest = hashlib.sha256()
    with open(clip, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def _bake(jobs: Jobs, task: Task) -> tuple[int, dict[str, Any] | None, list[str]]:
    """Exit code (negative: ended by that signal), what it said to machines, what it complained of."""
    command = [*jobs.command, "bake", task.file, f"--object={task.object}", "--resume", "--json", *task.words,
               *jobs.options]
    name = f"{jobs.folder}:{task.number}"  # the same in every start
    complaints = jobs.folder / "logs" / f"task-{task.number}.err"
    with open(complaints, "w") as err:
        worker = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=err, text=True, errors="replace",
                                  env={**os.environ, "RUMPLE_TASK": name})
        signal.signal(signal.SIGTERM, lambda _signal, _frame: worker.terminate())
        said = []
        assert worker.stdout is not None
        for line in worker.stdout:
            sys.stdout.write(line)
            sys.stdout.flush()
            said.append(line)
        code = worker.wait()
    text = complaints.read_text(errors="replace")
    sys.stderr.write(text)
    return code, last_json("".join(said)), [line.removeprefix("Rumple: ") for line in text.splitlines()
                                            if line.startswith("Rumple: ")]


def _starts_again(jobs: Jobs, task: Task, code: int, environment: Mapping[str, str]) -> bool:
    """Let the queue start it again: Blender was killed, or another worker has the clip."""
    if len(jobs.starts(task)) >= MOST_STARTS:
        return False
    if code == HELD:
        time.sleep(PATIENCE)
    name = f"{environment['SLURM_ARRAY_JOB_ID']}_{environment['SLURM_ARRAY_TASK_ID']}"
    print(f"{task.object}: {'another worker has it' if code == HELD else f'killed by signal {-code}'}, started again")
    sys.stdout.flush()
    return subprocess.run(["scontrol", "requeue", name]).returncode == 0
