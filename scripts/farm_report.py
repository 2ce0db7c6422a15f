# SPDX-License-Identifier: GPL-3.0-or-later
"""What became of all tasks, and why: report.md to read, report.json for machines."""
from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from farm_jobs import Jobs, Task, write_whole

HEAD = ("garment", "file", "node", "starts", "samples", "resumed", "s", "ms a sample", "MB", "what became of it")


def write(jobs: Jobs) -> int:
    """The exit code: 0 where all are baked."""
    rows = [_row(jobs, task) for task in jobs.tasks]
    failed = [row for row in rows if row["why"]]
    data = dict(baked=len(rows) - len(failed), failed=len(failed) + len(jobs.faults), faults=jobs.faults, tasks=rows)
    write_whole(jobs.folder / "report.json", json.dumps(data, indent=1))
    text = _text(jobs, rows, failed)
    write_whole(jobs.folder / "report.md", text)
    print(text)
    return 1 if data["failed"] else 0


def _row(jobs: Jobs, task: Task) -> dict[str, Any]:
    found, starts = jobs.result(task) or {}, jobs.starts(task)
    return dict(object=task.object, piece=task.piece, file=task.file, nodes=starts, samples=found.get("samples", 0),
                resumed=found.get("resumed", 0), passed=found.get("passed", 0), seconds=found.get("seconds", 0.0),
                bytes=found.get("bytes", 0), clip=found.get("clip", ""), sha256=found.get("sha256", ""),
                began=found.get("began", 0.0), ended=found.get("ended", 0.0), code=found.get("code"),
                why=_why(jobs, task, found, starts))


def _name(row: dict[str, Any]) -> str:
    return f"{row['object']} {row['piece']}" if "/" in row["piece"] else str(row["object"])


def _why(jobs: Jobs, task: Task, found: dict[str, Any], starts: list[str]) -> str:
    """Why there is no clip; empty where there is one."""
    if found.get("code") == 0:
        return ""
    for number in task.needs:
        need = jobs.tasks[number]
        if (jobs.result(need) or {}).get("code") != 0:
            if need.object == task.object:
                return f"piece {need.piece} was not baked"
            return f"it rests on {need.object}, which was not baked"
    if found:
        said = [line for line in found["errors"] if " FAILED: " in line or " not baked: " in line]
        return found.get("error") or "; ".join(said or found["errors"][-1:]) or f"exit code {found['code']}"
    return f"started {len(starts)} times, and ended each time before it could say why" if starts else "never started"


def _text(jobs: Jobs, rows: list[dict[str, Any]], failed: list[dict[str, Any]]) -> str:
    lines = [f"# {len(rows) - len(failed)} of {len(rows)} garments baked", ""]
    lines += [f"- **{Path(file).name}** cannot be baked: {why}" for file, why in jobs.faults.items()]
    lines += [f"- **{_name(row)}** of {Path(row['file']).name} is not baked: {row['why']}" for row in failed]
    lines += [""] * bool(failed or jobs.faults) + [f"| {' | '.join(HEAD)} |", f"|{'---|' * len(HEAD)}"]
    for row in rows:
        solved = row["samples"] - row["passed"]
        cells = (_name(row), Path(row["file"]).name, ", ".join(row["nodes"]), len(row["nodes"]), row["samples"],
                 row["resumed"], f"{row['seconds']:.2f}", f"{1e3 * row['seconds'] / max(solved, 1):.0f}",
                 f"{row['bytes'] / 2**20:.1f}", row["why"] or "baked")
        lines.append(f"| {' | '.join(str(cell).replace('|', '/') for cell in cells)} |")
    began = [row["began"] for row in rows if row["began"]]
    wall = max((row["ended"] for row in rows), default=0.0) - min(began) if began else 0.0
    lines += ["", f"{sum(row['seconds'] for row in rows):.1f} s of bakes in {wall:.1f} s, "
              f"{sum(row['bytes'] for row in rows) / 2**20:.1f} MB"]
    return "\n".join(lines) + "\n"
