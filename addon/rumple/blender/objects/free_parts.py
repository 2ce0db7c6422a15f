# SPDX-License-Identifier: GPL-3.0-or-later
"""Which parts of a garment hang free of the body, for the first click: the skirt of a dress, a wide sleeve, a coat
below the waist. They are painted, so that the artist sees and changes them."""
from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core import hangs_free, transforms
from ...core.cloth import size_factor
from ...core.triangles import at_border
from ...core.vertices import places
from .. import compat
from . import bodies, body_search, cloth_defaults, incoming_mesh, mesh_reader, painted_maps, properties, rig_scale

FARTHEST = 0.3  # metres, of a garment that an adult wears: what is farther does not tell
UNDER = 0.5  # cosine between the inner side of the cloth and the way to the body, at least: it lies below, not beside
SAMPLES = 400  # vertices at most that tell whether to look at all of them


class _Surface(NamedTuple):
    """Of a body or a garment, at rest."""

    tree: BVHTree
    ends: np.ndarray  # (t,) bool: the triangle is at a border; bodies are mostly deleted under clothes

    @classmethod
    def of(cls, obj: bpy.types.Object, tree: BVHTree | None) -> "_Surface":
        """tree: of tree_of(), where there is one already."""
        return cls(tree or body_search.tree_of(obj), at_border(body_search.triangles_of(obj)))


def give_room(obj: bpy.types.Object, scene: bpy.types.Scene, trees: dict[bpy.types.Object, BVHTree], sheet: bool,
              is_set: bool) -> None:
    """To what hangs free of the body; to all of a skirt or a cape where it is not known what is below it, unless the
    artist has set its room. trees, sheet: as of paint()."""
    settings = properties.group_of(obj)
    if settings.base_cloth == "OFF":
        return
    if not paint(obj, scene, trees, sheet) and not is_set and (sheet or cloth_defaults.is_skirt(obj)):
        settings.room = settings.free_room


def paint(obj: bpy.types.Object, scene: bpy.types.Scene, trees: dict[bpy.types.Object, BVHTree],
          sheet: bool) -> bool:
    """Paint Hangs Free where the cloth of an object is away from all that it is worn over; on a sheet, as a cape is,
    below its upper end. What was painted stays; where next to nothing hangs free, or everything has the room of it,
    nothing is painted. True where the map is there then. trees: of tree_of(), of what has one already. Cost: 10 ms per
    1,000 vertices and body; of most garments 10 ms."""
    painted, settings = painted_maps.find(obj, hangs_free.FREE), properties.group_of(obj)
    if painted is None or painted.exists:
        return painted is not None
    if settings.room >= settings.free_room:
        return False
    if not compat.is_editable(obj) or not compat.is_editable(obj.data):
        return False
    rest = transforms.placed(np.array(obj.matrix_world, np.float32), mesh_reader.basis_positions(obj.data))
    if not np.isfinite(rest).all():
        return False
    free = hangs_free.share_of_sheet(rest) if sheet else _free_of_bodies(obj, rest, scene, trees)
    if free is None or (free[_cloth_vertices(obj)] > 0.5).mean() < hangs_free.LEAST_FREE:
        return False
    painted_maps.write(obj, painted, cloth_defaults.in_steps(free), masked=False)
    return True


def _free_of_bodies(obj: bpy.types.Object, rest: np.ndarray, scene: bpy.types.Scene,
                    trees: dict[bpy.types.Object, BVHTree]) -> np.ndarray | None:
    found = [body for body in bodies.of(obj) if body != obj and body.type == "MESH" and len(body.data.polygons)]
    with incoming_mesh.whole(found):
        over = [_Surface.of(body, trees.get(body)) for body in found if body_search.is_finite(body)]
    metre = scene.unit_settings.scale_length * rig_scale.of(obj, scene)
    return _free_share(obj, rest, over, metre) if over else None


def _free_share(obj: bpy.types.Object, rest: np.ndarray, over: list[_Surface], metre: float) -> np.ndarray | None:
    """(n,) float32 of the object's own vertices; None where a sample says that it lies on what it is worn over. rest:
    (n, 3) in the world. metre: metres of a unit of the world."""
    turn = obj.matrix_world.to_3x3().inverted_safe().transposed()
    size = size_factor(Vector(np.ptp(rest, axis=0)).length, metre)

    def share(of: np.ndarray, side: float) -> np.ndarray:
        places, vertices = [Vector(place) for place in rest[of].tolist()], obj.data.vertices
        normals = [side * (turn @ vertices[i].normal).normalized() for i in of.tolist()]
        distance = _distances(places, normals, over, FARTHEST * size / metre)
        return hangs_free.share_of_distance(metre * distance, size)

    outer = _cloth_vertices(obj)
    sample = outer[::max(len(outer) // SAMPLES, 1)]
    # Which side is the outer one is looked up for those that need it.
    if not any((share(sample, side) > 0.5).mean() >= hangs_free.LEAST_FREE for side in (1.0, -1.0)):
        return None
    return hangs_free.spread(share(np.arange(len(rest)), body_search.side_of(obj)), compat.edge_vertices(obj.data),
                             places(rest))


def _cloth_vertices(obj: bpy.types.Object) -> np.ndarray:
    """Ascending: those of the object's own vertices that tell; the inner side of thick cloth has no body below it. A
    Mirror or Solidify modifier adds its vertices behind them, and these may be all of the outer side."""
    own = np.arange(len(obj.data.vertices))
    outer = np.intersect1d(own, body_search.triangles_of(obj))
    return outer if len(outer) else own


def _distances(places: list[Vector], normals: list[Vector], over: list[_Surface], farthest: float) -> np.ndarray:
    """(n,) world units to the nearest surface below the cloth; NaN where none is within reach, or where it ends."""
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
