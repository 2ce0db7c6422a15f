# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the parts of a garment that hang free of the body, for the first click: the skirt of a dress, a wide sleeve, a
coat below the waist. These parts are painted, so that the artist can see and change them."""
from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.base import transforms
from ...core.base.triangles import at_border
from ...core.base.vertices import places
from ...core.mesh.figure_size import size_factor
from ...core.paint import hangs_free
from .. import compat
from ..objects import bodies, incoming_mesh, mesh_reader, on_bone, painted_maps, properties, rig_scale
from . import body_search, cloth_defaults, figure

FARTHEST = 0.3  # metres, of an adult's garment: surfaces farther away are ignored
UNDER = 0.5  # least cosine of the angle between inward normal and body: the body is below the cloth, not beside it
SAMPLES = 400  # largest number of vertices in the first test


class _Surface(NamedTuple):
    """The surface of a body or a garment at rest."""

    tree: BVHTree
    ends: np.ndarray  # (t,) bool: the triangle is at a border; bodies are often deleted under clothes

    @classmethod
    def of(cls, obj: bpy.types.Object, tree: BVHTree | None) -> "_Surface":
        """tree: from tree_of(), if it already exists."""
        return cls(tree or body_search.tree_of(obj), at_border(body_search.triangles_of(obj)))


def give_room(obj: bpy.types.Object, scene: bpy.types.Scene, trees: dict[bpy.types.Object, BVHTree], sheet: bool,
              is_set: bool) -> None:
    """Give room to the parts that hang free of the body. If nothing is known about the surface below, give it to the
    whole of a skirt or a cape, unless the artist has set its room. trees, sheet: as in paint()."""
    settings = properties.group_of(obj)
    if settings.base_cloth == "OFF":
        return
    if not paint(obj, scene, trees, sheet) and not is_set and (sheet or cloth_defaults.is_skirt(obj)):
        settings.room = settings.free_room


def paint(obj: bpy.types.Object, scene: bpy.types.Scene, trees: dict[bpy.types.Object, BVHTree],
          sheet: bool) -> bool:
    """Paint Hangs Free where the cloth of an object is away from all that it is worn over; on a sheet (for example a
    cape), below its upper end. An existing map is not changed. Nothing is painted if almost nothing hangs free, or if
    the whole garment has at least the free room. Returns whether the map exists afterwards. trees: existing trees from
    tree_of(). Cost: 10 ms per 1,000 vertices and body; for most garments 10 ms."""
    painted, settings = painted_maps.find(obj, hangs_free.FREE), properties.group_of(obj)
    if painted is None or painted.exists:
        return painted is not None
    if settings.room >= settings.free_room:
        return False
    if not compat.is_editable(obj) or not compat.is_editable(obj.data):
        return False
    rest = transforms.placed(np.array(on_bone.world_at_rest(obj), np.float32), mesh_reader.basis_positions(obj.data))
    if not np.isfinite(rest).all():
        return False
    free = hangs_free.share_of_sheet(rest) if sheet else _free_of_bodies(obj, rest, scene, trees)
    if free is None or (free[_cloth_vertices(obj)] > 0.5).mean() < hangs_free.LEAST_FREE:
        return False
    painted_maps.write(obj, painted, painted_maps.in_steps(free), masked=False)
    return True


def _free_of_bodies(obj: bpy.types.Object, rest: np.ndarray, scene: bpy.types.Scene,
                    trees: dict[bpy.types.Object, BVHTree]) -> np.ndarray | None:
    found = [body for body in bodies.of(obj) if body != obj and body.type == "MESH" and len(body.data.polygons)]
    with incoming_mesh.whole(found):
        over = [_Surface.of(body, trees.get(body)) for body in found if body_search.is_finite(body)]
    metre = scene.unit_settings.scale_length * rig_scale.of(obj, scene)
    return _free_share(obj, rest, over, metre) if over else None


def _free_share(obj: bpy.types.Object, rest: np.ndarray, over: list[_Surface], metre: float) -> np.ndarray | None:
    """(n,) float32, per vertex of the object's own mesh; None if a sample shows that the garment is close to its
    bodies. rest: (n, 3) in world space. metre: metres per world unit."""
    turn = on_bone.world_at_rest(obj).to_3x3().inverted_safe().transposed()
    size = size_factor(Vector(np.ptp(rest, axis=0)).length, metre, figure.in_world(obj))

    def share(of: np.ndarray, side: float) -> np.ndarray:
        places, vertices = [Vector(place) for place in rest[of].tolist()], obj.data.vertices
        normals = [side * (turn @ vertices[i].normal).normalized() for i in of.tolist()]
        distance = _distances(places, normals, over, FARTHEST * size / metre)
        return hangs_free.share_of_distance(metre * distance, size)

    outer = _cloth_vertices(obj)
    sample = outer[::max(len(outer) // SAMPLES, 1)]
    # Try both sides. The outer side is determined only for garments that pass this test.
    if not any((share(sample, side) > 0.5).mean() >= hangs_free.LEAST_FREE for side in (1.0, -1.0)):
        return None
    return hangs_free.spread(share(np.arange(len(rest)), body_search.side_of(obj)), compat.edge_vertices(obj.data),
                             places(rest))


def _cloth_vertices(obj: bpy.types.Object) -> np.ndarray:
    """The object's own vertices that are tested, ascending. The inner side of thick cloth is left out, because it has
    no body below it. If a Mirror or Solidify modifier has made the whole outer side, all own vertices are used."""
    own = np.arange(len(obj.data.vertices))
    outer = np.intersect1d(own, body_search.triangles_of(obj))
    return outer if len(outer) else own


def _distances(places: list[Vector], normals: list[Vector], over: list[_Surface], farthest: float) -> np.ndarray:
    """(n,) distances in world units to the nearest surface below the cloth. NaN if there is none within reach, or if
    the nearest point is at a border."""
    found = np.full(len(places), np.nan)
    for number, (place, normal) in enumerate(zip(places, normals)):
        near = farthest
        for surface in over:
            nearest, _, triangle, distance = surface.tree.find_nearest(place, near)
            if nearest is None:
                continue
            near = distance
            below = (place - nearest).dot(normal) >= UNDER * distance
            found[number] = distance if below and not surface.ends[triangle] else np.nan
    return found
