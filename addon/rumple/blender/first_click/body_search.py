# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the object that a garment is worn over, for the first click: the innermost skinned mesh under it at rest."""
from __future__ import annotations

import functools
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.base import transforms
from ...core.base.triangles import area_vectors
from ...core.base.vertices import lengths, sample_of
from ...core.mesh import outer_side
from ...core.mesh.body import facing_outwards
from ...core.mesh.healing import TURNED
from ..objects import bodies, incoming_mesh, mesh_reader, modifier, on_bone
from ..objects.bodies_at_rest import armatures

SAMPLES = 500  # largest number of vertices that are tested
NEAR = 0.08  # / the diagonal of the bounding box: the largest distance of a surface under the cloth
SAME = 1e-3  # / the reach: a surface that near is no other one; where a figure was cut into objects, both sides meet
LEAST_SHARE = 0.15  # share of vertices over another object: clothes over a body exceed it, a body over clothes does not
LEAST_BODY = 0.05  # least share of vertices with the body under them; low, because bodies are often deleted there
LEAST_OVERLAP = 0.02  # least share of vertices over another garment: the hem of a shirt over trousers
MORE_OVER = 2.0  # this many times more of a garment is over another one than the other way round
WITHIN = 0.05  # / the diagonal: how far clothes extend beyond a body
LEAST_CLOTHED = 0.1  # / the area of a body: clothes exceed it; a belt, a badge or a pocket on a skirt does not
WORN_SHARE = 0.5  # a candidate with a larger share over another one is clothes, not a body


@dataclass
class _Cloth:
    """Some vertices of a mesh at rest, world space."""

    places: list[Vector]
    normals: list[Vector]
    reach: float  # largest distance of a surface under it


@dataclass
class WornOver:
    """The objects that an object is worn over, or the fact that it is a body itself."""

    body: bpy.types.Object | None
    garments: list[bpy.types.Object]  # other clothes that it partly covers
    clothes: list[bpy.types.Object]  # if it is a body: objects over it, not larger than it, and more than trimmings
    trees: dict[bpy.types.Object, BVHTree]  # from tree_of(), of the examined objects
    share: float = 0.0  # of its vertices, those over the body

    @property
    def is_body(self) -> bool:
        """Whether clothes are worn over it, and it is not worn over an object that is at least as large."""
        return bool(self.clothes)

    def trees_over(self) -> dict[bpy.types.Object, BVHTree]:
        """The trees of objects that may be worn over it."""
        return {other: tree for other, tree in self.trees.items() if other not in (self.body, *self.garments)}


