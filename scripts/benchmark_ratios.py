# SPDX-License-Identifier: GPL-3.0-or-later
"""How many times as long as ours a rival's work takes: measured in turns, and compared with what was stored last.

    PYTHONPATH=build/release/python python3 scripts/benchmark_ratios.py build/release/rumple_benchmarks [--store]

Times are of the processor, the least of several rounds: so other load of the machine counts little. A ratio that fell
by more than a fifth is said, and fails nothing: timing is no test. Fails where there is no store, or none that can be
read. --store: what is measured now is what later runs are compared with.
"""
from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import benchmark_native
import benchmark_numpy

HERE = Path(__file__).resolve().parent
STORE = HERE / "benchmark_ratios.json"
FALL = 0.2  # share of a ratio that it may lose before it is said
ROUNDS = 3
IN_BLENDER = re.compile(r"^RATIO ([\d.]+) (.+)$", re.MULTILINE)


class StoreError(Exception):
    """Why there is nothing to compare with."""


def read_store(path: Path) -> dict[str, float]:
    """Ratios by name. Raises StoreError."""
    try:
        stored = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise StoreError(f"{path}: {error}") from error
    if not isinstance(stored, dict) or not stored:
        raise StoreError(f"{path}: expected ratios by name")
    for name, ratio in stored.items():
        if type(ratio) not in (int, float) or not math.isfinite(ratio) or ratio <= 0.0:
            raise StoreError(f"{path}: {name}: expected a number above 0, got {ratio!r}")
    return stored


def compare(now: dict[str, float], stored: dict[str, float]) -> tuple[list[str], list[str]]:
    """The table, a line each, and what fell, in sentences."""
    lines, fallen = [f"{'rival over ours':70} {'stored':>8} {'now':>8}"], []
    for name in sorted({*now, *stored}):
        before, after = (f"{ratios[name]:.3g}" if name in ratios else "-" for ratios in (stored, now))
        fell = name in now and name in stored and now[name] < (1.0 - FALL) * stored[name]
        if fell:
            fallen.append(f"{name}: {before} -> {after}")
        note = "FELL" if fell else "not measured here" if name not in now else "" if name in stored else "new"
        lines.append(f"{name:70} {before:>8} {after:>8}  {note}".rstrip())
    return lines, fallen


def native_times(program: str, names: dict[str, str]) -> dict[str, float]:
    """Milliseconds of what there is of these benchmarks."""
    text = subprocess.run([program, f"--benchmark_filter=^({'|'.join(names)})$", "--benchmark_format=json",
                           "--benchmark_repetitions=5", "--benchmark_min_time=0.1",
                           "--benchmark_enable_random_interleaving=true"],
                          check=True, capture_output=True, text=True).stdout
    times: dict[str, float] = {}
    for row in json.loads(text)["benchmarks"]:
        if row["run_type"] == "iteration":
            name = names[row["run_name"]]
            times[name] = min(row["cpu_time"], times.get(name, math.inf))
    return times


def mesh_ratios(program: str) -> dict[str, float]:
    """The step of the paper beside NumPy's, the solve alone beside Bullet's."""
    names = {benchmark_numpy.NATIVE: "step", "solve_step/only_solve_limit/1": "solve", "bullet_cloth": "Bullet"}
    step, times = benchmark_numpy.numpy_step(), dict.fromkeys((*names.values(), "NumPy"), math.inf)
    for _ in range(ROUNDS):
        for name, milliseconds in native_times(program, names).items():
            times[name] = min(milliseconds, times[name])
        times["NumPy"] = min(benchmark_numpy.best(step), times["NumPy"])
    ratios = {"Wrinkle Mesh, 32,768 triangles, a step: NumPy": times["NumPy"] / times["step"]}
    if math.isfinite(times["Bullet"]):
        ratios["Wrinkle Mesh, 32,768 triangles, the solve: Bullet"] = times["Bullet"] / times["solve"]
    return ratios


def other_ratios() -> dict[str, float]:
    """Of the Wrinkle Maps and the Wrinkle Field beside NumPy."""
    ratios = {}
    pairs = {"Wrinkle Maps, 50,000 triangles": benchmark_native.maps_steps(50_000, 100, 8)}
    pairs.update({f"Wrinkle Field, 5,977 vertices, {stage}": steps
                  for stage, steps in benchmark_native.field_steps(43, 139).items()})
    for name, steps in pairs.items():
        rounds = [[benchmark_native.best(step, 10) for step in steps] for _ in range(ROUNDS)]
        native, rival = (min(times) for times in zip(*rounds))
        ratios[f"{name}: NumPy"] = rival / native
    return ratios


def blender_ratios(library: Path) -> dict[str, float]:
    """Of frames in Blender beside its own modifiers and nodes. library: its folder."""
    environment = {**os.environ, "RUMPLE_NATIVE": str(library)}
    text = subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                           str(HERE / "benchmark_blender.py")],
                          check=True, capture_output=True, text=True, env=environment).stdout
    return {name: float(ratio) for ratio, name in IN_BLENDER.findall(text)}


def main() -> int:
    program, stores = sys.argv[1], "--store" in sys.argv
    try:
        stored = {} if stores else read_store(STORE)
    except StoreError as error:
        print(f"Nothing to compare with: {error}\n`scripts/benchmark --short --store` makes it anew")
        return 1
    now = {**mesh_ratios(program), **other_ratios(), **blender_ratios(Path(program).resolve().parent / "python")}
    lines, fallen = compare(now, stored)
    print("\n".join(lines))
    if stores:
        rounded = {name: float(f"{ratio:.3g}") for name, ratio in sorted(now.items())}
        STORE.write_text(json.dumps(rounded, indent=1) + "\n")
    print("".join(f"speed: SLOWER BY MORE THAN A FIFTH: {line}\n" for line in fallen), end="")
    print(f"{len(now)} ratios, {len(fallen)} fell by more than a fifth")
    return 0


if __name__ == "__main__":
    sys.exit(main())
