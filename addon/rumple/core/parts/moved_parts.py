# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds parts that are no cloth by the bones that move them: plates, books, buckles and belts that do not bend while
the clothes do, and bare hands. The shape counts too: one bone alone may also move a sleeve, a collar, a pocket or a
cuff. Never imports bpy."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base.vertices import lengths
from ..base.vertices import places as places_of
from ..mesh import outer_side
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import borders
from .measured_parts import MeasuredParts
from .skin_parts import FLAT, THICK

EVEN = 0.02  # largest difference of weights within a part that does not bend
SMALL, BELT = 0.25, 0.7  # largest diagonal / the mesh's
LARGE = 0.3  # least diagonal / the mesh's of a garment that bends
MOST_ASKED = 64  # how many parts are examined, the largest ones
SAME_MIDDLE = 0.25  # distance of the middles of a frame's two borders / the smaller radius; a cuff has its height there
NARROW = 0.5  # largest height / diameter of a belt
GOES_ON = 0.25  # distance beyond a rim / diameter within which the garment must go on, and the belt's height at least
SECTORS, LEAST_SECTORS = 8, 7  # around a belt; in how many of them the garment goes on
BESIDE = 0.5, 1.5  # distance from the belt's axis / the belt's own, of the garment there
ON_EDGES = np.array((0.0, 0.25, 0.5, 0.75))  # places on the sides of polygons that are looked at
HAND_BONES, OF_HAND = 4, 0.95  # least number of bones of a hand; least share of its weights that they have
ELSEWHERE = 0.5  # most vertices of other parts that these bones move / those of the hand
MOVES = 0.01  # least mean weight of a bone that moves a part


class Moved(NamedTuple):
    """What was found."""

    rigid: np.ndarray  # (parts,) bool: it keeps its shape
    hands: np.ndarray  # (parts,) bool: bare hands, or feet with toes

    @property
    def any(self) -> bool:
        return bool(self.rigid.any() or self.hands.any())


def find_moved(base: BaseMesh, found: MeasuredParts, part: np.ndarray, known: np.ndarray, weights: np.ndarray,
               below: np.ndarray) -> Moved:
    """base: healed. found: from measured(). part: (n,) the part of each vertex. known: (parts,) bool of parts that are
    already no cloth. weights: (n, bones). below: (bones, bones) bool: the second bone is the first one or below it.
    Cost: about 50 ms for 50,000 vertices and 50 bones, and 5 ms for each part that is examined."""
    count = len(found.area)
    none = Moved(np.zeros(count, bool), np.zeros(count, bool))
    used = np.unique(base.corner_vertex)
    asked = (found.area > 0.0) & ~known
    if asked.sum() < 2 or not weights.size:
        return none
    even, mean = _evenness(weights[used], part[used], count)
    bending = asked & ~even & (found.diagonal >= LARGE * found.whole)
    if not bending.any():
        return none  # every part has a bone of its own: that says nothing
    few = asked & even & (found.diagonal <= BELT * found.whole)
    few[np.argsort(np.where(few, -found.area, 0.0), kind="stable")[MOST_ASKED:]] = False
    polygon_part = part[base.corner_vertex[base.polygon_start[:-1]]]
    rigid = np.zeros(count, bool)
    for number in np.flatnonzero(few).tolist():
        rigid[number] = _is_rigid(base, found, polygon_part, number, bending)
    hands = np.zeros(count, bool)
    for number in np.flatnonzero(asked & ~even & (found.diagonal <= SMALL * found.whole)).tolist():
        if len(found.openings[number]) < 2 and found.thick[number] >= THICK and found.flat[number] < FLAT:
            hands[number] = _is_hand(weights, part, used, number, mean[number], below)
    return Moved(rigid, hands)


