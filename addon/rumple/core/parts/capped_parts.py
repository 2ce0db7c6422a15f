# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds caps: flat panels that close the sleeves, legs, collar and hem of garments made for games. A cap is hidden
inside the body or inside other clothes. It is not cloth, so it gets no folds. Never imports bpy."""
from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base.triangles import area_vectors, vertex_normals
from ..base.vertices import PAIRS_AT_ONCE, diagonals, lengths, nearest_of, pair_keys, sample_of
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import lowest_connected

INSIDE = 0.5  # winding number from which a point is inside
MOSTLY = 0.5  # share of a border's vertices that are inside a part: then the border ends in it
# cosine between the normals of neighbours: at the edge of a cap the angle is 50 degrees or more
CREASE = math.cos(math.radians(40.0))
FLAT, MOST_AREA = 0.5, 0.2  # of a cap: least share of its area that faces one way; largest share of the garment's area
ROUND = 0.06  # least area / diagonal^2 of a cap: a disc has 0.4, the strip of a pleat at most 0.03
UPRIGHT = 0.7  # largest cosine between the normals of a cap and of the part that goes through it
# Abramowitz and Stegun, Handbook of Mathematical Functions, 4.4.49.
ARC_TANGENT = (-0.3333314528, 0.1999355085, -0.1420889944, 0.1065626393, -0.0752896400, 0.0429096138, -0.0161657367,
               0.0028662257)
OF_CAP, OF_BODY = 24, 500  # how many polygons of a cap, and how many vertices of a body, are sampled
MOST_PANELS = 500  # how many panels are tested, the largest ones


def ends_in(base: BaseMesh, ends: list[tuple[int, np.ndarray]], part: np.ndarray, hosts: np.ndarray) -> np.ndarray:
    """(k, h) bool: which borders end inside which parts. ends: for each border its part and some of its vertices. part:
    (n,) the part of each vertex. hosts: (h,) numbers of parts that are closed or nearly closed. Cost: see winding()."""
    of_triangle = part[base.triangles[:, 0]]
    inside = np.zeros((len(ends), len(hosts)), bool)
    for column, host in enumerate(hosts.tolist()):
        corners = base.positions[base.triangles[of_triangle == host]]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        for row, (number, border) in enumerate(ends):
            points = base.positions[border]
            if number != host and ((points >= low) & (points <= high)).all(axis=1).mean() >= MOSTLY:
                inside[row, column] = (winding(points, corners) > INSIDE).mean() >= MOSTLY
    return inside


def find_caps(base: BaseMesh, part: np.ndarray, place: np.ndarray, garments: np.ndarray,
              bodies: np.ndarray) -> np.ndarray:
    """(p,) for each polygon the number of its cap, counted from 1; 0: it belongs to none. A cap is a flat panel of a
    garment, bounded by creases, and another part goes through it. part, place: (n,) of the vertices, see connected.py.
    garments: (parts,) bool, parts that may have caps. bodies: (parts,) bool, parts that may go through them: limbs and
    other garments. Cost: 20 ms for 10,000 polygons, and the cost of winding()."""
    own = part[base.corner_vertex[base.polygon_start[:-1]]]
    caps = np.zeros(len(own), bool)
    asked = np.flatnonzero(garments[own])
    if not len(asked):
        return caps.astype(np.int32)
    within = {body: _Body.of(base, base.triangles[part[base.triangles[:, 0]] == body])
              for body in np.flatnonzero(bodies).tolist()}
    middles, normals = _middles(base), _polygon_normals(base)
    areas = lengths(normals)
    most = MOST_AREA * np.bincount(own, areas, len(garments))
    _, first, panel = np.unique(_panels(base, place, normals)[asked], return_index=True, return_inverse=True)
    area = np.bincount(panel.ravel(), areas[asked])
    one_way = np.stack([np.bincount(panel.ravel(), normals[asked, k]) for k in range(3)], axis=1)
    panel_of_polygon = np.full(len(own), -1)
    panel_of_polygon[asked] = panel.ravel()
    candidates = np.flatnonzero((area <= most[own[asked[first]]]) & (lengths(one_way) >= FLAT * area)
                                & (area > ROUND * _sizes(base, panel_of_polygon, len(area)) ** 2))
    for number in candidates[np.argsort(-area[candidates], kind="stable")[:MOST_PANELS]].tolist():
        polygons = asked[panel.ravel() == number]
        some = middles[sample_of(polygons, OF_CAP)]
        caps[polygons] = any(body.goes_through(some, one_way[number]) for part_of_it, body in within.items()
                             if part_of_it != own[polygons[0]])
    return _numbered(base, place, caps)


def _sizes(base: BaseMesh, panel: np.ndarray, count: int) -> np.ndarray:
    """(count,) the diagonals of panels. panel: (p,) the panel of each polygon, -1 for none."""
    of_corner = np.repeat(panel, np.diff(base.polygon_start))
    points, of = base.positions[base.corner_vertex[of_corner >= 0]], of_corner[of_corner >= 0]
    return diagonals(points, of, count)


def _numbered(base: BaseMesh, place: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """(p,) the number of each connected set of the chosen polygons, counted from 1; 0 for the others."""
    sizes = np.diff(base.polygon_start)
    first = np.repeat(place[base.corner_vertex[base.polygon_start[:-1]]], sizes)
    within = np.repeat(chosen, sizes)
    label = lowest_connected(np.arange(int(place.max()) + 1), first[within], place[base.corner_vertex][within])
    numbers = np.zeros(len(chosen), np.int32)
    of_chosen = label[place[base.corner_vertex[base.polygon_start[:-1]]][chosen]]
    numbers[chosen] = np.unique(of_chosen, return_inverse=True)[1].ravel() + 1
    return numbers


def winding(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(n,) float64: the absolute winding numbers of triangles (t, 3, 3) around points (n, 3) (Jacobson, Kavan and
    Sorkine-Hornung 2013, equation 5, with the solid angles of van Oosterom and Strackee 1983). Cost: half a microsecond
    for each pair of a point and a triangle."""
    out = np.zeros(len(points))
    step = max(PAIRS_AT_ONCE // max(len(corners), 1), 1)
    for first in range(0, len(points), step):
        of = points[first:first + step, None, None].astype(np.float64)
        a, b, c = np.moveaxis(corners[None].astype(np.float64) - of, 2, 0)
        la, lb, lc = (lengths(side) for side in (a, b, c))
        volume = (a * np.cross(b, c)).sum(-1)
        turned = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
        out[first:first + step] = np.abs(_angle(volume, turned).sum(axis=1)) / (2.0 * np.pi)
    return out


def _angle(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Like numpy.arctan2, exact to 2e-8, with the same bits on every system."""
    high, low = np.maximum(np.abs(x), np.abs(y)), np.minimum(np.abs(x), np.abs(y))
    ratio = low / np.maximum(high, 1e-300)
    square, series = ratio * ratio, np.zeros_like(ratio)
    for factor in ARC_TANGENT[::-1]:
        series = (series + factor) * square
    angle = (1.0 + series) * ratio
    angle = np.where(np.abs(y) > np.abs(x), 0.5 * np.pi - angle, angle)
    angle = np.where(x < 0.0, np.pi - angle, angle)
    return np.where(y < 0.0, -angle, angle)


@dataclass(frozen=True)
class _Body:
    """A part that may be inside a garment."""

    corners: np.ndarray  # (t, 3, 3) of its triangles
    low: np.ndarray  # (3,) of its box
    high: np.ndarray  # (3,)
    places: np.ndarray  # (v, 3) of some of its vertices
    normals: np.ndarray  # (v, 3) unit, of these

    @classmethod
    def of(cls, base: BaseMesh, triangles: np.ndarray) -> "_Body":
        corners, some = base.positions[triangles], sample_of(np.unique(triangles), OF_BODY)
        normals = vertex_normals(base.positions, triangles)[some]
        return cls(corners, corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), base.positions[some],
                   normals / np.maximum(lengths(normals), 1e-30)[:, None])

    def goes_through(self, points: np.ndarray, normal: np.ndarray) -> bool:
        """Whether it goes through a panel. Then some points of the panel are inside it, and its surface is
        perpendicular to the panel there, as a neck is in a collar. Where skin only pokes through cloth, both surfaces
        face the same way."""
        points = points[((points >= self.low) & (points <= self.high)).all(axis=1)]
        if not len(points):
            return False
        nearest = nearest_of(points, self.places, np.arange(len(self.places)))[0]
        across = np.abs(self.normals[nearest] @ normal) / float(lengths(normal))
        behind = ((points - self.places[nearest]) * self.normals[nearest]).sum(axis=1) < 0.0
        # Strips of a pleat lie along the body. This fast test excludes them before the slow one.
        if not (behind & (across < UPRIGHT)).any():
            return False
        inside = np.flatnonzero(behind)[winding(points[behind], self.corners) > INSIDE]
        return len(inside) > 0 and bool(across[inside].mean() < UPRIGHT)


def _panels(base: BaseMesh, place: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(p,) for each polygon the lowest polygon number of its panel. Polygons are in one panel if sides that are no
    creases connect them. normals: (p, 3) of any length."""
    key = pair_keys(place[base.sides()], len(place))
    of = np.repeat(np.arange(len(normals)), np.diff(base.polygon_start))
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    first, other = of[order[same]], of[order[same + 1]]
    size = lengths(normals)
    smooth = (normals[first] * normals[other]).sum(axis=1) > CREASE * size[first] * size[other]
    return lowest_connected(np.arange(len(normals)), first[smooth], other[smooth])


def _polygon_normals(base: BaseMesh) -> np.ndarray:
    """(p, 3): the sums of the area vectors of the triangles of each polygon."""
    of = np.repeat(np.arange(len(base.polygon_start) - 1), np.diff(base.polygon_start))[base.triangle_corner[:, 0]]
    normals = np.zeros((len(base.polygon_start) - 1, 3))
    np.add.at(normals, of, area_vectors(base.positions, base.triangles))
    return normals


def _middles(base: BaseMesh) -> np.ndarray:
    """(p, 3) means of the corners of the polygons."""
    sums = np.add.reduceat(base.positions[base.corner_vertex].astype(np.float64), base.polygon_start[:-1])
    return sums / np.diff(base.polygon_start)[:, None]
