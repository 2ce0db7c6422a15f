# SPDX-License-Identifier: GPL-3.0-or-later
"""Which object a garment is worn over, for the first click: the innermost skinned mesh that lies under it at rest."""
from __future__ import annotations

import functools
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core import outer_side, transforms
from ...core.body import facing_outwards
from ...core.healing import TURNED
from ...core.triangles import area_vectors
from ...core.vertices import lengths, sample_of
from . import bodies, incoming_mesh, mesh_reader, modifier
from .bodies_at_rest import armatures

SAMPLES = 500  # vertices at most that are asked what lies under them
NEAR = 0.08  # of the diagonal of the bounding box: what is farther does not lie under the cloth
LEAST_SHARE = 0.15  # of the vertices that lie over another one: clothes over a body, and no body over clothes
LEAST_BODY = 0.05  # of the vertices that must have the body under them: mostly it is deleted there
LEAST_OVERLAP = 0.02  # of the vertices that lie over another garment: the hem of a shirt over trousers
MORE_OVER = 2.0  # times as much of a garment lies over another one as the other way round
WITHIN = 0.05  # of the diagonal: how far clothes reach beyond a body
LEAST_CLOTHED = 0.1  # of the area of a body: what clothes on it have, and a belt, a badge or a pocket on a skirt not
WORN_SHARE = 0.5  # from this share on a candidate is itself worn over another one: clothes, not a body


@dataclass
class _Cloth:
    """Some vertices of a mesh at rest, world space."""

    places: list[Vector]
    normals: list[Vector]
    reach: float  # how far what lies under it may be


@dataclass
class WornOver:
    """What an object is worn over, or that it is a body itself."""

    body: bpy.types.Object | None
    garments: list[bpy.types.Object]  # other clothes that it covers a part of
    clothes: list[bpy.types.Object]  # of a body: what lies over it, is no larger, and more than a trimming
    trees: dict[bpy.types.Object, BVHTree]  # of tree_of(), of what was looked at

    @property
    def is_body(self) -> bool:
        """Whether clothes lie over it, and it is not worn over anything that is no smaller."""
        return bool(self.clothes)

    def trees_over(self) -> dict[bpy.types.Object, BVHTree]:
        """Of what may lie over it."""
        return {other: tree for other, tree in self.trees.items() if other not in (self.body, *self.garments)}


