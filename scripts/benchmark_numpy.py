# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's step in NumPy beside the native one of this run: attachments, 10 iterations, normals; one core.

python3 benchmark_numpy.py PROGRAM; PROGRAM: rumple_benchmarks. The scene is that of native/benchmarks: 32 x 32
squares of 3 cm in two triangles each, every triangle split in 16: 32,768 fine triangles. Prints a table in Markdown.
"""
from __future__ import annotations

import json
import subprocess
import sys
import time
from typing import Callable

import numpy as np

SQUARES, SPLIT, SPACING = 32, 4, 0.03
SIDE = SQUARES * SPLIT + 1
ITERATIONS, BENDING = 10, np.float32(0.7)
ROUNDS = 7
NATIVE = "solve_step/paper_linear/1"


def grid(side: int, spacing: float) -> np.ndarray:
    """A flat sheet of side x side points, rows along y."""
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    return (np.stack([x, y, 0 * x], -1).reshape(-1, 3) * spacing).astype(np.float32)


def triangles() -> np.ndarray:
    """(32768, 3): two in every square, along the diagonal to the upper right."""
    first = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    right, across, up = first + 1, first + SIDE + 1, first + SIDE
    return np.concatenate([np.stack([first, right, across], 1), np.stack([first, across, up], 1)])


def places() -> tuple[np.ndarray, np.ndarray]:
    """Base vertices (n, 3) and barycentrics (n, 3) of every fine vertex."""
    y, x = (axis.ravel() for axis in np.mgrid[:SIDE, :SIDE])
    column, row = (np.minimum(v // SPLIT, SQUARES - 1) for v in (x, y))
    u, v = (x / SPLIT - column), (y / SPLIT - row)
    first = row * (SQUARES + 1) + column
    across = first + SQUARES + 2
    third = np.where(u >= v, first + 1, first + SQUARES + 1)
    low, high = np.minimum(u, v), np.maximum(u, v)
    return np.stack([first, third, across], 1), np.stack([1 - high, high - low, low], 1).astype(np.float32)


def colours() -> list[tuple[np.ndarray, bool]]:
    """Pairs in batches that share no vertex, and whether they bend: edges, then the vertices opposite to them."""
    index = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    batches = []
    for up, right in ((0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1)):
        a = index[:SIDE - up, max(0, -right):SIDE - max(0, right)]
        b = index[up:, max(0, right):SIDE + min(0, right)]
        along = up if up else right
        chosen = np.arange(a.shape[0] if up else a.shape[1]) // along % 2
        for parity in range(2):
            pick = (chosen == parity)[:, None] if up else (chosen == parity)[None, :]
            pick = np.broadcast_to(pick, a.shape)
            batches.append((np.stack([a[pick], b[pick]], 1), (up, right) not in ((0, 1), (1, 0), (1, 1))))
    return batches


def numpy_step() -> Callable[[], None]:
    """(1), then (3) to (5) colour by colour and (7), then normals, as whole arrays."""
    rest = grid(SIDE, SPACING / SPLIT)
    pose = grid(SQUARES + 1, SPACING) * np.array([0.85, 1, 1], np.float32)
    corners, weights = places()
    pairs = [(batch, np.linalg.norm(rest[batch[:, 0]] - rest[batch[:, 1]], axis=1),
              np.float32(0.5) * (BENDING if bends else 1)) for batch, bends in colours()]
    faces, radius = triangles(), np.float32(SPACING / SPLIT)
    offset = np.zeros_like(rest)

    def step() -> None:
        attachment = (pose[corners] * weights[:, :, None]).sum(1)
        p = attachment + offset
        for _ in range(ITERATIONS):
            for batch, length, share in pairs:
                difference = p[batch[:, 1]] - p[batch[:, 0]]
                now = np.sqrt((difference * difference).sum(1))
                half = difference * (share * (now - length) / now)[:, None]
                p[batch[:, 0]] += half
                p[batch[:, 1]] -= half
            out = p - attachment
            far = np.sqrt((out * out).sum(1))
            p = attachment + out * np.minimum(1, radius / np.maximum(far, 1e-12))[:, None]
        offset[:] = p - attachment
        a, b, c = (p[faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        total = np.stack([sum(np.bincount(faces[:, k], normal[:, axis], len(p)) for k in range(3))
                          for axis in range(3)], 1)
        total /= np.linalg.norm(total, axis=1, keepdims=True)

    return step


def best(step: Callable[[], None]) -> float:
    """Milliseconds of processor time, of the fastest of some rounds."""
    times = []
    for _ in range(ROUNDS):
        began = time.process_time()
        step()
        times.append(1e3 * (time.process_time() - began))
    return min(times)


def native(program: str) -> float:
    """The same number for the native step."""
    text = subprocess.run([program, f"--benchmark_filter={NATIVE}$", "--benchmark_format=json",
                           f"--benchmark_repetitions={ROUNDS}"], check=True, capture_output=True, text=True).stdout
    return min(row["cpu_time"] for row in json.loads(text)["benchmarks"] if row["run_type"] == "iteration")


def main() -> None:
    ours, rival = native(sys.argv[1]), best(numpy_step())
    print("| attachments + 10 iterations + normals, 32,768 triangles, one core | ms |\n|---|---|\n"
          f"| the paper, 2010 | 5 |\n| native | {ours:.1f} |\n| NumPy | {rival:.0f} ({rival / ours:.0f} times) |")


if __name__ == "__main__":
    main()
