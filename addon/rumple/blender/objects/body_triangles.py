# SPDX-License-Identifier: GPL-3.0-or-later
"""The triangles of a body, facing outwards. Only reads, so any handler may use it."""
from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np

from ...core.mesh.body import is_nearly_closed, side
from .. import compat

_SOME = 1_000  # triangles, see Triangulated


class Connections(NamedTuple):
    """The connectivity of a mesh."""

    counts: tuple[int, int, int]
    corners: np.ndarray

    @classmethod
    def of(cls, mesh: bpy.types.Mesh) -> "Connections":
        return cls((len(mesh.vertices), len(mesh.polygons), len(mesh.loops)), compat.corner_vertices(mesh))

    def same_as(self, other: "Connections") -> bool:
        return self.counts == other.counts and np.array_equal(self.corners, other.corners)


class Triangulated(NamedTuple):
    """The triangles of a body."""

    connections: Connections
    outwards: np.ndarray  # triangles that face outwards at rest
    some: np.ndarray  # about _SOME of these, from the whole mesh: enough to recognise a mirrored body
    mirrored: np.ndarray | None  # all, reversed; None if mirroring cannot be distinguished from bending

    @classmethod
    def of(cls, rest: bpy.types.Mesh, connections: Connections) -> "Triangulated":
        found, positions = compat.triangle_vertices(rest), compat.positions(rest)
        faced, may_turn = side(positions, found), is_nearly_closed(positions, found)
        turned = np.ascontiguousarray(found[:, ::-1])
        outwards, inwards = (turned, found) if faced < 0 else (found, turned)
        some = np.ascontiguousarray(outwards[::max(len(outwards) // _SOME, 1)])
        return cls(connections, outwards, some, inwards if faced and may_turn else None)

    def facing_outwards(self, positions: np.ndarray) -> np.ndarray:
        """The triangles that face outwards in a pose. Mostly a test of some of them suffices: a test of 28,000 takes 2
        ms."""
        if self.mirrored is None or side(positions, self.some) > 0 or side(positions, self.outwards) >= 0:
            return self.outwards
        return self.mirrored
