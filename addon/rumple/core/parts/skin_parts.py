# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds skin in the mesh of its clothes, as in characters of games: head, arms and feet, or a whole body, and its hair.
Skin is not cloth: it follows the animation, and cloth stays outside of it. Shoes are not cloth either. Never imports
bpy.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base.triangles import vertex_normals
from ..base.vertices import MOST, nearest_of, sample_of, samples_of
from ..mesh.base_mesh import BaseMesh
from .capped_parts import ends_in
from .measured_parts import NEAR, MeasuredParts

GARMENT, HAND = 0.15, 0.08  # least diagonal / the mesh's, of a garment and of skin, except for parts that lie on skin
UNDER = 0.5  # share of a border that must be under other near parts
FLAT = 0.3  # share of the area that faces one way: a sheet has 0.4 and more, a head 0.23, an arm 0.05
THICK = 0.015  # least volume / area^1.5: a body has 0.03, an arm 0.06, a jacket with an inner side 0.008
LEAST_AREA = 0.03  # least share of skin in the mesh's area: with less, it is a garment with a hat or a shoe
OF_BORDER = 12  # largest number of vertices of a border that are tested
# tested vertices: of all parts that may lie on skin; at least and at most of one part
OF_PARTS, LEAST_OF_PART, MOST_OF_PART = 20_000, 4, 64
MOST_PARTS = 64  # how many parts are tested for skin, the largest ones
WHOLE = 0.75  # least diagonal / the mesh's of skin without an opening: a smaller closed part is a bag
# of a garment with caps: least diagonal / the mesh's; borders of other parts that end in it, at least one of skin
CAPPED, ENDS_IN_IT = 0.3, 2
BALL = 0.075  # largest volume / area^1.5 of it: a head has 0.08 and more, the trunk of a toy 0.062, trousers 0.05


class Kinds(NamedTuple):
    """The kinds of the parts of a dressed figure. All are False in a mesh without skin or without a garment."""

    skin: np.ndarray  # (parts,) bool
    limbs: np.ndarray  # (parts,) bool: skin with the shape of a body
    shoes: np.ndarray  # (parts,) bool: the shape of a body, but neither skin nor a garment
    garments: np.ndarray  # (parts,) bool
    capped: np.ndarray  # (parts,) bool: garments whose openings are closed by caps

    @classmethod
    def none(cls, parts: int) -> "Kinds":
        """All False, for this number of parts."""
        return cls(*(np.zeros(parts, bool) for _ in cls._fields))


def find_skin(base: BaseMesh, found: MeasuredParts, part: np.ndarray, small: np.ndarray) -> Kinds:
    """The kinds of all parts. found: from measured(). part: (n,) the part of each vertex, see connected.py. small:
    (parts,) bool: rigid because they are small. Cost: about 0.2 s for 50,000 vertices, less if none is skin."""
    whole = found.whole
    openings = np.array([len(own) for own in found.openings])
    counts = (found.area > 0.0) & ~small
    wide = counts & (openings > 1) & (found.diagonal >= GARMENT * whole)
    capped = counts & (openings < 2) & (found.diagonal >= CAPPED * whole) & (found.thick <= BALL)
    bodily = counts & (openings < 3) & (found.flat < FLAT) & (found.thick > THICK) & (found.diagonal >= HAND * whole)
    if counts.sum() < 2 or not (wide | capped).any() or not bodily.any():
        return Kinds.none(len(small))
    asked = bodily & ((openings > 0) | (found.diagonal >= WHOLE * whole))
    asked[np.argsort(np.where(asked, -found.area, 0.0), kind="stable")[MOST_PARTS:]] = False
    ends = [(number, sample_of(border, OF_BORDER)) for number in np.flatnonzero(asked | wide).tolist()
            for border in found.openings[number]]
    is_skin = asked[[number for number, _border in ends]]
    within = ends_in(base, ends, part, np.flatnonzero(capped))
    capped[capped] = (within.sum(axis=0) >= ENDS_IN_IT) & within[is_skin].any(axis=0)
    skin = _ends_under(base, found.openings, asked & ~capped, samples_of(part, counts), NEAR * whole)
    garment = (wide & ~skin) | capped
    if not garment.any() or not found.area[skin].sum() > LEAST_AREA * found.area.sum():
        return Kinds.none(len(small))
    limbs, skin = skin, skin | _lies_on_skin(base.positions, part, counts & ~skin & ~garment, skin, garment)
    return Kinds(skin, limbs, bodily & (openings < 2) & ~skin & ~garment, garment, capped)


def _ends_under(base: BaseMesh, openings: list[list[np.ndarray]], asked: np.ndarray, samples: dict[int, np.ndarray],
                near: float) -> np.ndarray:
    """(parts,) bool: which of the asked parts have all their borders under other parts. This is true for skin, because
    cloth overlaps it. samples: some vertices of each part."""
    ends = np.zeros(len(asked), bool)
    normals = vertex_normals(base.positions, base.triangles)
    every = np.concatenate(list(samples.values()))
    of = np.repeat(list(samples), [len(own) for own in samples.values()])
    for number in np.flatnonzero(asked):
        low, high = (bound(base.positions[samples[number]], axis=0) for bound in (np.min, np.max))
        beside = ((base.positions[every] >= low - near) & (base.positions[every] <= high + near)).all(1)
        others = every[beside & (of != number)]
        ends[number] = all(_is_under(base.positions, normals, sample_of(border, OF_BORDER), others, near)
                           for border in openings[number])
    return ends


def _is_under(positions: np.ndarray, normals: np.ndarray, border: np.ndarray, others: np.ndarray, near: float) -> bool:
    if not len(others):
        return False
    nearest, distance = nearest_of(positions[border], positions, others)
    above = ((positions[nearest] - positions[border]) * normals[border]).sum(1) > 0.0
    return bool((above & (distance < near)).mean() >= UNDER)


def _lies_on_skin(positions: np.ndarray, part: np.ndarray, asked: np.ndarray, skin: np.ndarray,
                  garment: np.ndarray) -> np.ndarray:
    """(parts,) bool: which of the asked parts are nearer to skin than to garments."""
    to_skin, to_garment = (sample_of(np.flatnonzero(chosen[part]), MOST) for chosen in (skin, garment))
    nearer = np.zeros(len(asked), bool)
    most = min(max(OF_PARTS // max(int(asked.sum()), 1), LEAST_OF_PART), MOST_OF_PART)
    own = [sample_of(vertices, most) for vertices in samples_of(part, asked).values()]
    if own:
        every = np.concatenate(own)
        away = (nearest_of(positions[every], positions, to)[1] for to in (to_skin, to_garment))
        skin_away, garment_away = (np.bincount(part[every], each, len(asked)) for each in away)
        nearer = skin_away < garment_away
    return nearer
