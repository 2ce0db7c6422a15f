# SPDX-License-Identifier: GPL-3.0-or-later
"""The paint Hangs Free: cloth away from the body, like the skirt of a dress, gets more room and fewer narrow folds.
Never imports bpy."""
from __future__ import annotations

import numpy as np

from ..base.interpolation import smoothstep
from ..settings.cloth_settings import ClothSettings

FREE = "free"  # the paint: 1 where cloth hangs free, 0 where it lies on the body
NEAR, AWAY = 0.05, 0.13  # metres from an adult's body: up to NEAR cloth lies on it; from AWAY on it hangs free
# distance below a cape's upper end / its diagonal: held up to here; hangs free from here on
SHEET_HELD, SHEET_FREE = 0.06, 0.25
LEAST_FREE = 0.1  # least share of the vertices: fewer are not a hanging part of a garment
LEFT = (1.0, 0.5, 0.0)  # share of Drape, Folds and Detail that is left where cloth hangs free
WORN = "worn"  # the solver's paint of cloth that does not hang free: wide layers gather little there
SPREADS = 8  # smoothing steps: every vertex gets the mean of itself and its neighbours


def share_of_distance(distance: np.ndarray, size: float) -> np.ndarray:
    """(n,) metres to the body -> (n,) 0..1. size: size_factor() of the garment."""
    return smoothstep((distance / size - NEAR) / (AWAY - NEAR))


def share_of_sheet(rest: np.ndarray) -> np.ndarray:
    """(n,) 0..1 of a sheet (n, 3), Z up, by the distance below its upper end. The distance to the body is not suitable:
    a cape would be held beside an arm, and get a dent there."""
    below = rest[:, 2].max() - rest[:, 2]
    return share_beyond(below, float(np.linalg.norm(np.ptp(rest, axis=0))))


def share_beyond(distance: np.ndarray, diagonal: float) -> np.ndarray:
    """(n,) 0..1 of a sheet, by the distance from where it is held. diagonal: of the sheet."""
    return smoothstep((distance / diagonal - SHEET_HELD) / (SHEET_FREE - SHEET_HELD))


def spread(share: np.ndarray, edges: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(n,) 0..1, or NaN where not known -> (n,) float32, smoothed along the mesh and across seams. 0 where nothing
    nearby is known. edges: (m, 2). place: see places()."""
    known, at_place = np.isfinite(share), np.bincount(place)
    weight, value = (np.bincount(place, each) / at_place for each in (known, np.where(known, share, 0.0)))
    for _ in range(SPREADS):
        weight, value = (0.5 * mine + 0.5 * _mean_beside(mine, place[edges]) for mine in (weight, value))
    return np.where(weight > 0.0, value / np.maximum(weight, 1e-12), 0.0).astype(np.float32)[place]


def _mean_beside(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    first, second = edges.T
    count = np.bincount(edges.ravel(), minlength=len(values))
    total = np.bincount(first, values[second], len(values)) + np.bincount(second, values[first], len(values))
    return np.where(count > 0, total / np.maximum(count, 1), values)


def room_factor(free: np.ndarray, settings: ClothSettings) -> np.ndarray:
    """(n,) float32: factor on Room, so that it becomes Free Room where cloth hangs free."""
    widest = settings.free_room / settings.room if settings.room > 0.0 else 1.0
    return (1.0 + np.clip(free, 0.0, 1.0) * (max(widest, 1.0) - 1.0)).astype(np.float32)


def with_wide_folds(paint: dict[str, np.ndarray], free: np.ndarray | None, words: list[str]) -> dict[str, np.ndarray]:
    """The paint of a Wrinkle Mesh with maps for its layers. Where cloth hangs free, wide layers gather the compressed
    length, there are fewer narrow folds, and no layer is wider than the cloth. free: (n,), or None. words: of the
    layers, coarse first.
    """
    if free is None or not words:
        return paint
    free = np.clip(free, 0.0, 1.0)
    left = {word: (1.0 - (1.0 - share) * free).astype(np.float32)
            for word, share in zip(dict.fromkeys(words), LEFT) if share < 1.0}
    narrow = {word: paint[word] * share if word in paint else share for word, share in left.items()}
    return {**paint, **narrow, WORN: (1.0 - free).astype(np.float32)}
