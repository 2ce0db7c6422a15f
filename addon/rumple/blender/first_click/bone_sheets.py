# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds sheets that a bone moves as a whole, for the first click: capes, banners and flaps of game characters, which
have no Armature modifier. Helmets, swords, shields and books have the same parent, but are no open sheets."""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.base import transforms
from ...core.base.vertices import lengths, nearest_of, places, sample_of
from ...core.base.wording import UserError
from ...core.cloth import tucked
from ...core.cloth.base_cloth import suggested_follow
from ...core.mesh.base_mesh import BaseMesh
from ...core.mesh.connected import borders
from ...core.paint import hangs_free
from ...core.parts import flared
from ...core.parts.cloth_surface import without_rigid_parts
from .. import compat
from ..objects import bodies, modifier, on_bone, painted_maps, properties
from . import body_search, cloth_defaults

TOUCHES = 0.02  # largest distance / the sheet's diagonal of what holds it, such as the pole of a flag
FEWEST, MOST = 3, 0.5  # least number of vertices, and largest share of a border, that touch what holds it
AT_HEAD = 0.06  # distance / the diagonal beyond the vertex that is nearest to the bone's head; as of a cape's upper end


def is_one(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether an object is such a sheet: open, and large beside the figure. If it is all that the armature moves, its
    size is unknown, and it counts as large."""
    if on_bone.bone_of(obj) is None or not body_search.is_finite(obj):
        return False
    into = np.array(on_bone.world_at_rest(obj).inverted_safe(), np.float32)
    figure = [transforms.placed(into, body_search.rest_in_world(other)) for other in body_search.candidates(obj, scene)
              if on_bone.bone_of(other) is None and body_search.is_finite(other)]
    return flared.is_sheet(cloth_defaults.cloth_at_rest(obj), np.concatenate([*figure, np.zeros((1, 3), np.float32)]))


def beside(obj: bpy.types.Object, worn_over: body_search.WornOver) -> list[bpy.types.Object]:
    """The skinned objects near a sheet at rest. All of them are bodies: legs of an object of their own are hardly under
    a cape at rest, and kick it when they run. worn_over: from body_search.find()."""
    low, high = _box(obj)
    near = body_search.NEAR * float(lengths((high - low)[None])[0])
    found = []
    for other in worn_over.trees:
        other_low, other_high = _box(other)
        if (on_bone.bone_of(other) is None and modifier.find(other) is None
                and (other_low <= high + near).all() and (other_high >= low - near).all()):
            found.append(other)
    return found


def _box(obj: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    rest = body_search.rest_in_world(obj)
    return rest.min(axis=0), rest.max(axis=0)


def hold(obj: bpy.types.Object, scene: bpy.types.Scene) -> str:
    """Paint where a sheet is held, unless that is its upper end, which is held without paint, or the map exists.
    Returns the message about it.

    It is held where it touches another object on the same bone, such as a pole; otherwise by its upper end; and if it
    lies flat, beside the head of its bone.
    """
    painted, settings, bone = painted_maps.find(obj, "follow"), properties.group_of(obj), on_bone.bone_of(obj)
    if painted is None or painted.exists or bone is None or settings.base_cloth == "OFF":
        return ""
    try:
        base = without_rigid_parts(cloth_defaults.cloth_at_rest(obj).healed(True), True, settings.rigid_parts)
        follow = suggested_follow(base.surface(True), settings.up)
    except UserError:
        return ""  # the build reports this error
    holder, held = _touching(obj, scene, base)
    if holder is None and follow.max(initial=0.0) >= tucked.HELD:
        return (f"{obj.name}: it is a sheet that the bone {bone.name} moves, so it is cloth that is held by its upper "
                "end. To change that, paint Pinned; if it is not cloth, set Base Cloth to Off")
    _paint(obj, base, held if holder is not None else _beside_head(obj, bone, base))
    if holder is None:
        return (f"{obj.name}: it is a sheet that the bone {bone.name} moves, so it is cloth that is held beside the "
                "head of this bone. To change that, paint Pinned; if it is not cloth, set Base Cloth to Off")
    return (f"{obj.name}: it is a sheet that the bone {bone.name} moves, so it is cloth that is held where it touches "
            f"{holder}. To change that, paint Pinned; if it is not cloth, set Base Cloth to Off")


def _paint(obj: bpy.types.Object, base: BaseMesh, held: np.ndarray) -> None:
    """Paint Pinned at these vertices of a border, and Hangs Free away from them. What would be held at the upper end is
    free."""
    if not len(held) or not compat.is_editable(obj) or not compat.is_editable(obj.data):
        return
    distance = nearest_of(base.positions, base.positions, sample_of(held, tucked.MOST))[1]
    firmly = tucked.held(np.zeros(len(distance)), base.positions, held, base.diagonal())
    for key, weights in (("follow", firmly), (hangs_free.FREE, hangs_free.share_beyond(distance, base.diagonal()))):
        painted = painted_maps.find(obj, key)
        if painted is not None and not painted.exists:
            own = painted_maps.in_steps(weights[:base.own_origin().vertex_count])
            painted_maps.write(obj, painted, painted_maps.on_own_vertices(obj, own), masked=False)


def _touching(obj: bpy.types.Object, scene: bpy.types.Scene, base: BaseMesh) -> tuple[str | None, np.ndarray]:
    """The other object on the same bone that a part of the border touches, and the vertices there."""
    bone, own = on_bone.bone_of(obj), on_bone.world_at_rest(obj)
    around = borders(base, places(base.positions))
    for other in scene.objects:
        if other == obj or other.type != "MESH" or on_bone.bone_of(other) != bone or not bodies.can_be_body(other):
            continue
        into = np.array(own.inverted_safe() @ on_bone.world_at_rest(other), np.float32)
        rest = transforms.placed(into, compat.positions(other.data))
        tree = BVHTree.FromPolygons(rest.tolist(), [tuple(polygon.vertices) for polygon in other.data.polygons])
        near = TOUCHES * base.diagonal()
        for border in around:
            on_it = np.array([tree.find_nearest(Vector(place), near)[0] is not None
                              for place in base.positions[border].tolist()], bool)
            if FEWEST <= on_it.sum() <= MOST * len(border):
                return other.name, border[on_it]
    return None, np.empty(0, np.int64)


def _beside_head(obj: bpy.types.Object, bone: bpy.types.Bone, base: BaseMesh) -> np.ndarray:
    """The vertices of the border that are nearest to the head of a bone."""
    head = on_bone.world_at_rest(obj).inverted_safe() @ (obj.parent.matrix_world @ bone.head_local)
    border = np.concatenate([np.empty(0, np.int64), *borders(base, places(base.positions))]).astype(np.int64)
    distance = lengths(base.positions[border] - np.array(head, np.float32))
    return border[distance <= distance.min(initial=0.0 if not len(border) else np.inf) + AT_HEAD * base.diagonal()]
