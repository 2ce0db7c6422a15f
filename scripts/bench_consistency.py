# SPDX-License-Identifier: GPL-3.0-or-later
"""How frame rate and density of the mesh change the folds of scripts/bench's contenders. Pure NumPy.

Heights are those above the bare surface of the same variant, without what is wider than 220 mm, at the simulation's
vertices, at moments that every rate has: MOMENTS in one second.
"""
from __future__ import annotations

from pathlib import Path

import numpy as np
from truth_measures import BANDS, Cloth, bands, heights

RATES = (24, 30, 60)  # frames a second
DENSITIES = ("half", "double")  # half as many vertices; edges half as long
MOMENTS = 6
COMPARED = ("28_to_55", "55_to_110", "110_to_220")
HEAD = ("", *(f"overlap at {rate}" for rate in RATES),
        *(f"{part} at {density} the density" for density in DENSITIES for part in ("overlap", "bands")))


def moments(frames: np.ndarray, rate: float) -> np.ndarray:
    """Of frames in order at a rate, 1/s, those whose time is a whole number of MOMENTS from 0, of one second."""
    return np.array([frame for frame in frames.tolist()
                     if (frame * MOMENTS) % rate == 0 and frame - frames[0] <= rate])


class Folds:
    """A contender's folds in one variant."""

    def __init__(self, cloth: Cloth, base: np.ndarray, fine: np.ndarray) -> None:
        """base, fine: (moments, n, 3) metres."""
        self.weight = cloth.vertex_area / cloth.vertex_area.sum()
        parts = [bands(cloth, heights(cloth, *pair)) for pair in zip(base, fine)]
        self.detail = np.array([np.sum(of_frame[:-1], axis=0) for of_frame in parts])
        self.rms = {name: float(np.mean([np.sqrt((self.weight * part[number] ** 2).sum()) for part in parts]))
                    for number, name in enumerate(BANDS)}

    def overlap(self, other: Folds) -> float:
        """Cosine of the heights, mean over the moments: 1 where the folds are the same, 0 where they are unrelated."""
        both = [(self.weight * a * b).sum() / max(np.sqrt((self.weight * a * a).sum() * (self.weight * b * b).sum()),
                                                  1e-20) for a, b in zip(self.detail, other.detail)]
        return float(np.mean(both))


def of_time(file: Path, times: np.ndarray, rate: float) -> np.ndarray | None:
    """Positions (k, n, 3) at some times, seconds; None without the file."""
    if not file.is_file():
        return None
    with np.load(file, allow_pickle=False) as stored:
        first = int(stored["frames"][0])
        return stored["positions"][np.round(times * rate).astype(int) - first]


def row(folder: Path, name: str, cloth: Cloth, frames: np.ndarray, base: np.ndarray, fps: float) -> list[str]:
    """Cells of HEAD behind its first; a dash where a variant was not played. base (frames, n, 3)."""
    chosen = moments(frames, fps)[1:]
    times, at = chosen / fps, chosen - frames[0]
    usual = Folds(cloth, base[at], of_time(folder / f"{name}.npz", times, fps))
    cells = []
    for rate in RATES:
        fine = of_time(folder / f"{name}@{rate}.npz", times, rate)
        cells.append("its own" if rate == round(fps) else
                     "-" if fine is None else f"{usual.overlap(Folds(cloth, base[at], fine)):.2f}")
    for density in DENSITIES:
        fine, bare = (of_time(folder / f"{one}@{density}.npz", times, fps) for one in (name, "subdivision"))
        if fine is None or bare is None:
            cells += ["-", "-"]
            continue
        folds = Folds(cloth, bare, fine)
        cells += [f"{usual.overlap(folds):.2f}", ", ".join(f"{folds.rms[band] / usual.rms[band]:.2f}"
                                                           for band in COMPARED)]
    return cells


def table(folder: Path, names: dict[str, str], cloth: Cloth, frames: np.ndarray, base: np.ndarray,
          fps: float) -> list[list[str]]:
    """Lines of the table of a scene, of those whose variants were played."""
    return [[title, *row(folder, name, cloth, frames, base, fps)] for name, title in names.items()
            if name != "subdivision" and any(folder.glob(f"{name}@*.npz"))]
