# SPDX-License-Identifier: GPL-3.0-or-later
"""The native module beside the same work in NumPy, in one process: a frame of the Wrinkle Maps; crush and a round of
relax of the Wrinkle Field."""
from __future__ import annotations

import time
from typing import Callable

import numpy as np
import rumple_native as rumple


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


def field_steps(columns: int, rows: int) -> dict[str, tuple[Callable[[], np.ndarray], Callable[[], np.ndarray]]]:
    """Crush and one round of relax (Loviscach, equations 1, 2 and 6), native and in NumPy, on a squeezed wavy sheet."""
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    rest = (np.stack([x, y, 0 * x], -1).reshape(-1, 3) * 0.01).astype(np.float32)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    triangles = np.concatenate([np.stack([first, first + 1, first + columns + 1], 1),
                                np.stack([first, first + columns + 1, first + columns], 1)]).astype(np.int32)
    pose = rest * np.array([0.7, 1, 1], np.float32)
    pose[:, 2] = 0.02 * np.sin(6 * rest[:, 0])
    surface = rumple.build_surface(rest, np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int32), triangles.ravel(),
                                   np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3))
    model = rumple.build_wrinkle_field(surface)
    settings, paint = rumple.WrinkleFieldSettings(), rumple.WrinkleFieldPaint()
    settings.threads = 1
    start, other, gradient = model.neighbour_start, model.neighbours, model.gradients
    here, degree = np.repeat(np.arange(len(rest)), np.diff(start)), np.diff(start)
    waves, phase = rumple.estimate_waves_wrinkle_field(model, settings, paint, pose), rumple.random_phases(model, 0)

    def total(values: np.ndarray) -> np.ndarray:
        return np.add.reduceat(values, start[:-1])

    def rows_dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a * b).sum(-1)

    def crush_rival() -> np.ndarray:
        b, c = pose[triangles[:, 1]] - pose[triangles[:, 0]], pose[triangles[:, 2]] - pose[triangles[:, 0]]
        face = np.cross(b, c)
        normal = np.stack([sum(np.bincount(triangles[:, k], face[:, axis], len(rest)) for k in range(3))
                           for axis in range(3)], 1)
        normal /= np.sqrt(rows_dot(normal, normal))[:, None]
        way = pose[other] - pose[here]
        t = way[start[:-1]]
        t = t - rows_dot(t, normal)[:, None] * normal
        t /= np.sqrt(rows_dot(t, t))[:, None]
        v = np.stack([rows_dot(t[here], way), rows_dot(np.cross(normal, t)[here], way)], 1)
        v *= np.sqrt(rows_dot(way, way) / rows_dot(v, v))[:, None]
        m = [[total(v[:, i] * gradient[:, j]) for j in range(2)] for i in range(2)]
        c00, c11 = m[0][0]**2 + m[1][0]**2, m[0][1]**2 + m[1][1]**2
        c01 = m[0][0] * m[0][1] + m[1][0] * m[1][1]
        mean, radius = 0.5 * (c00 + c11), np.sqrt(0.25 * (c00 - c11)**2 + c01**2)
        return 0.25 * settings.wavelength * np.sqrt(np.maximum(1 - (mean - radius), 0))

    wave_vector, at, fullness = waves.wave_vector, waves.positions, waves.fullness

    def relax_rival() -> np.ndarray:
        way = at[other] - at[here]
        flip = np.where(rows_dot(wave_vector[other], wave_vector[here]) < 0, -1, 1)
        offset = -0.5 * (flip * rows_dot(wave_vector[other], way) + rows_dot(wave_vector[here], way))
        misfit = (flip * phase[other] - phase[here] + offset) / (2 * np.pi)
        misfit -= np.floor(misfit + 0.5)
        weight = np.clip(4 * fullness[other] - 0.2, 0, 1)
        change = settings.rate * 2 * np.pi * total(weight * misfit) / degree
        after = np.where(np.abs(change) < 1e-4, phase, phase + change)
        return after - 2 * np.pi * np.floor(after / (2 * np.pi) + 0.5)

    def crush_native() -> np.ndarray:
        return rumple.estimate_waves_wrinkle_field(model, settings, paint, pose).height

    def relax_native() -> np.ndarray:
        return rumple.relax_wrinkle_field(model, settings, waves, 1, phase)

    assert np.quantile(np.abs(crush_native() - crush_rival()), 0.999) < 1e-6
    assert np.quantile(np.abs(np.sin(relax_native() - relax_rival())), 0.99) < 1e-3  # ties may fall either way
    return dict(crush=(crush_native, crush_rival), relax=(relax_native, relax_rival))


def best(step: Callable[[], None], rounds: int) -> float:
    """Milliseconds of the fastest of some rounds of CPU time."""
    times = []
    for _ in range(rounds):
        began = time.process_time()
        step()
        times.append(1e3 * (time.process_time() - began))
    return min(times)


def main() -> None:
    for triangles, bones, poses in ((9_040, 21, 2), (50_000, 100, 8)):
        native, rival = (best(step, 200) for step in maps_steps(triangles, bones, poses))
        print(f"Wrinkle Maps, {triangles:,} triangles, {bones} bones, {poses} poses, one core: native {native:.3f} ms, "
              f"NumPy {rival:.2f} ms, ratio {rival / native:.0f}")
    for columns, rows in ((13, 35), (43, 139), (316, 317), (1000, 1000)):
        vertices = columns * rows
        for stage, steps in field_steps(columns, rows).items():
            native, rival = (best(step, 20 if vertices < 50_000 else 3) for step in steps)
            print(f"Wrinkle Field, {stage}, {vertices:,} vertices, one core: native {native:.3f} ms, "
                  f"NumPy {rival:.2f} ms, ratio {rival / native:.0f}")


if __name__ == "__main__":
    main()