def _evenness(weights: np.ndarray, part: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(parts,) bool: all vertices of a part have the same bones; (parts, bones): the mean weights."""
    total = weights.sum(axis=1, keepdims=True)
    shares = weights / np.maximum(total, 1e-9)
    order = np.argsort(part, kind="stable")
    present, starts, sizes = np.unique(part[order], return_index=True, return_counts=True)
    low, high = np.minimum.reduceat(shares[order], starts, axis=0), np.maximum.reduceat(shares[order], starts, axis=0)
    even, mean = np.zeros(count, bool), np.zeros((count, weights.shape[1]))
    moved = np.minimum.reduceat(total[order, 0], starts) > 0.0
    even[present] = moved & ((high - low).max(axis=1) <= EVEN)
    mean[present] = np.add.reduceat(shares[order], starts, axis=0) / sizes[:, None]
    return even, mean


def _is_rigid(base: BaseMesh, found: MeasuredParts, polygon_part: np.ndarray, number: int,
              bending: np.ndarray) -> bool:
    """Whether a part that does not bend is a closed thing or a frame, or a belt around a garment that bends."""
    alone = _alone(base, polygon_part == number)
    small = found.diagonal[number] <= SMALL * found.whole
    place = places_of(alone.positions)
    outer = outer_side.without_inner_side(alone)
    if found.closed[number] and _is_ball(alone, place) and len(borders(outer, places_of(outer.positions))) < 2:
        return bool(small)  # a plate, a book
    rims = borders(alone, place)
    if len(rims) not in (0, 2):
        return False
    if rims and small and found.flat[number] < FLAT and _have_same_middle(*(alone.positions[rim] for rim in rims)):
        return True  # the frame of a buckle, open at its back
    return any(_goes_around(alone.positions.astype(np.float64), _on_sides(base, polygon_part == garment))
               for garment in np.flatnonzero(bending).tolist())


def _is_ball(base: BaseMesh, place: np.ndarray) -> bool:
    """Whether a closed part has no hole through it, by Euler's formula. A belt, a cuff or a sleeve with a thickness
    has one."""
    sides = np.unique(np.sort(place[base.sides()], axis=1), axis=0)
    return len(np.unique(place)) - len(sides) + len(base.polygon_start) - 1 == 2


def _have_same_middle(first: np.ndarray, other: np.ndarray) -> bool:
    """Whether two borders (k, 3) lie around the same point. Those of a tube have its length between them."""
    between = lengths((first.mean(axis=0) - other.mean(axis=0))[None])[0]
    radius = min(float(lengths(rim - rim.mean(axis=0)).mean()) for rim in (first, other))
    return bool(between <= SAME_MIDDLE * radius)


def _alone(base: BaseMesh, kept: np.ndarray) -> BaseMesh:
    """Some polygons with their own vertices only. kept: (p,) bool."""
    corners = np.repeat(kept, np.diff(base.polygon_start))
    vertex, corner_vertex = np.unique(base.corner_vertex[corners], return_inverse=True)
    triangles = (np.cumsum(corners) - 1)[base.triangle_corner[corners[base.triangle_corner[:, 0]]]]
    sizes = np.diff(base.polygon_start)[kept]
    return BaseMesh(base.name, np.ascontiguousarray(base.positions[vertex]),
                    np.append(np.int32(0), np.cumsum(sizes)).astype(np.int32),
                    corner_vertex.ravel().astype(np.int32), np.ascontiguousarray(triangles, np.int32))


def _on_sides(base: BaseMesh, polygons: np.ndarray) -> np.ndarray:
    """(k, 3) points on the sides of some polygons: (p,) bool."""
    sides = base.positions[base.sides()[np.repeat(polygons, np.diff(base.polygon_start))]].astype(np.float64)
    along = ON_EDGES[None, :, None]
    return ((1.0 - along) * sides[:, :1] + along * sides[:, 1:]).reshape(-1, 3)


def _goes_around(belt: np.ndarray, garment: np.ndarray) -> bool:
    """Whether a ring (n, 3) is narrow, and a garment goes on beyond both of its rims. A cuff is where the garment ends.
    garment: (k, 3) points of one part."""
    middle = belt.mean(axis=0)
    axes = np.linalg.eigh((belt - middle).T @ (belt - middle))[1]  # that of the least extent first
    ring, cloth = (belt - middle) @ axes, (garment - middle) @ axes
    sector, of_cloth = (_sector(points) for points in (ring, cloth))
    filled = np.bincount(sector, minlength=SECTORS)
    radius = np.bincount(sector, lengths(ring[:, 1:]), SECTORS) / np.maximum(filled, 1)
    height, diameter = float(np.ptp(ring[:, 0])), 2.0 * float(radius.mean())
    if (filled == 0).any() or height > NARROW * diameter:
        return False
    away = lengths(cloth[:, 1:]) / np.maximum(radius[of_cloth], 1e-30)
    beside = (away > BESIDE[0]) & (away < BESIDE[1])
    far = max(GOES_ON * diameter, height)
    for side in (1.0, -1.0):
        beyond = side * cloth[:, 0] - (side * ring[:, 0]).max()
        there = beside & (beyond > 0.5 * height) & (beyond < far + 0.5 * height)
        if len(np.unique(of_cloth[there])) < LEAST_SECTORS:
            return False
    return True


def _sector(points: np.ndarray) -> np.ndarray:
    turn = np.arctan2(points[:, 2], points[:, 1]) / (2.0 * np.pi) + 0.5
    return np.minimum((SECTORS * turn).astype(np.int64), SECTORS - 1)


def _is_hand(weights: np.ndarray, part: np.ndarray, used: np.ndarray, number: int, mean: np.ndarray,
             below: np.ndarray) -> bool:
    """Whether a bone and several bones below it move a part, and hardly anything else. mean: (bones,) of this part."""
    shares = below @ mean
    tops = np.flatnonzero((shares >= OF_HAND) & (mean >= MOVES))
    if not len(tops):
        return False
    top = int(tops[below[tops].sum(axis=1).argmin()])
    if (mean[below[top]] >= MOVES).sum() < HAND_BONES:
        return False
    total = weights[used].sum(axis=1)
    mostly = weights[used][:, below[top]].sum(axis=1) > 0.5 * total
    own = part[used] == number
    return bool((mostly & ~own).sum() <= ELSEWHERE * own.sum())
