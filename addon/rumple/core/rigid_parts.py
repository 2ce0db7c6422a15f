# SPDX-License-Identifier: GPL-3.0-or-later
"""Small loose parts of a garment, such as buttons and buckles: they are no cloth. They are shown as they were modelled
and ride on the cloth around them. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..native import kernels
from .frame_result import Attribute, FrameResult

if TYPE_CHECKING:
    from .base_mesh import BaseMesh

SMALL, SMALL_AND_CLOSED = 0.05, 0.12  # of the largest part's diagonal: sheets, and bodies without a border
MOST_AREA = 0.25  # of the mesh: where small parts are more of it, they are what it is made of (mail, scales, patches)
FAR = 0.02  # of the largest part's diagonal: what is so far from the cloth is not fixed to it
FEWEST_ANCHORS, MOST_ANCHORS = 8, 64


@dataclass(frozen=True)
class RigidParts:
    """Those of a mesh. m vertices, e edges, k polygons, c corners. Vertices are those of the mesh that they were taken
    from."""

    part: np.ndarray  # (m,) int32: number of its part
    vertex: np.ndarray  # (m,) int32
    triangle: np.ndarray  # (m, 3) int32: a triangle of vertices that begins with it
    edges: np.ndarray  # (e, 2) int32: rows of `vertex`
    polygon: np.ndarray  # (k,) int32, as the artist has them
    polygon_size: np.ndarray  # (k,)
    corner: np.ndarray  # (c,) int32, as the artist has them
    corner_vertex: np.ndarray  # (c,) int32: row of `vertex`

    @property
    def count(self) -> int:
        """Of the parts."""
        return int(self.part.max()) + 1


def without_rigid_parts(base: "BaseMesh", weld: bool) -> "BaseMesh":
    """The healed mesh without the faces of its rigid parts, which it has in `rigid`; their vertices stay, without a
    face. weld: vertices at one place are one. Cost: about 0.3 s for 50,000 vertices."""
    parts = connected_parts(base, weld)
    chosen = _rigid(base, parts, weld)
    if not chosen.any():
        return base
    sizes = np.diff(base.polygon_start)
    is_rigid = chosen[parts[base.corner_vertex[base.polygon_start[:-1]]]]
    corner_is_rigid = np.repeat(is_rigid, sizes)
    origin = base.own_origin()
    if any(is_rigid[copies.lies_on].any() for copies in origin.copies):
        return base  # a doubled button: rather solved as cloth than shown once
    kept_polygon, kept_corner = np.cumsum(~is_rigid) - 1, np.cumsum(~corner_is_rigid) - 1
    copies = [replace(one, corner=one.corner[~corner_is_rigid], lies_on=kept_polygon[one.lies_on].astype(np.int32))
              for one in origin.copies]
    triangles = base.triangle_corner[~corner_is_rigid[base.triangle_corner[:, 0]]]
    return replace(
        base, polygon_start=_starts(sizes[~is_rigid]), corner_vertex=base.corner_vertex[~corner_is_rigid],
        triangle_corner=np.ascontiguousarray(kept_corner[triangles], np.int32),
        uv=None if base.uv is None else np.ascontiguousarray(base.uv[~corner_is_rigid]),
        origin=replace(origin, corner=origin.corner[~corner_is_rigid], polygon=origin.polygon[~is_rigid],
                       copies=copies),
        rigid=_taken(base, parts, is_rigid, corner_is_rigid))


def connected_parts(base: "BaseMesh", weld: bool) -> np.ndarray:
    """(n,) int32: for every vertex the number of its connected part, counted from 0; loose vertices have their own."""
    places = np.arange(len(base.positions))
    if weld:
        places = np.unique(base.positions, axis=0, return_inverse=True)[1].ravel()
    first = places[base.corner_vertex[np.repeat(base.polygon_start[:-1], np.diff(base.polygon_start))]]
    other = places[base.corner_vertex]
    label = np.arange(len(base.positions))
    while True:
        lower = label.copy()
        np.minimum.at(lower, first, label[other])
        np.minimum.at(lower, other, label[first])
        lower = lower[lower]
        if np.array_equal(lower, label):
            return np.unique(label[places], return_inverse=True)[1].ravel().astype(np.int32)
        label = lower


def _rigid(base: "BaseMesh", parts: np.ndarray, weld: bool) -> np.ndarray:
    """(parts,) bool."""
    count = int(parts.max(initial=-1)) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, parts, base.positions)
    np.maximum.at(high, parts, base.positions)
    diagonal = np.linalg.norm(high - low, axis=1)
    corners = base.positions[base.corner_vertex[base.triangle_corner]].astype(np.float64)
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    area = np.bincount(parts[base.corner_vertex[base.triangle_corner[:, 0]]], areas, count)
    size = diagonal.max(initial=0.0)
    limit = np.where(_closed(base, parts, count, weld), SMALL_AND_CLOSED, SMALL) * size
    chosen = (diagonal <= limit) & (area > 0.0)
    return chosen if area[chosen].sum() <= MOST_AREA * area.sum() else np.zeros(count, bool)


def _closed(base: "BaseMesh", parts: np.ndarray, count: int, weld: bool) -> np.ndarray:
    """(parts,) bool: it has no border."""
    places = np.arange(len(base.positions))
    if weld:
        places = np.unique(base.positions, axis=0, return_inverse=True)[1].ravel()
    sides = _sides(base)
    ends = np.sort(places[sides], axis=1)
    _, first, uses = np.unique(ends, axis=0, return_index=True, return_counts=True)
    closed = np.ones(count, bool)
    closed[parts[sides[first[uses == 1], 0]]] = False
    return closed


def _sides(base: "BaseMesh") -> np.ndarray:
    """(c, 2) vertices of the sides of all polygons, corner by corner."""
    following = np.arange(1, len(base.corner_vertex) + 1)
    following[base.polygon_start[1:] - 1] = base.polygon_start[:-1]
    return np.stack([base.corner_vertex, base.corner_vertex[following]], 1)


def _starts(sizes: np.ndarray) -> np.ndarray:
    return np.concatenate([np.zeros(1, np.int32), np.cumsum(sizes, dtype=np.int32)])


def _taken(base: "BaseMesh", parts: np.ndarray, is_rigid: np.ndarray, corner_is_rigid: np.ndarray) -> RigidParts:
    origin, corner_vertex = base.own_origin(), base.corner_vertex[corner_is_rigid]
    vertex, rows = np.unique(corner_vertex, return_inverse=True)
    sides = np.unique(np.sort(_sides(base)[corner_is_rigid], axis=1), axis=0)
    triangles = base.corner_vertex[base.triangle_corner[corner_is_rigid[base.triangle_corner[:, 0]]]]
    turned = np.concatenate([np.roll(triangles, -k, axis=1) for k in range(3)])
    place = np.unique(turned[:, 0], return_index=True)[1]  # every vertex of a polygon is in one of its triangles
    return RigidParts(np.unique(parts[vertex], return_inverse=True)[1].ravel().astype(np.int32),
                      vertex.astype(np.int32), turned[place].astype(np.int32),
                      np.searchsorted(vertex, sides).astype(np.int32),
                      origin.polygon[is_rigid], np.diff(base.polygon_start)[is_rigid],
                      origin.corner[corner_is_rigid], rows.ravel().astype(np.int32))


class Riders:
    """The rigid parts of one shown mesh, and what of the cloth around them each is fixed to: the shown vertices that
    are nearest to it at rest. A part that is far from all cloth stays where it is animated."""

    def __init__(self, base: "BaseMesh", parts: RigidParts, shown: kernels.ShownMesh) -> None:
        """base: without the parts. shown: of the cloth, at rest."""
        self.parts, self._rest = parts, base.positions[parts.vertex]
        cloth = np.unique(shown.corner_vertex)
        rest = shown.positions_rest[cloth]
        size = base.diagonal()
        found = [cloth[_anchors(self._rest[parts.part == part], rest, size)] for part in range(parts.count)]
        self._starts = _starts(np.array([len(anchors) for anchors in found]))
        self._anchors = np.concatenate(found)
        self._corners, weights = shown.triangle_vertex[self._anchors], shown.barycentric[self._anchors]
        self._weights = np.concatenate([1.0 - weights.sum(1, keepdims=True), weights], 1)[:, :, None]
        # Where the anchors are from the flat triangles of the coarse mesh: as far as that they are in every pose.
        frames, points = self._embedded(base.positions)
        self._from_base = _rowwise(frames, shown.positions_rest[self._anchors] - points)

    def ride(self, animated: np.ndarray, cloth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where the m vertices are, and that in the frames of their triangles of the animated mesh: (m, 3) each.

        animated: (n, 3) of the coarse mesh; cloth: (d, 3) of the shown one, both float32, object space. Each part is
        moved by the rigid motion that is nearest to what moved its anchors from the animated surface.
        """
        frames, points = self._embedded(animated)
        moved = self._moved(animated, points + _columnwise(frames, self._from_base), cloth[self._anchors])
        return moved, _rowwise(_frames(animated, self.parts.triangle), moved - animated[self.parts.vertex])

    def ways(self, animated: np.ndarray, over: np.ndarray) -> np.ndarray:
        """(m, 3): how far the parts go with the base cloth alone, (n, 3): where the shown mesh is not made."""
        moved = self._moved(animated, self._embedded(animated)[1], self._embedded(over)[1])
        return moved - animated[self.parts.vertex]

    def _moved(self, animated: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        motions = kernels.rigid_motions(self._starts, np.ascontiguousarray(before, np.float32),
                                        np.ascontiguousarray(after, np.float32))[self.parts.part]
        return _rowwise(motions[:, :3], animated[self.parts.vertex]) + motions[:, 3]

    def add_to(self, result: FrameResult, animated: np.ndarray, corners: int,
               attributes: tuple[Attribute, ...]) -> None:
        """Append the parts to the picture of the cloth. corners: of the whole shown mesh."""
        positions, local_offset = self.ride(animated, result.positions)
        rest = FrameResult.at_rest(positions, len(self.parts.corner_vertex), attributes).attributes
        result.positions = np.concatenate([result.positions, positions])
        result.local_offset = np.concatenate([result.local_offset, local_offset])
        for a in attributes:
            values = result.attributes[a.name]
            if a.domain == "POINT" or len(values) < corners:  # corners that nothing was solved for are there already
                result.attributes[a.name] = np.concatenate([values, rest[a.name]])

    def _embedded(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Frames of the anchors' triangles, and the anchors' points on them."""
        corner = positions[self._corners]
        return _frames(positions, self._corners), (self._weights * corner).sum(1)


def _anchors(part: np.ndarray, cloth: np.ndarray, size: float) -> np.ndarray:
    """The rows of the cloth that a part is fixed to. size: of the garment."""
    centre = part.mean(0)
    radius = float(np.linalg.norm(part - centre, axis=1).max())
    distance = np.linalg.norm(cloth - centre, axis=1)
    order = np.argsort(distance, kind="stable")[:MOST_ANCHORS]
    if not len(order) or distance[order[0]] > 2.0 * radius + FAR * size:
        return order[:0]
    near = max(int(np.searchsorted(distance[order], distance[order[0]] + radius)), FEWEST_ANCHORS)
    return order[:near]


def _frames(positions: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(k, 3, 3) float32: rows t, b, n of triangles, as the node tree has them; zeros where a triangle collapsed."""
    origin = positions[corners[:, 0]]
    side = positions[corners[:, 1]] - origin
    t, n = _unit(side), _unit(np.cross(side, positions[corners[:, 2]] - origin))
    return np.stack([t, np.cross(n, t), n], 1)


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.sqrt((vectors * vectors).sum(1, keepdims=True))
    return vectors / np.where(length > 0.0, length, 1.0)


def _rowwise(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(k, 3): M x. Not by a library for matrices: those give other bits on other processors."""
    return (matrices * vectors[:, None, :]).sum(2)


def _columnwise(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """(k, 3): the transposed M times x."""
    return (matrices * vectors[:, :, None]).sum(1)
