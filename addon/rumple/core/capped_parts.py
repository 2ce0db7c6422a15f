# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments of games whose sleeves, legs, collar and hem are closed by caps, so that nobody looks into them. The caps
are hidden inside of the body and of other clothes: they are no cloth. Never imports bpy."""
from __future__ import annotations

import math

import numpy as np

from .base_mesh import BaseMesh
from .connected import lowest_connected
from .samples import lengths, sample_of
from .triangles import area_vectors, winding

INSIDE = 0.5  # winding number
MOSTLY = 0.5  # of the vertices of a border: where it ends
CREASE = math.cos(math.radians(40.0))  # between the normals of neighbours: at a cap there are 50 degrees and more
FLAT, MOST_AREA = 0.5, 0.2  # of a cap: how much of its area looks one way, and its share of the garment's
OF_CAP = 24  # polygons at most that are looked at


def ends_in(base: BaseMesh, ends: list[tuple[int, np.ndarray]], part: np.ndarray, hosts: np.ndarray) -> np.ndarray:
    """(k, h) bool: which borders end inside of which parts. ends: k times the part of a border, and vertices of it.
    part: (n,) of the vertices. hosts: (h,) numbers of parts that are closed, or nearly so. Cost: that of winding()."""
    of_triangle = part[base.triangles[:, 0]]
    inside = np.zeros((len(ends), len(hosts)), bool)
    for column, host in enumerate(hosts.tolist()):
        corners = base.positions[base.triangles[of_triangle == host]]
        for row, (number, border) in enumerate(ends):
            if number != host:
                inside[row, column] = (winding(base.positions[border], corners) > INSIDE).mean() >= MOSTLY
    return inside


def find_caps(base: BaseMesh, part: np.ndarray, place: np.ndarray, capped: np.ndarray,
              bodies: np.ndarray) -> np.ndarray:
    """(p,) the number of the cap that each polygon of a garment is of, counted from 1; 0 for none. Caps are flat panels
    between creases that reach into another part. part, place: (n,) of the vertices, as connected.py has them. capped:
    (parts,) bool of the garments; bodies: (parts,) bool of what may be inside of them. Cost: 20 ms for 10,000 polygons,
    and that of winding()."""
    own = part[base.corner_vertex[base.polygon_start[:-1]]]
    caps = np.zeros(len(own), np.int32)
    if not capped.any():
        return caps
    corners_of = {body: base.positions[base.triangles[part[base.triangles[:, 0]] == body]]
                  for body in np.flatnonzero(bodies).tolist()}
    middles, normals = _middles(base), _polygon_normals(base)
    areas = lengths(normals)
    most = MOST_AREA * np.bincount(own, areas, len(capped))
    asked = np.flatnonzero(capped[own])
    panels = _panels(base, place, normals)[asked]
    ends = np.cumsum(np.unique(panels, return_counts=True)[1])
    for polygons in np.split(asked[np.argsort(panels, kind="stable")], ends[:-1]):
        area = areas[polygons].sum()
        if area > most[own[polygons[0]]] or lengths(normals[polygons].sum(axis=0)) < FLAT * area:
            continue
        some = middles[sample_of(polygons, OF_CAP)]
        if any(_is_inside(some, corners) for body, corners in corners_of.items() if body != own[polygons[0]]):
            caps[polygons] = caps.max() + 1
    return caps


def _is_inside(points: np.ndarray, corners: np.ndarray) -> bool:
    """Whether one of the points is inside of triangles (t, 3, 3)."""
    within = ((points >= corners.min(axis=(0, 1))) & (points <= corners.max(axis=(0, 1)))).all(axis=1)
    return bool(within.any() and (winding(points[within], corners) > INSIDE).any())


def _panels(base: BaseMesh, place: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(p,) for each polygon the lowest number of those that it is joined with over sides that are no crease. normals:
    (p, 3) of any length."""
    ends = np.sort(place[base.sides()].astype(np.int64), axis=1)
    of = np.repeat(np.arange(len(normals)), np.diff(base.polygon_start))
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    same = np.flatnonzero((ends[order[1:]] == ends[order[:-1]]).all(axis=1))
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