def candidates(obj: bpy.types.Object, scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The meshes that share the armature of a garment."""
    rigs = armatures(obj)
    return [other for other in scene.objects if other != obj and rigs & armatures(other) and bodies.can_be_body(other)]


def find(obj: bpy.types.Object, scene: bpy.types.Scene) -> WornOver:
    """The object with the same armature that is under most of a garment, and the clothes that extend under it. The
    shares alone do not determine which object is the outer one: if a body was deleted under its clothes, both shares
    are alike.

    Cost: a tree of each candidate, about 2 ms per 1000 polygons.
    """
    if not armatures(obj) or not is_finite(obj):
        return WornOver(None, [], [], {})
    trees = {other: tree_of(other) for other in candidates(obj, scene)
             if len(other.data.polygons) and is_finite(other)}
    cloth = functools.cache(_cloth)
    shares = {other: _share_over(cloth(obj), tree) for other, tree in trees.items()}
    # The share of another object that is over this one.
    back = functools.cache(lambda other: _share_over(cloth(other), tree_of(obj, near=cloth(other))))
    trimmings = []
    if not any(_is_within(obj, other) for other, share in shares.items() if share > LEAST_SHARE):
        trimmings = [other for other in shares if _is_within(other, obj) and back(other) > LEAST_SHARE]
        if trimmings and sum(map(_area, trimmings)) >= LEAST_CLOTHED * _area(obj):
            return WornOver(None, [], trimmings, trees)
    # A thing in a hand or at a belt, such as a book that a garment lies beside, is no body in it.
    shares = {other: share for other, share in shares.items() if share > LEAST_SHARE or on_bone.bone_of(other) is None}
    under = [other for other, share in shares.items() if share > LEAST_BODY and other not in trimmings]
    worn = {other for other in under if _is_worn(cloth(other), [trees[body] for body in under if body != other])}
    body = max((other for other in under if other not in worn and modifier.find(other) is None), key=shares.get,
               default=None)
    garments = [other for other, share in shares.items() if other != body and share > LEAST_OVERLAP
                and share > MORE_OVER * back(other)]
    return WornOver(body, garments, [], trees, shares.get(body, 0.0))


def _is_within(garment: bpy.types.Object, obj: bpy.types.Object) -> bool:
    """Whether the bounding box of a garment extends hardly beyond that of an object."""
    (low, high), (own_low, own_high) = ((rest.min(axis=0), rest.max(axis=0))
                                        for rest in map(rest_in_world, (garment, obj)))
    spare = WITHIN * float(np.sqrt(((own_high - own_low) ** 2).sum()))
    return bool((low >= own_low - spare).all() and (high <= own_high + spare).all())


def _area(obj: bpy.types.Object) -> float:
    """Area at rest in world space. Of clothes with a modelled thickness, only the outer side counts."""
    return float(lengths(area_vectors(rest_in_world(obj), triangles_of(obj))).sum())


def _is_worn(cloth: _Cloth, others: list[BVHTree]) -> bool:
    return any(_share_over(cloth, other) > WORN_SHARE for other in others)


def rest_in_world(obj: bpy.types.Object) -> np.ndarray:
    """Vertices at rest in world space, (n, 3) float32."""
    rest = mesh_reader.rest_positions(obj, "REST_POSE", "")
    return transforms.placed(np.array(on_bone.world_at_rest(obj), np.float32), rest)


def is_finite(obj: bpy.types.Object) -> bool:
    """Whether all positions at rest are finite."""
    return bool(np.isfinite(rest_in_world(obj)).all())


def _cloth(obj: bpy.types.Object) -> _Cloth:
    rest, vertices = rest_in_world(obj), incoming_mesh.of(obj).vertices
    finite = np.flatnonzero(np.isfinite(rest).all(axis=1))
    outer = np.intersect1d(finite, triangles_of(obj))
    chosen = sample_of(outer, SAMPLES).tolist()
    turn = on_bone.world_at_rest(obj).to_3x3().inverted_safe().transposed() * side_of(obj)
    reach = NEAR * Vector(np.ptp(rest[finite], axis=0)).length if chosen else 0.0
    return _Cloth([Vector(rest[i]) for i in chosen], [turn @ vertices[i].normal for i in chosen], reach)


def side_of(obj: bpy.types.Object) -> float:
    """1, or -1 if healing the mesh turns most of its faces, because its normals point inwards."""
    base = mesh_reader.base_mesh(obj, "REST_POSE", "")
    turned = base.healed(weld=True).origin
    return -1.0 if turned is not None and 2 * len(turned.elements[TURNED]) > len(base.polygon_start) - 1 else 1.0


def tree_of(obj: bpy.types.Object, near: _Cloth | None = None) -> BVHTree:
    """The surface of an object at rest, world space, facing outwards, from the triangles of triangles_of(). near: use
    only triangles whose boxes are within its reach."""
    rest = rest_in_world(obj)
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
    """(t, 3) vertices of an object's incoming mesh. The inner side of clothes with a modelled thickness is left out,
    because a surface under the inner side is not worn over these clothes."""
    return outer_side.triangles_of(mesh_reader.base_mesh(obj, "REST_POSE", ""))


def _share_over(cloth: _Cloth, tree: BVHTree) -> float:
    """The share of the vertices whose nearest point on a surface is near, on the inner side of the cloth, and faces the
    same way. The direction is compared because the inner side of a thick waistband is not over the shirt around it."""
    over, same = 0, -SAME * cloth.reach
    for place, normal in zip(cloth.places, cloth.normals):
        nearest, facing, _, _ = tree.find_nearest(place, cloth.reach)
        over += nearest is not None and (nearest - place).dot(normal) < same and facing.dot(normal) > 0.0
    return over / max(len(cloth.places), 1)
