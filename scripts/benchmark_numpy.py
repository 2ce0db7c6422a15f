# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module against the same work in NumPy, in one process: ten iterations of the Wrinkle Mesh over 32,768
triangles; a frame of the Wrinkle Maps."""
from __future__ import annotations

import time
from typing import Callable

import numpy as np
import rumple_native as rumple

SIDE, SPACING, ITERATIONS = 129, 0.0075, 10  # 128 x 128 quads, two triangles each


def sheet() -> tuple[np.ndarray, np.ndarray]:
    """A flat sheet: positions and quads."""
    x, y = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
    positions = np.stack([x, y, 0 * x], -1).reshape(-1, 3) * SPACING
    first = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
    quads = np.stack([first, first + 1, first + SIDE + 1, first + SIDE], 1)
    return positions.astype(np.float32), quads.astype(np.int32)


def native_step(positions: np.ndarray, quads: np.ndarray) -> Callable[[], None]:
    """A warm solve of a squeezed sheet; the base is as fine as the solved mesh."""
    corner = 4 * np.arange(len(quads))[:, None]
    triangles = np.concatenate([corner + [0, 1, 2], corner + [0, 2, 3]], 1).reshape(-1, 3).astype(np.int32)
    surface = rumple.build_surface(positions, np.arange(0, 4 * len(quads) + 1, 4, dtype=np.int32),
                                   np.ascontiguousarray(quads.ravel()), triangles)
    model = rumple.build_wrinkle_mesh(surface, level=0, display_steps=0, attachment="LINEAR")
    settings, paint = rumple.WrinkleMeshSettings(), rumple.WrinkleMeshPaint(model)
    settings.iterations, settings.threads = ITERATIONS, 1
    poses = [positions * np.array([0.85 + 0.02 * k, 1, 1], np.float32) for k in range(2)]
    held = [rumple.solve_wrinkle_mesh(model, settings, paint, poses[0])[0], 0]

    def step() -> None:
        held[1] += 1
        held[0] = rumple.solve_wrinkle_mesh(model, settings, paint, poses[held[1] % 2], held[0])[0]

    return step


def colours_of_grid() -> list[np.ndarray]:
    """Pairs of the sheet's edges, both diagonals, and second neighbours' places, in batches that share no vertex."""
    index = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    families = ((0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1))
    batches = []
    for down, right in families:
        a = index[:SIDE - down, max(0, -right):SIDE - max(0, right)]
        b = index[down:, max(0, right):SIDE + min(0, right)]
        along = down if down else right
        rows = np.arange(a.shape[0] if down else a.shape[1])
        for parity in range(2):
            chosen = (rows // along) % 2 == parity
            pick = (lambda m: m[chosen]) if down else (lambda m: m[:, chosen])
            batches.append(np.stack([pick(a).ravel(), pick(b).ravel()], 1))
    return batches


def numpy_step(positions: np.ndarray) -> Callable[[], None]:
    """Equations (3) to (5) and (7), colour by colour."""
    batches = colours_of_grid()
    rests = [np.linalg.norm(positions[b[:, 0]] - positions[b[:, 1]], axis=1) for b in batches]
    attachments = positions * np.array([0.85, 1, 1], np.float32)
    radius = np.float32(SPACING)

    def step() -> None:
        p = attachments.copy()
        for _ in range(ITERATIONS):
            for batch, rest in zip(batches, rests):
                difference = p[batch[:, 1]] - p[batch[:, 0]]
                length = np.sqrt((difference * difference).sum(1))
                half = difference * (0.5 * (length - rest) / length)[:, None]
                p[batch[:, 0]] += half
                p[batch[:, 1]] -= half
            offset = p - attachments
            length = np.sqrt((offset * offset).sum(1))
            p = attachments + offset * np.minimum(1, radius / np.maximum(length, 1e-12))[:, None]

    return step


def maps_steps(triangles: int, bones: int, poses: int) -> tuple[Callable[[], np.ndarray], Callable[[], np.ndarray]]:
    """A frame of influences and masks (Dutreve et al., sections 5.1, 5.2), native and in NumPy. Four bones a vertex."""
    random, vertices = np.random.default_rng(0), triangles // 2
    neutral = random.uniform(-0.1, 0.1, (bones, 6)).astype(np.float32)
    reference = neutral + random.uniform(-0.01, 0.01, (poses, bones, 6)).astype(np.float32)
    now = neutral + random.uniform(-0.01, 0.01, (bones, 6)).astype(np.float32)
    owners = np.sort(random.integers(0, bones, (vertices, 4)), 1).astype(np.int32)
    weights = random.dirichlet(np.ones(4), vertices).astype(np.float32)
    model = rumple.build_wrinkle_maps(
        [str(bone) for bone in range(bones)], ["BOTH"] * bones, np.full(bones, -1, np.int32), neutral,
        [(str(pose), bones_of_pose) for pose, bones_of_pose in enumerate(reference)],
        np.arange(0, 4 * vertices + 1, 4, dtype=np.int32), owners.ravel(), weights.ravel())
    ways = reference - neutral

    def native() -> np.ndarray:
        return rumple.masks_of_wrinkle_maps(model, rumple.evaluate_wrinkle_maps(model, now))

    def rival() -> np.ndarray:
        alpha = np.einsum("bc,obc->bo", now - neutral, ways) / np.einsum("obc,obc->bo", ways, ways)
        influence = np.clip(alpha, 0, 1)
        return np.einsum("vi,vio->ov", weights, influence[owners])

    assert np.allclose(native(), rival(), atol=1e-4)
    return native, rival


def best(step: Callable[[], None], rounds: int) -> float:
    """Milliseconds of the fastest of some rounds of CPU time."""
    times = []
    for _ in range(rounds):
        began = time.process_time()
        step()
        times.append(1e3 * (time.process_time() - began))
    return min(times)


def main() -> None:
    positions, quads = sheet()
    native, rival = best(native_step(positions, quads), 20), best(numpy_step(positions), 5)
    print(f"32,768 triangles, {ITERATIONS} iterations, one core: native {native:.1f} ms, NumPy {rival:.0f} ms, "
          f"ratio {rival / native:.0f}; the paper's machine in 2010: 5 ms")
    for triangles, bones, poses in ((9_040, 21, 2), (50_000, 100, 8)):
        native, rival = (best(step, 200) for step in maps_steps(triangles, bones, poses))
        print(f"Wrinkle Maps, {triangles:,} triangles, {bones} bones, {poses} poses, one core: native {native:.3f} ms, "
              f"NumPy {rival:.2f} ms, ratio {rival / native:.0f}")


if __name__ == "__main__":
    main()
