# SPDX-License-Identifier: GPL-3.0-or-later
"""ShownMesh: the shown mesh of the library, in the numbering of the artist's meshes. Never imports bpy."""
from __future__ import annotations

from typing import Any

import numpy as np

from .base_mesh import BaseMesh
from .frame_result import Attribute
from .rigid_parts import AttachedParts


class ShownMesh:
    """d vertices, q polygons, k corners, embedded in the triangles of the base.

    If the base or the source was healed, this class translates back: parents are elements of the artist's meshes, and
    faces that lie on others are shown too. Rigid parts of the base come last, unchanged.
    """

    base: BaseMesh  # healed
    source: BaseMesh  # the mesh that it is made from: the base, or an artist's own mesh; healed
    shown: Any  # native
    ATTRIBUTES: tuple[Attribute, ...]  # attributes for shaders and nodes
    # native mesh, and the result of _copied() for it
    _copied_in: tuple[Any, list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = (None, [])

    _attached_to: tuple[Any, AttachedParts | None] = (None, None)  # native mesh, and attached_parts for it

    @property
    def attached_parts(self) -> AttachedParts | None:
        """The rigid parts; None if there are none."""
        if self.base.rigid is None:
            return None
        if self._attached_to[0] is not self.shown:
            self._attached_to = (self.shown, AttachedParts(self.base.positions, self.base.diagonal(), self.base.rigid,
                                                           self.shown))
        return self._attached_to[1]

    @property
    def coarse_count(self) -> int:
        """Number of vertices of the artist's coarse mesh."""
        origin = self.base.origin
        return len(self.base.positions) if origin is None else origin.vertex_count

    @property
    def vertex_count(self) -> int:
        return self.shown.vertex_count + (0 if self.base.rigid is None else len(self.base.rigid.vertex))

    @property
    def polygon_start(self) -> np.ndarray:
        """(q + 1,)"""
        copied, rigid = self._copied(), self.base.rigid
        if not copied and rigid is None:
            return self.shown.polygon_start
        sizes = np.diff(self.shown.polygon_start)
        sizes = np.concatenate([sizes, *(sizes[rows] for rows, _, _ in copied),
                                *([] if rigid is None else [rigid.polygon_size])])
        return np.concatenate([np.zeros(1, np.int32), np.cumsum(sizes, dtype=np.int32)])

    @property
    def corner_vertex(self) -> np.ndarray:
        """(k,)"""
        corners, rigid = self.on_corners(self.shown.corner_vertex), self.base.rigid
        return corners if rigid is None else np.concatenate([corners, self.shown.vertex_count + rigid.corner_vertex])

    @property
    def positions_rest(self) -> np.ndarray:
        """(d, 3) object space."""
        rest, rigid = self.shown.positions_rest, self.base.rigid
        return rest if rigid is None else np.concatenate([rest, self.base.positions[rigid.vertex]])

    @property
    def polygon_parent(self) -> np.ndarray:
        """(q,) polygon of the source of every shown polygon."""
        parents = self.shown.polygon_source
        if self.source.origin is None:
            return parents
        rigid = [] if self.base.rigid is None else [self.base.rigid.polygon]
        return np.concatenate([self.source.origin.polygon[parents], *(parent for _, parent, _ in self._copied()),
                               *rigid])

    @property
    def edges(self) -> np.ndarray:
        """(e, 2) shown edges that lie on an edge of the source."""
        edges, rigid = self.shown.edges, self.base.rigid
        return edges if rigid is None else np.concatenate([edges, self.shown.vertex_count + rigid.edges])

    @property
    def edge_parent(self) -> np.ndarray:
        """(e, 2) vertices of these edges of the source, ascending."""
        if self.source.origin is None:
            return self.shown.edge_sources
        parents, rigid = self.shown.edge_sources, self.base.rigid
        if rigid is not None:
            parents = np.concatenate([parents, rigid.vertex[rigid.edges]])
        return np.sort(self.source.origin.vertex[parents], axis=1)

    @property
    def triangle_vertex(self) -> np.ndarray:
        """(d, 3) coarse vertices that every shown vertex is embedded in."""
        corners, rigid = self.shown.triangle_vertex, self.base.rigid
        if rigid is not None:
            corners = np.concatenate([corners, rigid.triangle])
        return corners if self.base.origin is None else self.base.origin.vertex[corners]

    @property
    def barycentric(self) -> np.ndarray:
        """(d, 2) weights of the second and third of these vertices."""
        weights, rigid = self.shown.barycentric, self.base.rigid
        return weights if rigid is None else np.concatenate([weights, np.zeros((len(rigid.vertex), 2), np.float32)])

    def coarse_triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """For every solved coarse triangle its corners, (t, 3), and its polygon, (t,), in the artist's numbering."""
        corners, polygons, origin = self.base.triangle_corner, self.base.triangle_polygons(), self.base.origin
        return (corners, polygons) if origin is None else (origin.corner[corners], origin.polygon[polygons])

    def carry_points(self, values: np.ndarray) -> np.ndarray:
        """(n, j) float32 values of the source's vertices -> (d, j)."""
        healed = self.source.points(values)
        carried = self.shown.carry_points(np.ascontiguousarray(healed, np.float32), len(self.source.positions))
        rigid = self.base.rigid
        return carried if rigid is None else np.concatenate([carried, np.asarray(healed[rigid.vertex], np.float32)])

    def carry_corners(self, values: np.ndarray) -> np.ndarray:
        """(c, j) float32 values of the source's corners -> (k, j). Seams stay sharp."""
        origin, count = self.source.origin, len(self.source.corner_vertex)
        if origin is None:
            return self.shown.carry_corners(np.ascontiguousarray(values, np.float32), count)
        if len(values) != origin.corner_count:
            raise ValueError(f"corner values: expected {origin.corner_count} rows, got {len(values)}")
        parts = [self.shown.carry_corners(np.ascontiguousarray(values[origin.corner], np.float32), count)]
        for copies, (_, _, rows) in zip(origin.copies, self._copied()):
            of_copies = np.ascontiguousarray(values[copies.corner], np.float32)
            parts.append(self.shown.carry_corners(of_copies, count)[rows])
        if self.base.rigid is not None:
            parts.append(np.asarray(values[self.base.rigid.corner], np.float32))
        return np.concatenate(parts)

    def on_corners(self, values: np.ndarray) -> np.ndarray:
        """(corners of the solved fine mesh, ...) -> (k, ...). Faces that lie on others get the values of the faces
        below."""
        copied = self._copied()
        return np.concatenate([values, *(values[rows] for _, _, rows in copied)]) if copied else values

    def _copied(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """For each group of copies: the native polygons that are shown again, their parents, and their corners."""
        if self.source.origin is None or not self.source.origin.copies:
            return []
        if self._copied_in[0] is not self.shown:
            self._copied_in = (self.shown, [self._copied_of(copies) for copies in self.source.origin.copies])
        return self._copied_in[1]

    def _copied_of(self, copies: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        start, parents = self.shown.polygon_start, self.shown.polygon_source
        order = np.argsort(copies.lies_on)
        place = np.searchsorted(copies.lies_on, parents, sorter=order)
        place = order[np.minimum(place, len(order) - 1)]
        rows = np.flatnonzero(copies.lies_on[place] == parents)
        corners = [np.arange(start[row], start[row + 1])[::-1 if copies.is_turned[place[row]] else 1] for row in rows]
        return rows, copies.polygon[place[rows]], np.concatenate(corners) if corners else np.empty(0, np.int64)


class ViewportMesh(ShownMesh):
    """The mesh of viewports, if it has fewer unsolved subdivisions than the mesh of renders. It shows the same folds
    with fewer vertices."""

    def __init__(self, base: BaseMesh, source: BaseMesh, shown: Any, attributes: tuple[Attribute, ...]) -> None:
        """shown: native."""
        self.base, self.source, self.shown, self.ATTRIBUTES = base, source, shown, attributes