def candidates(obj: bpy.types.Object, scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The meshes that share the armature of a garment."""
    rigs = armatures(obj)
    return [other for other in scene.objects if other != obj and rigs & armatures(other) and bodies.can_be_body(other)]


def find(obj: bpy.types.Object, scene: bpy.types.Scene) -> WornOver:
    """The object that shares the armature of a garment and lies under most of it, and the clothes that reach under it.
    Who lies over whom is not told by the shares alone: where a body was deleted under its clothes, as much of either
    lies over the other.

    Cost: a tree of each candidate, about 2 ms per 1000 polygons.
    """
    if not armatures(obj) or not is_finite(obj):
        return WornOver(None, [], [], {})
    trees = {other: tree_of(other) for other in candidates(obj, scene)
             if len(other.data.polygons) and is_finite(other)}
    cloth = functools.cache(_cloth)
    shares = {other: _share_over(cloth(obj), tree) for other, tree in trees.items()}
    # How much of another one lies over it.
    back = functools.cache(lambda other: _share_over(cloth(other), tree_of(obj, near=cloth(other))))
    trimmings = []
    if not any(_is_within(obj, other) for other, share in shares.items() if share > LEAST_SHARE):
        trimmings = [other for other in shares if _is_within(other, obj) and back(other) > LEAST_SHARE]
        if trimmings and sum(map(_area, trimmings)) >= LEAST_CLOTHED * _area(obj):
            return WornOver(None, [], trimmings, trees)
    under = [other for other, share in shares.items() if share > LEAST_BODY and other not in trimmings]
    worn = {other for other in under if _is_worn(cloth(other), [trees[body] for body in under if body != other])}
    body = max((other for other in under if other not in worn and modifier.find(other) is None), key=shares.get,
               default=None)
    garments = [other for other, share in shares.items() if other != body and share > LEAST_OVERLAP
                and share > MORE_OVER * back(other)]
    return WornOver(body, garments, [], trees)


def _is_within(garment: bpy.types.Object, obj: bpy.types.Object) -> bool:
    """Whether the box around a garment reaches nowhere beyond that around an object."""
    (low, high), (own_low, own_high) = ((rest.min(axis=0), rest.max(axis=0)) for rest in map(_rest, (garment, obj)))
    spare = WITHIN * float(np.sqrt(((own_high - own_low) ** 2).sum()))
    return bool((low >= own_low - spare).all() and (high <= own_high + spare).all())


def _area(obj: bpy.types.Object) -> float:
    """At rest in world space; of clothes with a modelled thickness that of the outer side."""
    return float(lengths(area_vectors(_rest(obj), triangles_of(obj))).sum())


def _is_worn(cloth: _Cloth, others: list[BVHTree]) -> bool:
    return any(_share_over(cloth, other) > WORN_SHARE for other in others)


def _rest(obj: bpy.types.Object) -> np.ndarray:
    """Vertices at rest in world space, (n, 3) float32."""
    rest = mesh_reader.rest_positions(obj, "REST_POSE", "")
    return transforms.placed(np.array(obj.matrix_world, np.float32), rest)


def is_finite(obj: bpy.types.Object) -> bool:
    """Whether all its positions at rest are finite."""
    return bool(np.isfinite(_rest(obj)).all())


def _cloth(obj: bpy.types.Object) -> _Cloth:
    rest, vertices = _rest(obj), incoming_mesh.of(obj).vertices
    finite = np.flatnonzero(np.isfinite(rest).all(axis=1))
    outer = np.intersect1d(finite, triangles_of(obj))
    chosen = sample_of(outer, SAMPLES).tolist()
    turn = obj.matrix_world.to_3x3().inverted_safe().transposed() * side_of(obj)
    reach = NEAR * Vector(np.ptp(rest[finite], axis=0)).length if chosen else 0.0
    return _Cloth([Vector(rest[i]) for i in chosen], [turn @ vertices[i].normal for i in chosen], reach)


def side_of(obj: bpy.types.Object) -> float:
    """1, or -1 where most of the faces are turned when the mesh is healed: its normals point inwards."""
    base = mesh_reader.base_mesh(obj, "REST_POSE", "")
    turned = base.healed(weld=True).origin
    return -1.0 if turned is not None and 2 * len(turned.elements[TURNED]) > len(base.polygon_start) - 1 else 1.0


def tree_of(obj: bpy.types.Object, near: _Cloth | None = None) -> BVHTree:
    """The surface of an object at rest, world space, turned outwards; of the triangles of triangles_of(). near: only of
    those whose boxes are within its reach."""
    rest = _rest(obj)
    triangles = facing_outwards(rest, triangles_of(obj))
    if near is not None and near.places:
        low, high = (bound(np.array(near.places), axis=0) for bound in (np.min, np.max))
        corners = rest[triangles]
        triangles = triangles[((corners.max(axis=1) >= low - near.reach) & (corners.min(axis=1) <= high + near.reach)
                               ).all(axis=1)]
        used, numbers = np.unique(triangles, return_inverse=True)
        rest, triangles = rest[used], numbers.reshape(triangles.shape)
    return BVHTree.FromPolygons(rest.tolist(), triangles.tolist())


def triangles_of(obj: bpy.types.Object) -> np.ndarray:
    """(t, 3) vertices of an object's incoming mesh, without the inner side of clothes with a modelled thickness: what
    lies under that is not worn over them."""
    return outer_side.triangles_of(mesh_reader.base_mesh(obj, "REST_POSE", ""))


def _share_over(cloth: _Cloth, tree: BVHTree) -> float:
    """The share of the vertices whose nearest point on a surface is near, on the inner side of the cloth, and faces
    the same way: the inner side of a thick waistband does not lie over the shirt around it."""
    over = 0
    for place, normal in zip(cloth.places, cloth.normals):
        nearest, facing, _, _ = tree.find_nearest(place, cloth.reach)
        over += nearest is not None and (nearest - place).dot(normal) < 0.0 < facing.dot(normal)
    return over / max(len(cloth.places), 1)
