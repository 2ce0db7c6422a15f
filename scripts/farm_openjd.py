# SPDX-License-Identifier: GPL-3.0-or-later
"""Job templates of Open Job Description, version 2023-09 (Deadline Cloud and others): one for each file."""
from __future__ import annotations

import json
import unicodedata
from pathlib import Path
from typing import Any

from farm_jobs import Array, Jobs, write_whole

FILE = "{{Param.BlendFile}}"
OUT = "--out="
GRACE = 30  # seconds from SIGTERM to the end: a sample is solved in less
MOST_TASKS = 1024  # values of a parameter


def write(jobs: Jobs) -> list[Path]:
    """The templates. A name that the format cannot hold is a fault of its file."""
    written = []
    for number, file in enumerate(dict.fromkeys(task.file for task in jobs.tasks)):
        names = [task.object for task in jobs.tasks if task.file == file]
        bad = [name for name in names if "{{" in name]
        if bad:
            jobs.faults[file] = f"the name {bad[0]!r} has two braces, which Open Job Description takes for its own"
            continue
        target = jobs.folder / f"{number}-{Path(file).stem}.template.json"
        write_whole(target, json.dumps(template(jobs, file), indent=1))
        written.append(target)
    jobs.write()
    return written


def template(jobs: Jobs, file: str) -> dict[str, Any]:
    """A step for the garments that rest on nothing and that nothing rests on, and one for every other."""
    needed = {number for task in jobs.tasks for number in task.needs}
    groups = [Array([number], list(array.needs)) if number in needed or array.needs else None
              for array in jobs.arrays for number in array.tasks if jobs.tasks[number].file == file]
    alone = [task.number for task in jobs.tasks if task.file == file and task.number not in needed and not task.needs]
    steps = [Array(alone[start:start + MOST_TASKS], []) for start in range(0, len(alone), MOST_TASKS)]
    steps += [group for group in groups if group is not None]
    names = {number: _step_name(jobs, place, step) for place, step in enumerate(steps) for number in step.tasks}
    return dict(
        specificationVersion="jobtemplate-2023-09", name=_printable(f"Wrinkles of {Path(file).stem}", 128),
        parameterDefinitions=_parameters(jobs, file),
        jobEnvironments=[dict(name="Worker check", script=dict(actions=dict(
            onEnter=_action(jobs, "check", ["--to-bake"]))))],
        steps=[_step(jobs, step, names) for step in steps])


def _parameters(jobs: Jobs, file: str) -> list[dict[str, Any]]:
    found = [dict(name="BlendFile", type="PATH", objectType="FILE", dataFlow="IN", default=file)]
    return found + [dict(name="ClipFolder", type="PATH", objectType="DIRECTORY", dataFlow="OUT",
                         default=option.removeprefix(OUT)) for option in jobs.options if option.startswith(OUT)]


def _step(jobs: Jobs, step: Array, names: dict[int, str]) -> dict[str, Any]:
    garments = [jobs.tasks[number].object for number in step.tasks]
    found: dict[str, Any] = dict(name=names[step.tasks[0]])
    if step.needs:
        found["dependencies"] = [dict(dependsOn=name) for name in dict.fromkeys(names[need] for need in step.needs)]
    found["parameterSpace"] = dict(taskParameterDefinitions=[dict(name="Garment", type="STRING", range=garments)])
    found["script"] = dict(actions=dict(onRun=_action(jobs, "bake", ["--object={{Task.Param.Garment}}", "--resume"])))
    return found


def _action(jobs: Jobs, kind: str, more: list[str]) -> dict[str, Any]:
    options = [f"{OUT}{{{{Param.ClipFolder}}}}" if option.startswith(OUT) else option for option in jobs.options]
    return dict(command=jobs.command[0], args=[*jobs.command[1:], kind, FILE, *more, *options],
                cancelation=dict(mode="NOTIFY_THEN_TERMINATE", notifyPeriodInSeconds=GRACE))


def _step_name(jobs: Jobs, place: int, step: Array) -> str:
    return _printable(f"{place + 1} {', '.join(jobs.tasks[number].object for number in step.tasks)}", 64)


def _printable(text: str, most: int) -> str:
    return "".join(letter for letter in text if unicodedata.category(letter) != "Cc").replace("{{", "{ {")[:most]
