# SPDX-License-Identifier: GPL-3.0-or-later
"""A coarse mesh at rest, checked. Never imports bpy."""
from __future__ import annotations

import contextlib
import functools
import math
from dataclasses import dataclass, replace
from typing import Any, Callable, Iterator

import numpy as np

from ..native import kernels
from .digests import digest_of
from .healing import Origin, creases_of, origin_of, origin_of_itself
from .rigid_parts import RigidParts
from .wording import user_error

_built: dict[bytes, Any] | None = None  # of built_once(): what the library made of which arrays
MOST_LEVEL = 5  # subdivisions
RAISE_MOST = "raise Most Vertices"  # how the limit on a fine mesh is lifted


@contextlib.contextmanager
def built_once() -> Iterator[None]:
    """Within it equal arrays are healed once, and made a surface once. For the first click, which looks at a garment
    several times before its wrinkles are built. Holds all of them until its end."""
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
    origin: Origin | None = None  # of a healed mesh, or one without rigid parts: where its elements come from
    rigid: RigidParts | None = None  # that it is without
    painted_rigid: np.ndarray | None = None  # (n,) bool of the artist's vertices: of parts that are rigid by paint
    narrowest: float = 1.0  # the smallest factor on the width of folds that is painted, as narrowest_of() has it
    crease_edge: np.ndarray | None = None  # (k, 2) int32, vertices of edges that the fine mesh rounds less
    crease_sharpness: np.ndarray | None = None  # (k,) float32: for how many subdivisions; from 10 on for ever

    @functools.cached_property
    def triangles(self) -> np.ndarray:
        """(t, 3) int32, vertices. The same array every time."""
        return self.corner_vertex[self.triangle_corner]

    def healed(self, weld: bool) -> "BaseMesh":
        """This mesh, or where it is no oriented manifold a copy that is one. Raises UserError."""
        if self.origin is not None:
            return self
        healed = self._native(kernels.heal_mesh, weld)
        origin = origin_of(healed, self.polygon_start, self.corner_vertex, len(self.positions))
        if not origin.kinds():
            return self
        mesh = BaseMesh(self.name, np.ascontiguousarray(self.positions[origin.vertex]), healed.polygon_start,
                        healed.corner_vertex, healed.triangle_corner,
                        None if self.uv is None else np.ascontiguousarray(self.uv[origin.corner]), origin)
        mesh.painted_rigid, mesh.narrowest = self.painted_rigid, self.narrowest
        if self.crease_edge is not None and self.crease_sharpness is not None:
            mesh.crease_edge, mesh.crease_sharpness = creases_of(self.crease_edge, self.crease_sharpness, origin,
                                                                 mesh.sides())
        return mesh

    def own_origin(self) -> Origin:
        """Also of a mesh that is as the artist has it."""
        return self.origin or origin_of_itself(len(self.positions), len(self.polygon_start) - 1,
                                               len(self.corner_vertex))

    def surface(self, weld: bool) -> kernels.Surface:
        """The checked native surface. Raises UserError where the mesh is no oriented manifold."""
        return self._native(kernels.build_surface, weld, self.crease_edge, self.crease_sharpness)

    def points(self, values: np.ndarray) -> np.ndarray:
        """(n, ...) of the artist's vertices -> of this mesh's."""
        return values if self.origin is None else values[self.origin.vertex]

    def _native(self, build: Callable[..., Any], weld: bool, *more: np.ndarray | None) -> Any:
        arrays, built = (self.positions, self.polygon_start, self.corner_vertex, self.triangle_corner), _built
        key = b"" if built is None else digest_of(f"{build.__name__} {weld}".encode(), *arrays, *more)
        if built is not None and key in built:
            return built[key]
        try:
            made = build(*arrays, weld, *more)
        except ValueError as error:
            raise user_error(self.name, error) from error
        if built is not None:
            built[key] = made
        return made

    def only(self, kept: np.ndarray) -> "BaseMesh":
        """Some of its polygons, with all vertices. kept: (p,) bool. What lies on one that is left out goes with it."""
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
        """Of affordable_level(): as many subdivisions as are asked for, or fewer, and what to say then. corners: of the
        polygons that are subdivided; None: its own."""
        affordable = affordable_level((len(self.corner_vertex) if corners is None else corners) // 4, level, steps,
                                      most_vertices)
        return affordable, [] if affordable == level else [
            f"{self.name}: finer folds are asked for than {most_vertices:,} vertices allow: {RAISE_MOST}"]

    def diagonal(self) -> float:
        """Of the bounding box without rigid parts and loose vertices, object units."""
        counts = np.zeros(len(self.positions), bool)
        counts[self.corner_vertex] = True
        if self.rigid is not None:
            counts[self.rigid.vertex] = False
        return float(np.linalg.norm(np.ptp(self.positions[counts], axis=0))) if counts.any() else 0.0


def affordable_level(vertices: int, level: int, steps: int, most_vertices: int) -> int:
    """As many subdivisions of so many vertices as are asked for, or as make no more than most_vertices. steps: what is
    subdivided once more to be shown."""
    while level > 0 and vertices * 4**(level + steps) > most_vertices:
        level -= 1
    return level
