# SPDX-License-Identifier: GPL-3.0-or-later
"""What a solve of the Wrinkle Mesh costs by its size: cost.svg. Readable on light and on dark pages.

    docs/pictures/make_cost.py build/release/rumple_benchmarks

The benchmark's solves on one thread and on two, in nanoseconds per triangle, on a scale of powers of ten for the size.
"""
from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path

from charts import svg, words

FILTER = "solve_on_threads"
SMALLEST, LARGEST, MOST = 1e3, 1e7, 500.0  # what is drawn: triangles, nanoseconds per triangle
LEFT, TOP, WIDE, HIGH = 64, 46, 600, 300


def measured(benchmarks: str) -> dict[int, list[tuple[float, float]]]:
    """(triangles, ms) of every size, by the number of threads. The least of two runs."""
    found = json.loads(subprocess.run([benchmarks, f"--benchmark_filter={FILTER}", "--benchmark_repetitions=2",
                                       "--benchmark_format=json"], stdout=subprocess.PIPE, check=True).stdout)
    least: dict[tuple[int, float], float] = {}
    for run in found["benchmarks"]:
        if run["run_type"] == "iteration":
            threads = int(run["name"].partition("threads:")[2].partition("/")[0])
            key = threads, float(run["triangles"])
            least[key] = min(least.get(key, math.inf), float(run["real_time"]))
    out: dict[int, list[tuple[float, float]]] = {}
    for (threads, triangles), ms in sorted(least.items()):
        out.setdefault(threads, []).append((triangles, ms))
    return out


def across(triangles: float) -> float:
    return LEFT + WIDE * math.log10(triangles / SMALLEST) / math.log10(LARGEST / SMALLEST)


def down(nanoseconds: float) -> float:
    return TOP + HIGH * (1.0 - nanoseconds / MOST)


def axes() -> str:
    parts = [f'<path class="grid" d="M{LEFT} {down(n)}h{WIDE}"/>' + words(f"{n}", LEFT - 10, down(n) + 4, "end")
             for n in range(0, int(MOST) + 1, 100)]
    for power in range(round(math.log10(SMALLEST)), round(math.log10(LARGEST)) + 1):
        at, name = across(10.0 ** power), {3: "1,000", 6: "1 million", 7: "10 million"}.get(power, f"{10 ** power:,}")
        parts.append(f'<path class="grid" d="M{at:.1f} {TOP}v{HIGH}"/>' + words(name, at, TOP + HIGH + 20))
    parts.append(words("triangles", LEFT + WIDE / 2, TOP + HIGH + 42))
    parts.append(words("nanoseconds per triangle of a solve with 10 iterations", LEFT - 40, TOP - 20, "start"))
    return "".join(parts)


def chart(rows: dict[int, list[tuple[float, float]]]) -> str:
    parts = [axes()]
    for threads, sizes in rows.items():
        places = [(across(triangles), down(1e6 * ms / triangles)) for triangles, ms in sizes]
        color, line = f"--k{threads - 1}", " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        parts.append(f'<polyline style="stroke:var({color})" points="{line}"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.4" style="fill:var({color})"/>' for x, y in places]
        x, y = places[-1]
        parts.append(words(f"{threads} thread{'s' * (threads > 1)}", x + 8, y + 4, "start", color))
    return svg("Cost of a solve by its size", "make_cost.py", LEFT + WIDE + 50, TOP + HIGH + 58, parts)


if __name__ == "__main__":
    ROWS = measured(sys.argv[1])
    for THREADS, SIZES in ROWS.items():
        print(f"| {THREADS} | " + " | ".join(f"{ms:.3g}" for _, ms in SIZES) + " |")
    Path(__file__).with_name("cost.svg").write_text(chart(ROWS), encoding="utf-8")
