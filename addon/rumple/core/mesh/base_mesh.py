# SPDX-License-Identifier: GPL-3.0-or-later
"""BaseMesh: a coarse mesh at rest, and how it becomes a checked surface. Never imports bpy."""
from __future__ import annotations

import contextlib
import functools
import math
from dataclasses import dataclass, replace
from typing import Any, Callable, Iterator

import numpy as np

from ...native import kernels
from ..base.digests import digest_of
from ..base.triangles import area_vectors
from ..base.vertices import lengths
from ..base.wording import user_error
from .healing import Origin, creases_of, origin_of, origin_of_itself
from .rigid_parts import RigidParts

_built: dict[bytes, Any] | None = None  # results of the library within built_once(), by digest of the arrays
MOST_LEVEL = 5  # subdivisions
RAISE_MOST = "raise Most Vertices"  # how the limit on a fine mesh is lifted


@contextlib.contextmanager
def built_once() -> Iterator[None]:
    """A context in which equal meshes are healed, made a surface and searched for an inner side only once. It is for
    the first click, which reads a garment several times before its wrinkles are built. All results are kept until the
    context ends."""
    global _built
    _built = {}
    try:
        yield
    finally:
        _built = None


@dataclass
class BaseMesh:
    """A polygon mesh at rest, object space. float32 and int32, C-contiguous."""

    name: str
    positions: np.ndarray  # (n, 3) float32
    polygon_start: np.ndarray  # (p + 1,) int32
    corner_vertex: np.ndarray  # (c,) int32
    triangle_corner: np.ndarray  # (t, 3) int32, corner indices
    uv: np.ndarray | None = None  # (c, 2) float32 of the UV map that renders use
    origin: Origin | None = None  # where its elements come from, if it was healed or its rigid parts were removed
    rigid: RigidParts | None = None  # the rigid parts that were removed from it
    painted_rigid: np.ndarray | None = None  # (n,) bool of the artist's vertices: painted as rigid
    narrowest: float = 1.0  # the smallest painted factor on the width of folds, see narrowest_of()
    figure: float = 0.0  # height of its wearer at rest, object units; 0: unknown
    # (k, 2) int32, vertices of the creased edges, which the fine mesh rounds less
    crease_edge: np.ndarray | None = None
    # (k,) float32: for how many subdivisions an edge stays sharp; 10 or more: always
    crease_sharpness: np.ndarray | None = None

    @functools.cached_property
    def triangles(self) -> np.ndarray:
        """(t, 3) int32, vertices. The same array every time."""
        return self.corner_vertex[self.triangle_corner]

    def healed(self, weld: bool) -> "BaseMesh":
        """This mesh if it is an oriented manifold, otherwise a healed copy. Raises UserError."""
        if self.origin is not None:
            return self
        healed = self._native(kernels.heal_mesh, weld)
        origin = origin_of(healed, self.polygon_start, self.corner_vertex, len(self.positions))
        if not origin.kinds():
            return self
        mesh = BaseMesh(self.name, np.ascontiguousarray(self.positions[origin.vertex]), healed.polygon_start,
                        healed.corner_vertex, healed.triangle_corner,
                        None if self.uv is None else np.ascontiguousarray(self.uv[origin.corner]), origin)
        mesh.painted_rigid, mesh.narrowest, mesh.figure = self.painted_rigid, self.narrowest, self.figure
        if self.crease_edge is not None and self.crease_sharpness is not None:
            mesh.crease_edge, mesh.crease_sharpness = creases_of(self.crease_edge, self.crease_sharpness, origin,
                                                                 mesh.sides())
        return mesh

    def own_origin(self) -> Origin:
        """Where its elements come from, also for a mesh that was not changed."""
        return self.origin or origin_of_itself(len(self.positions), len(self.polygon_start) - 1,
                                               len(self.corner_vertex))

    def surface(self, weld: bool) -> kernels.Surface:
        """The checked native surface. Raises UserError if the mesh is not an oriented manifold."""
        return self._native(kernels.build_surface, weld, self.crease_edge, self.crease_sharpness)

    def points(self, values: np.ndarray) -> np.ndarray:
        """Values (n, ...) of the artist's vertices -> the same values of this mesh's vertices."""
        return values if self.origin is None else values[self.origin.vertex]

    def _native(self, build: Callable[..., Any], weld: bool, *more: np.ndarray | None) -> Any:
        arrays = self.positions, self.polygon_start, self.corner_vertex, self.triangle_corner

        def make() -> Any:
            try:
                return build(*arrays, weld, *more)
            except ValueError as error:
                raise user_error(self.name, error) from error
        return self.once(f"{build.__name__} {weld}", make, *more)

    def once(self, what: str, make: Callable[[], Any], *more: np.ndarray | None) -> Any:
        """make(), which depends only on `what`, `more` and the polygons; within built_once() once for equal ones."""
        built = _built
        if built is None:
            return make()
        key = digest_of(what.encode(), self.positions, self.polygon_start, self.corner_vertex, self.triangle_corner,
                        *more)
        if key not in built:
            built[key] = make()
        return built[key]

    def only(self, kept: np.ndarray) -> "BaseMesh":
        """A mesh with some of the polygons and all vertices. kept: (p,) bool. Copies that lie on a removed polygon are
        removed too."""
        sizes, origin = np.diff(self.polygon_start), self.own_origin()
        corners = np.repeat(kept, sizes)
        polygon, corner = np.cumsum(kept) - 1, np.cumsum(corners) - 1
        copies = []
        for of in origin.copies:
            stays = kept[of.lies_on]
            copies.append(replace(of, corner=of.corner[corners], polygon=of.polygon[stays],
                                  lies_on=polygon[of.lies_on[stays]].astype(np.int32), is_turned=of.is_turned[stays]))
        triangles = self.triangle_corner[corners[self.triangle_corner[:, 0]]]
        return replace(
            self, polygon_start=np.concatenate([np.zeros(1, np.int32), np.cumsum(sizes[kept], dtype=np.int32)]),
            corner_vertex=self.corner_vertex[corners],
            triangle_corner=np.ascontiguousarray(corner[triangles], np.int32),
            uv=None if self.uv is None else np.ascontiguousarray(self.uv[corners]),
            origin=replace(origin, corner=origin.corner[corners], polygon=origin.polygon[kept], copies=copies))

    def mean_edge(self) -> float:
        """Mean length of the polygons' sides, object units."""
        first, second = self.sides().T
        sides = self.positions[second] - self.positions[first]
        return float(np.linalg.norm(sides, axis=1).mean()) if len(sides) else 0.0

    def mean_edge_by_area(self) -> float:
        """Mean length of the sides around a random point of the surface, object units. It is that of cloth also where a
        small part, like a face or a row of buttons, has most of the edges."""
        first, second = self.sides().T
        sides = lengths(self.positions[second] - self.positions[first])
        corners = np.diff(self.polygon_start)
        weight = np.repeat(self.polygon_areas() / corners, corners)
        return float((weight * sides).sum() / weight.sum()) if weight.sum() > 0.0 else self.mean_edge()

    def is_of_triangles(self) -> bool:
        """Whether most of its polygons are triangles."""
        sizes = np.diff(self.polygon_start)
        return bool(2 * np.count_nonzero(sizes == 3) > len(sizes))

    def polygon_areas(self) -> np.ndarray:
        """(p,) float64, object units^2."""
        areas = lengths(area_vectors(self.positions, self.triangles))
        return np.bincount(self.triangle_polygons(), areas, len(self.polygon_start) - 1)

    def triangle_polygons(self) -> np.ndarray:
        """(t,) int32: the polygon of every triangle."""
        after = np.searchsorted(self.polygon_start, self.triangle_corner[:, 0], side="right")
        return (after - 1).astype(np.int32)

    def sides(self) -> np.ndarray:
        """(c, 2) int32: the vertices of the polygons' sides, corner by corner."""
        following = np.arange(1, len(self.corner_vertex) + 1)
        following[self.polygon_start[1:] - 1] = self.polygon_start[:-1]
        return np.stack([self.corner_vertex, self.corner_vertex[following]], 1)

    def level_for(self, longest: float, unit_scale: float) -> int:
        """How often it is subdivided for edges of about `longest` metres. unit_scale: metres per object unit."""
        return min(math.ceil(math.log2(max(self.mean_edge() * unit_scale / longest, 1.0))), MOST_LEVEL)

    def level_within(self, level: int, steps: int, most_vertices: int,
                     corners: int | None = None) -> tuple[int, list[str]]:
        """affordable_level() of this mesh, and a message if it is less than was asked for. corners: how many corners
        the subdivided polygons have; None: those of this mesh."""
        affordable = affordable_level((len(self.corner_vertex) if corners is None else corners) // 4, level, steps,
                                      most_vertices)
        return affordable, [] if affordable == level else [
            f"{self.name}: finer folds are asked for than {most_vertices:,} vertices allow: {RAISE_MOST}"]

    def diagonal(self) -> float:
        """Diagonal of the bounding box, object units. Rigid parts and loose vertices do not count."""
        counts = np.zeros(len(self.positions), bool)
        counts[self.corner_vertex] = True
        if self.rigid is not None:
            counts[self.rigid.vertex] = False
        return float(np.linalg.norm(np.ptp(self.positions[counts], axis=0))) if counts.any() else 0.0


def affordable_level(vertices: int, level: int, steps: int, most_vertices: int) -> int:
    """The number of subdivisions, at most `level`, that makes no more than most_vertices of `vertices`. steps: further
    subdivisions that only the display adds."""
    while level > 0 and vertices * 4**(level + steps) > most_vertices:
        level -= 1
    return level
