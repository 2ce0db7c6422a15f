# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of shape keys: how much a key moves each vertex, used like skin weights. Never imports bpy."""
from __future__ import annotations

from typing import Sequence

import numpy as np

from .poses import SkinWeights

# share of the longest displacement: less is a trace of sculpting, and ignoring it keeps the rows of weights short
STILL = 0.01


def weights_of_key(displacements: np.ndarray) -> np.ndarray:
    """(n,) float32 from (n, 3): the displacement of each vertex relative to the longest one, 0..1.

    1 at the longest one, 0 up to STILL, linear between.
    """
    lengths = np.sqrt((displacements.astype(float) ** 2).sum(1))
    longest = lengths.max(initial=0.0)
    if not longest > 0.0 or not np.isfinite(longest):
        return np.zeros(len(lengths), np.float32)
    return np.maximum((lengths / longest - STILL) / (1.0 - STILL), 0.0).astype(np.float32)


def with_keys(bones: SkinWeights, keys: Sequence[np.ndarray], first: int) -> SkinWeights:
    """Skin weights of n vertices with the weights of keys, (n,) each, added. Keys are numbered from `first`."""
    count = len(bones.start) - 1
    vertex = [np.repeat(np.arange(count), np.diff(bones.start))]
    element, weight = [bones.bone], [bones.weight]
    for number, values in enumerate(keys, first):
        moved = np.flatnonzero(values > 0.0)
        vertex.append(moved)
        element.append(np.full(len(moved), number, np.int32))
        weight.append(values[moved])
    owner = np.concatenate(vertex)
    order = np.argsort(owner, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))])
    return SkinWeights(start.astype(np.int32), np.concatenate(element)[order].astype(np.int32),
                       np.concatenate(weight)[order].astype(np.float32))
