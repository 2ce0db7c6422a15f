# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the cuts at which a figure was made into several objects, for the first click: a bodice and its skirt, a sleeve
and its arm, the faces of one material and those of the next. Vertices of both objects are at the same place there. As
two garments, each would sag and be rounded on its own, and the cut would open."""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.base.vertices import nearest_of
from .. import compat
from ..objects import incoming_mesh, mesh_reader
from . import body_search

SAME_PLACE = 1e-4  # largest distance / the garment's diagonal
LEAST = 6  # least number of such vertices of a cut
MOST = 0.5  # largest share of a garment's vertices: with more, the other object is a copy of it


def find(obj: bpy.types.Object, trees: dict[bpy.types.Object, BVHTree]) -> np.ndarray:
    """(n,) bool: the vertices of the incoming mesh along cuts. A copy of the garment, such as a level of detail, makes
    no cut. trees: from body_search.tree_of(), of the other objects. Cost: 2 ms for 1,000 vertices beside another
    object."""
    rest, found = body_search.rest_in_world(obj), np.zeros(len(incoming_mesh.of(obj).vertices), bool)
    used = np.unique(mesh_reader.base_mesh(obj, "REST_POSE", "").corner_vertex)
    near = SAME_PLACE * Vector(np.ptp(rest[used], axis=0)).length if len(used) else 0.0
    for other, tree in trees.items():
        theirs = body_search.rest_in_world(other)
        within = (rest[used] >= theirs.min(axis=0) - near) & (rest[used] <= theirs.max(axis=0) + near)
        on_it = np.array([vertex for vertex in used[within.all(axis=1)].tolist()
                          if tree.find_nearest(Vector(rest[vertex]), near)[0] is not None], np.int64)
        if len(on_it):
            on_it = on_it[nearest_of(rest[on_it], theirs, np.arange(len(theirs)))[1] <= near]
        if LEAST <= len(on_it) <= MOST * len(used):
            found[on_it] = True
    return found


def crease(obj: bpy.types.Object, cut: np.ndarray) -> None:
    """Give the object's own edges along cuts a crease of 1, so that the fine mesh goes through them. Where an end is
    closed, its rim would be rounded otherwise. cut: from find(). Nothing is done where a modifier in front makes
    points."""
    if cut.any() and incoming_mesh.is_own(obj):
        values = compat.edge_creases(obj.data)
        values[cut[compat.edge_vertices(obj.data)].all(axis=1)] = 1.0
        compat.set_edge_marks(obj.data, {"crease": values})
