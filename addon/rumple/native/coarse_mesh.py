# SPDX-License-Identifier: GPL-3.0-or-later
"""Coarse meshes in place of base meshes: native/include/rumple/surface.h."""
from __future__ import annotations

import numpy as np

from . import c
from .arrays import FLOAT, INT, address, given, new
from .handle import Array, Handle, Number
from .library import lib
from .surface import Surface


class CoarseMesh(Handle):
    """A coarse mesh in place of a base mesh. Made by build_coarse or as_modelled. m vertices."""

    __slots__ = ("surface", "spacing")
    POINTER, FREE = c.CoarsePointer, "rumple_coarse_free"
    VIEW, LOOK = c.CoarseView, "rumple_coarse_get_view"

    surface: Surface  # its polygons
    spacing: float | None  # as asked for; None: of as_modelled
    base_vertex = Array("(m,) int32: of every vertex the nearest vertex of the base mesh", INT, "vertex_count")
    mean_edge = Number("mean length of its edges, object units")

    def positions(self, positions: np.ndarray) -> np.ndarray:
        """(n, 3) float32 of the base mesh's vertices -> (m, 3), so that both smooth surfaces coincide. Raises
        ValueError."""
        place, count = given(positions, "positions", FLOAT, 3)
        out = new(FLOAT, self.view.vertex_count, 3)
        lib.rumple_coarse_positions(self, place, count, address(out), len(out))
        return out

    def paint(self, values: np.ndarray) -> np.ndarray:
        """Values painted on the base mesh, (n,) float32 -> (m,): interpolated linearly if the mesh is a subdivision,
        else those of the nearest vertices."""
        place, count = given(values, "values", FLOAT)
        out = new(FLOAT, self.view.vertex_count)
        lib.rumple_coarse_paint(self, place, count, address(out), len(out))
        return out


def build_coarse(base: Surface, spacing: float, part: Surface | None = None) -> CoarseMesh:
    """An even coarse mesh of triangles (Peyre and Cohen 2006). spacing: approximate mean edge length, object units.
    part: a surface with some polygons and all vertices of the base mesh, to represent only these; None: all. Raises
    ValueError if the mesh is too small for it."""
    coarse = CoarseMesh.made(lib.rumple_coarse_build_of, base, part or base, spacing)
    return _completed(coarse, spacing)


def as_modelled(base: Surface, least_edge: float, most_edge: float, part: Surface | None = None) -> CoarseMesh:
    """The mesh as it was modelled: quads that were cut into triangles are joined, and subdivisions taken back until the
    mean edge is at least least_edge and the mesh is not is_uneven() for this width. If it was modelled with longer
    edges, it is subdivided until the mean edge is at most most_edge, at least 2 x least_edge. Object units. part: as of
    build_coarse. Raises ValueError if there is no such mesh, or if it is the base itself."""
    coarse = CoarseMesh.made(lib.rumple_coarse_as_modelled, base, part or base, least_edge, most_edge)
    return _completed(coarse, None)


def _completed(coarse: CoarseMesh, spacing: float | None) -> CoarseMesh:
    coarse.spacing, coarse.surface = spacing, Surface.made(lib.rumple_coarse_surface, coarse)
    return coarse


__all__ = ["CoarseMesh", "as_modelled", "build_coarse"]
