# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where other objects hold a garment, for the first click: hems that are tucked into other clothes (a shirt in
trousers, a leg in a boot), and cuts (cuts.py). They are painted as pinned, so that the artist can see and change them.
Without this, such a hem leaves the waistband when an arm rises. If the body was deleted under the clothes, there is
then a gap between both."""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.base import transforms
from ...core.base.triangles import vertex_normals
from ...core.base.vertices import places
from ...core.base.wording import UserError
from ...core.cloth import tucked
from ...core.cloth.base_cloth import suggested_follow
from ...core.mesh.base_mesh import BaseMesh
from ...core.mesh.connected import borders
from ...core.mesh.figure_size import size_factor
from ...core.parts.cloth_surface import without_rigid_parts
from .. import compat
from ..objects import on_bone, painted_maps, properties, rig_scale
from . import body_search, cloth_defaults, cuts, figure

REACH = 0.02  # metres, of an adult's garment: largest distance of the clothes over a hem


def paint(obj: bpy.types.Object, scene: bpy.types.Scene, worn_over: body_search.WornOver, sheet: bool,
          made: bool) -> None:
    """Paint Pinned at tucked hems and at cuts, and elsewhere the weights that would be pinned without the map. Nothing
    is painted if all of these vertices are pinned without the map. Edges along cuts get a crease. An existing map is
    not changed, but one that this click has made is added to. Sheets and skirts are not tucked in. made: this click has
    made the map. Cost: 20 ms for 1,000 border vertices, and that of cuts.find()."""
    painted, settings = painted_maps.find(obj, "follow"), properties.group_of(obj)
    if painted is None or (painted.exists and not made) or not worn_over.trees or settings.base_cloth == "OFF":
        return
    if not compat.is_editable(obj) or not compat.is_editable(obj.data):
        return
    try:
        base = without_rigid_parts(cloth_defaults.cloth_at_rest(obj).healed(True), True, settings.rigid_parts)
        cut = cuts.find(obj, worn_over.trees)
        cuts.crease(obj, cut)
        hidden = np.intersect1d(np.flatnonzero(cut[base.own_origin().vertex]), base.corner_vertex)
        if not (sheet or cloth_defaults.is_skirt(obj)):
            hidden = np.union1d(hidden, _tucked(obj, base, worn_over.trees_over(), scene))
        follow = suggested_follow(base.surface(True), settings.up) if len(hidden) else np.zeros(0)
    except UserError:
        return  # the build reports this error
    if not (follow[hidden] < tucked.HELD).any():
        return  # a waistband under a shirt
    weights = tucked.held(follow, base.positions, hidden, base.diagonal())[:base.own_origin().vertex_count]
    weights = painted_maps.on_own_vertices(obj, painted_maps.in_steps(weights))
    if made:
        weights = np.maximum(weights, painted_maps.weights(obj, painted))
    painted_maps.write(obj, painted, weights, masked=False)


def _tucked(obj: bpy.types.Object, base: BaseMesh, trees: dict[bpy.types.Object, BVHTree],
            scene: bpy.types.Scene) -> np.ndarray:
    """The border vertices under other clothes. base: healed, so its normals point outwards."""
    world = np.array(on_bone.world_at_rest(obj), np.float32)
    rest = transforms.placed(world, base.positions)
    turn = np.array(on_bone.world_at_rest(obj).to_3x3().inverted_safe().transposed())
    normals = vertex_normals(base.positions, base.triangles) @ turn.T
    metre = scene.unit_settings.scale_length * rig_scale.of(obj, scene)
    reach = REACH * size_factor(Vector(np.ptp(rest, axis=0)).length, metre, figure.in_world(obj)) / metre
    found = [np.empty(0, np.int64)]
    for border in borders(base, places(base.positions)):
        under = np.array([_is_under(Vector(rest[v]), Vector(normals[v]).normalized(), trees, reach) for v in border])
        if under.mean() >= tucked.LEAST_SHARE:
            found.append(border[under])
    return np.concatenate(found)


def _is_under(place: Vector, normal: Vector, trees: dict[bpy.types.Object, BVHTree], reach: float) -> bool:
    """Whether another surface with the same orientation is outside of a place, within reach."""
    for tree in trees.values():
        nearest, facing, _, _ = tree.find_nearest(place, reach)
        if nearest is not None and (nearest - place).dot(normal) > 0.0 and facing.dot(normal) > 0.0:
            return True
    return False
