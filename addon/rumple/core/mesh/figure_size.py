# SPDX-License-Identifier: GPL-3.0-or-later
"""How large a figure is, and the factor on the lengths of its clothes. Never imports bpy."""
from __future__ import annotations

import numpy as np

from .base_mesh import BaseMesh

# metres, diagonals of garments whose figure is unknown: a smaller or larger garment is scaled to this size
DOLL, GIANT = 0.4, 3.0
PERSON = 0.9, 3.0  # metres, heights of figures that count as people, with room for a hat or a staff: their factor is 1
TRUE_TO_SCALE = 0.6, 4.0  # metres: clothes of smaller and larger figures are scaled like an adult of ADULT metres
ADULT = 1.75
FEWEST_BONES = 6  # a skeleton with fewer may be an arm or a leg alone
ABOVE_HEADS = 1.1  # height of a figure / height from the lowest to the highest head of a bone: a skull is above its own
WHOLE = 0.9  # least height of meshes / height of the heads: lower meshes are clothes without a body
# Most height of its meshes / height of the heads. Above that the meshes are banners, effects and wings. A person's
# height is always possible: figures of games have large heads.
MOST_MESHES = 1.5
# height without a bone / height of the skeleton without this gap: beyond are controls, such as a target far away
LARGEST_GAP = 0.5
MOST_FAR = 0.2  # largest share of such controls: with more, the skeleton itself has gaps
LOW = 0.25  # the share of a skeleton's height in which a standing figure has feet
LONG = 1.25  # length / height of a small figure: a longer one is an animal, or two arms without a person


def size_factor(diagonal: float, unit_scale: float, figure: float = 0.0) -> float:
    """The factor on lengths of the cloth, 1 for a garment of a person. diagonal: of the garment's bounding box; figure:
    height of its wearer, 0 if it is unknown; both in object units."""
    if figure > 0.0:
        return _of_height(figure * unit_scale)
    size = diagonal * unit_scale
    return size / min(max(size, DOLL), GIANT) if size > 0.0 else 1.0


def size_of(base: BaseMesh, unit_scale: float) -> float:
    """size_factor() of a garment at rest."""
    return size_factor(base.diagonal(), unit_scale, base.figure)


def _of_height(height: float) -> float:
    """1 for people, true to scale for far smaller and larger figures, and linear between both."""
    for person, other in zip(PERSON, TRUE_TO_SCALE):
        if min(person, other) < height < max(person, other):
            return 1.0 + (height - person) / (other - person) * (other / ADULT - 1.0)
    return 1.0 if PERSON[0] <= height <= PERSON[1] else height / ADULT


def height_of(boxes: np.ndarray, heads: np.ndarray, parents: np.ndarray) -> float:
    """The height of a figure at rest; 0 if it is unknown. In metres, z up.

    boxes: (meshes, 2, 3) lowest and highest corners; the first mesh is the garment. heads: (b, 3) of the bones that
    move meshes. parents: (b,) numbers of their parents among these, or -1.
    """
    extent = boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)
    of_meshes = float(extent[2])
    kept = without_far_ones(heads[:, 2])
    if kept.sum() < FEWEST_BONES:
        return of_meshes if len(boxes) > 1 and PERSON[0] <= of_meshes <= PERSON[1] else 0.0
    of_heads = float(np.ptp(heads[kept, 2]))
    whole = of_meshes >= WHOLE * of_heads
    height = min(of_meshes, max(MOST_MESHES * of_heads, PERSON[1])) if whole else ABOVE_HEADS * of_heads
    small = height < PERSON[0]  # or it is a part of a person: a bust, or two arms
    if small and not (stands(heads[:, 2], parents, kept) and extent[:2].max() <= LONG * height):
        return 0.0
    return height


def without_far_ones(heights: np.ndarray) -> np.ndarray:
    """(b,) bool: the bones without those beyond a gap that no leg or neck has."""
    order = np.argsort(heights, kind="stable")
    low, high = 0, len(order)
    while high - low > 1:
        of = heights[order[low:high]]
        gaps = np.diff(of)
        at = int(gaps.argmax()) + 1
        if 2 * at == len(of) or gaps[at - 1] <= LARGEST_GAP * (of[-1] - of[0] - gaps[at - 1]):
            break
        low, high = (low + at, high) if 2 * at < len(of) else (low, low + at)
    kept = np.zeros(len(order), bool)
    kept[order[low:high]] = True
    return kept if high - low >= (1.0 - MOST_FAR) * len(order) else np.ones(len(order), bool)


def stands(heights: np.ndarray, parents: np.ndarray, kept: np.ndarray) -> bool:
    """Whether two chains of bones or more go down into the lowest part of the skeleton: legs. kept: (b,) bool."""
    low, high = heights[kept].min(), heights[kept].max()
    is_low = kept & (heights <= low + LOW * (high - low))
    comes_down = is_low & (parents >= 0) & ~is_low[parents]
    return int(comes_down.sum()) >= 2
