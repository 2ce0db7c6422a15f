# SPDX-License-Identifier: GPL-3.0-or-later
"""Fold guides: lines on a garment at rest that make pleats, tucks or puckers on the shown mesh, or that give the
direction of the solved folds. Never imports bpy.

A guide is a set of rows in a table, one row for each point of its line: see COLUMNS. Its folds are heights along the
normals of the shown surface. They are computed once, at rest, and so follow every pose. Directions are passed to the
solvers (native/surface/strain/guided_strain.h).
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.interpolation import smoothstep
from ..base.transforms import length, principal_axes
from ..base.triangles import cross, unit
from ..base.vertices import nearest_of

GUIDES = "guides"  # the paint
ALONG = "along"  # paint made from directions: (n, 3) of the base's vertices, length 0..1; v and -v mean the same
# Columns of the paint, which has a row for each point of each guide: all fields of Guide, and the number of its line.
COLUMNS = ("x", "y", "z", "factor", "line", "kind", "count", "spacing", "depth", "others")
KINDS = (
    ("PLEATS", "Pleats", "Round folds along the curve"),
    ("KNIFE", "Knife Pleats", "Folds along the curve that lie to one side"),
    ("TUCKS", "Tucks", "Narrow ridges along the curve, with smooth cloth between them"),
    ("PUCKER", "Pucker", "Short folds across the curve, as along a tight seam"),
    ("DIRECTION", "Direction", "Adds no fold: the folds that motion makes run along the curve"),
)
LINE, KIND = COLUMNS.index("line"), COLUMNS.index("kind")
PLEATS, KNIFE, TUCKS, PUCKER, DIRECTION = range(5)
LEAN = 0.75  # position of the crest of a knife pleat between its valleys (0 and 1)
TUCK = 0.5  # share of the spacing that a tuck takes
STEPS = 4.0  # points of a line per fold spacing
COSINE_TERMS = 12  # of the cosine's series: between -pi/2 and pi/2 the next term is below 1e-18
ARC_TERMS = 12  # of the series of the arc sine, for a sine up to 0.2
FINEST = 0.25  # longest edges / spacing with which the mesh can show a fold
TOO_FAR = "a guide is too far from the garment at rest: move it onto the surface"


@dataclass(frozen=True)
class Guide:
    """One line of k points. Lengths are object units."""

    points: np.ndarray  # (k, 3)
    factor: np.ndarray  # (k,) factor on the depth, or on the direction
    kind: int  # place in KINDS
    count: float  # folds
    spacing: float  # distance between folds; for a direction: its reach to each side
    depth: float  # from valley to crest
    # share of the other folds that stays between them; for a direction: share that keeps its own direction
    others: float

    @classmethod
    def all_of(cls, table: np.ndarray) -> list["Guide"]:
        """All guides in the paint, in the order of their line numbers. float64."""
        return [cls._of(table[table[:, LINE] == line].astype(np.float64)) for line in np.unique(table[:, LINE])]

    @classmethod
    def _of(cls, rows: np.ndarray) -> "Guide":
        first = dict(zip(COLUMNS, rows[0].tolist()))
        return cls(rows[:, :3], rows[:, COLUMNS.index("factor")], int(first["kind"]),
                   *(first[name] for name in ("count", "spacing", "depth", "others")))

    def rows(self, line: int) -> np.ndarray:
        """(k, 10) float32 of the paint. line: its number."""
        about = (line, self.kind, self.count, self.spacing, self.depth, self.others)
        return np.column_stack([self.points, self.factor, np.tile(about, (len(self.points), 1))]).astype(np.float32)


def crest(share: np.ndarray) -> np.ndarray:
    """Height of a round fold, 0 at its valleys (0 and 1), 1 at its crest (one half), with level ends."""
    square = (math.pi * (share - np.floor(share) - 0.5)) ** 2
    cosine = np.ones_like(square)  # by its series, because the last bit of NumPy's cosine depends on the processor
    for k in range(COSINE_TERMS, 0, -1):
        cosine = 1.0 - cosine * square / ((2 * k - 1) * 2 * k)
    return cosine * cosine


def profile(kind: int, across: np.ndarray, along: np.ndarray, count: float, spacing: float) -> np.ndarray:
    """Heights, 0 to 1, by the distances across and along the line."""
    half = 0.5 * count * spacing
    if kind == PUCKER:
        return crest(along / spacing) * smoothstep(1.0 - np.abs(across) / half)
    share = np.mod((across + half) / spacing, 1.0)
    if kind == KNIFE:
        share = np.where(share < LEAN, 0.5 * share / LEAN, 0.5 + 0.5 * (share - LEAN) / (1.0 - LEAN))
    elif kind == TUCKS:
        share = np.clip(0.5 + (share - 0.5) / TUCK, 0.0, 1.0)
    return crest(share)


def directions(table: np.ndarray, positions: np.ndarray, polygon_start: np.ndarray,
               corner_vertex: np.ndarray) -> tuple[np.ndarray | None, list[str]]:
    """The paint ALONG of a mesh at rest, from the guides that are directions, or None; and messages. Where lines cross,
    they are mixed: two equally strong ones at right angles cancel each other."""
    table = table[table[:, KIND] == DIRECTION]
    if not len(table):
        return None, []
    surface = _AtRest(positions, polygon_start, corner_vertex)
    found, lines = np.zeros((len(positions), 3)), np.zeros(len(positions), np.int64)
    asked = [surface.direction(guide) for guide in Guide.all_of(table)]
    for rows, along in asked:
        found[rows] = along
        lines[rows] += 1
    several = np.flatnonzero(lines > 1)
    if len(several):
        mixed, number = np.zeros((len(several), 3, 3)), np.full(len(positions), -1)
        number[several] = np.arange(len(several))
        for rows, along in asked:
            along, at = along[number[rows] >= 0], number[rows][number[rows] >= 0]
            mixed[at] += along[:, :, None] * unit(along)[:, None, :]
        strength, axes = principal_axes(mixed)
        found[several] = np.minimum(strength[:, 2] - strength[:, 1], 1.0)[:, None] * axes[:, :, 2]
    return found.astype(np.float32), surface.notes


class _AtRest:
    """Measures the neighbourhood of lines on a mesh at rest."""

    def __init__(self, positions: np.ndarray, start: np.ndarray, corners: np.ndarray) -> None:
        self._rest = np.asarray(positions, np.float64)
        sizes = np.diff(start)
        place = np.arange(len(corners))
        first, last = np.repeat(start[:-1], sizes), np.repeat(start[1:] - 1, sizes)
        self._corner = np.stack([corners, corners[np.where(place == last, first, place + 1)],
                                 corners[np.where(place == first, last, place - 1)]])
        # Vertices at the same place on both sides of a seam move together.
        steps = np.round((self._rest - self._rest.min(axis=0)) / (1e-6 * np.ptp(self._rest, axis=0).max()))
        x, y, z = steps.astype(np.int64).T
        used, self._place = np.unique((x << 42) + (y << 21) + z, return_inverse=True)
        self._normals = _normals(self._rest, self._corner, self._place[corners], len(used))[self._place]
        self._has_face = np.zeros(len(self._rest), bool)  # False for loose vertices and rigid parts
        self._has_face[corners] = True
        self.notes: list[str] = []

    def direction(self, guide: Guide) -> tuple[np.ndarray, np.ndarray]:
        """The vertices near one guide, and ALONG there: full strength within half of its reach, zero beyond the
        reach."""
        reach = guide.spacing
        nothing = np.zeros(0, np.int64), np.zeros((0, 3))
        if len(guide.points) < 2 or not 0.0 < reach < math.inf:
            return nothing
        line, factor = _resampled(guide.points, guide.factor, reach / STEPS)
        near = self._near(line, reach)
        if not len(near):
            self.notes.append(TOO_FAR)
            return nothing
        foot, normal, seeds = self._on_surface(line, near)
        across, _along, beyond, strength, tangent = self._measured(near, foot, normal, factor)
        distance = np.sqrt(across * across + beyond * beyond) / reach
        chosen = self._connected(near, (distance < 1.0) | np.isin(near, seeds), seeds)
        weight = (1.0 - guide.others) * np.clip(strength, 0.0, 1.0) * smoothstep(2.0 - 2.0 * distance)
        normals = self._normals[near]
        tangent = unit(tangent - (tangent * normals).sum(axis=1)[:, None] * normals)
        return near[chosen], (weight[:, None] * tangent)[chosen]

    def _near(self, line: np.ndarray, reach: float) -> np.ndarray:
        low, high = line.min(axis=0) - reach, line.max(axis=0) + reach
        return np.flatnonzero(((self._rest >= low) & (self._rest <= high)).all(axis=1) & self._has_face)

    def _on_surface(self, line: np.ndarray, near: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The points of a line projected onto the surface, the normals there, and the closest vertices."""
        closest = nearest_of(line, self._rest, near)[0]
        normal = self._normals[closest]
        return line + normal * ((self._rest[closest] - line) * normal).sum(axis=1)[:, None], normal, closest

    def _measured(self, near: np.ndarray, foot: np.ndarray, normal: np.ndarray,
                  factor: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """For vertices: the signed distance across the line, measured along the surface; the distance along the line;
        the distance beyond its ends; the factor on the depth; and the direction of the line."""
        points, side = self._rest[near], np.diff(foot, axis=0)
        lengths = np.maximum(np.linalg.norm(side, axis=1), 1e-12)
        best, segment, share = np.full(len(near), np.inf), np.zeros(len(near), np.int64), np.zeros(len(near))
        # steps are short, so the closest segment touches the closest point
        closest = nearest_of(points, foot, np.arange(len(foot)))[0]
        for number in (np.maximum(closest - 1, 0), np.minimum(closest, len(side) - 1)):
            from_begin = points - foot[number]
            at = np.clip(_dot(from_begin, side[number]) / lengths[number] ** 2, 0.0, 1.0)
            from_line = from_begin - at[:, None] * side[number]
            distance = _dot(from_line, from_line)
            closer = distance < best
            best[closer], segment[closer], share[closer] = distance[closer], number[closer], at[closer]
        tangent = (side / lengths[:, None])[segment]
        from_line = points - foot[segment] - (share * lengths[segment])[:, None] * tangent
        along_tangent = _dot(from_line, tangent)
        ends = ((segment == 0) & (share == 0.0)) | ((segment == len(side) - 1) & (share == 1.0))
        closed = length(foot[0] - foot[-1]) < 1e-6 * lengths.sum()
        beyond = np.where(ends & (not closed), np.abs(along_tangent), 0.0)
        under = unit((1.0 - share)[:, None] * normal[segment] + share[:, None] * normal[segment + 1])
        straight = from_line - along_tangent[:, None] * tangent * ends[:, None]
        sign = np.sign(_dot(cross(under, tangent), straight))
        # A chord is shorter than its arc. The angle between the normals at its ends gives the ratio.
        across = sign * np.linalg.norm(straight, axis=1) * _arc_of_chord(_dot(under, self._normals[near]))
        at_begin = np.concatenate([[0.0], np.cumsum(lengths)])[segment]
        depth_factor = (1.0 - share) * factor[segment] + share * factor[segment + 1]
        return across, at_begin + share * lengths[segment], beyond, depth_factor, tangent

    def _connected(self, near: np.ndarray, inside: np.ndarray, seeds: np.ndarray) -> np.ndarray:
        """Which vertices near a line are connected with those under it. The other side of a sleeve is not."""
        is_in = np.zeros(len(self._rest), bool)
        is_in[self._place[near[inside]]] = True  # by place
        ends = self._place[self._corner[:2]]
        ends = ends[:, is_in[ends].all(axis=0)]
        reached = np.zeros(len(self._rest), bool)
        reached[self._place[seeds]] = True
        while True:
            known = reached[ends]
            hit = known[0] != known[1]
            if not hit.any():
                return np.flatnonzero(inside & reached[self._place[near]])
            reached[ends[:, hit]] = True
            ends = ends[:, ~(known[0] & known[1])]


class GuidedFolds(_AtRest):
    """The folds of all guides of a garment, on a native output mesh."""

    def __init__(self, table: np.ndarray, shown: Any) -> None:
        super().__init__(shown.positions_rest, shown.polygon_start, shown.corner_vertex)
        heights, left = np.zeros(len(self._rest)), np.ones(len(self._rest))
        for guide in Guide.all_of(table):
            self._add(guide, heights, left)
        self.rows = np.flatnonzero((heights != 0.0) | (left < 1.0))  # vertices that move
        self.left = left[self.rows].astype(np.float32)  # share of the other folds
        self._heights = heights[self.rows]
        beside = np.zeros(len(self._rest), bool)
        beside[self._place[self.rows]] = True  # by place
        self._corner = self._corner[:, beside[self._place[self._corner[0]]]]
        # Only the places that are used get new numbers.
        used, numbers = np.unique(self._place[self._corner[0]], return_inverse=True)
        self._at_corner, self._places = numbers, len(used)
        self._at_row = np.searchsorted(used, self._place[self.rows])
        self._heights = self._heights.astype(np.float32)

    def displacements(self, positions: np.ndarray) -> np.ndarray:
        """(rows, 3) displacements by these folds. positions: (d, 3) of the shown mesh without them."""
        return self._heights[:, None] * _normals(positions, self._corner, self._at_corner, self._places)[self._at_row]

    # --- one guide, at rest
    def _add(self, guide: Guide, heights: np.ndarray, left: np.ndarray) -> None:
        spacing, half = guide.spacing, 0.5 * guide.count * guide.spacing
        if len(guide.points) < 2 or not 0.0 < half < math.inf:
            return
        line, factor = _resampled(guide.points, guide.factor, spacing / STEPS)
        near = self._near(line, half + spacing)
        if not len(near):
            self.notes.append(TOO_FAR)
            return
        foot, normal, seeds = self._on_surface(line, near)
        across, along, beyond, depth_factor, _tangent = self._measured(near, foot, normal, factor)
        near_enough = (np.abs(across) < half) & (beyond < spacing)
        near_enough |= np.isin(near, seeds)
        chosen = self._connected(near, near_enough, seeds)
        rows_of = near[chosen]
        fade = smoothstep(1.0 - beyond[chosen] / spacing)
        inside = np.abs(across[chosen]) < half
        shape = profile(guide.kind, across[chosen], along[chosen], guide.count, spacing)
        heights[rows_of] += np.where(inside, guide.depth * depth_factor[chosen] * fade * shape, 0.0)
        share = fade * smoothstep((half - np.abs(across[chosen])) / (0.5 * spacing))
        left[rows_of] *= 1.0 - (1.0 - guide.others) * share
        self._note_edges(rows_of, spacing * (TUCK if guide.kind == TUCKS else 1.0))

    def _note_edges(self, rows: np.ndarray, width: float) -> None:
        is_row = np.zeros(len(self._rest), bool)
        is_row[rows] = True
        here, after = self._corner[0], self._corner[1]
        edges = is_row[here] & is_row[after]
        lengths = np.linalg.norm(self._rest[here[edges]] - self._rest[after[edges]], axis=1)
        if not edges.any() or lengths.mean() > FINEST * width:
            self.notes.append("the fine mesh is too coarse for the folds of a guide: make it denser, or the folds "
                              "wider")


def _normals(positions: np.ndarray, corner: np.ndarray, at: np.ndarray, places: int) -> np.ndarray:
    """(places, 3) unit normals; zero where there is no face. corner: (3, c) vertices of each corner, the next and the
    previous one; at: (c,) places."""
    here, after, before = (positions[vertices] for vertices in corner)
    turned = cross(after - here, before - here)
    sums = [np.bincount(at, turned[:, k], places) for k in range(3)]
    return unit(np.stack(sums, axis=1).astype(positions.dtype))


def _dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(n,) dot products of (n, 3). The terms are added one by one, so that all processors round in the same way."""
    return one[:, 0] * other[:, 0] + one[:, 1] * other[:, 1] + one[:, 2] * other[:, 2]


def _arc_of_chord(cosine: np.ndarray) -> np.ndarray:
    """The ratio of an arc to its chord, x / sin x. The argument is the cosine of 2 x, the angle between the normals at
    its ends."""
    sine = np.sqrt(np.clip(0.5 - 0.5 * cosine, 0.0, 1.0))
    half, doubled = sine, 1.0
    for _ in range(3):  # the sines of a half, a quarter and an eighth of the angle
        half, doubled = half / np.sqrt(2.0 + 2.0 * np.sqrt(1.0 - half * half)), 2.0 * doubled
    square, series = half * half, np.ones_like(sine)
    for k in range(ARC_TERMS, 0, -1):  # asin s / s = 1 + s^2 / 6 + 3 s^4 / 40 + ...
        series = 1.0 + series * square * (2 * k - 1) ** 2 / (2 * k * (2 * k + 1))
    return np.where(sine > 1e-6, doubled * half * series / np.maximum(sine, 1e-9), 1.0)


def _resampled(line: np.ndarray, factor: np.ndarray, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """A line whose steps are no longer than `longest`, with at most a thousand additional points."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    longest = max(longest, lengths.sum() / 1000.0, 1e-9)
    places = [np.zeros(1)]
    for number, step in enumerate(lengths):
        pieces = max(math.ceil(step / longest), 1)
        places.append(number + np.arange(1, pieces + 1) / pieces)
    at, known = np.concatenate(places), np.arange(len(line))
    return (np.stack([np.interp(at, known, line[:, k]) for k in range(3)], axis=1), np.interp(at, known, factor))
