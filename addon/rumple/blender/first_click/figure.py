# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds how tall the wearer of a garment is, for the first click: all lengths of its cloth follow that. The result is
stored with the garment, so it is the same in every frame, on a farm, and when other objects change."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.mesh.figure_size import height_of
from ..objects import rig_scale
from ..objects.bodies_at_rest import armatures
from . import body_search

LEAST_BONES = 2  # a mesh that fewer bones move is a thing in a hand, or a sign beside the figure


def height(obj: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """The height of the figure of an object at rest, in units of the object; 0 if it is unknown. The figure is all
    meshes that share its armature and are moved by several bones, and the bones. Cost: 1 ms for 10,000 vertices."""
    rigs = armatures(obj)
    if not rigs or not len(obj.data.vertices) or not body_search.is_finite(obj):
        return 0.0
    others = [other for other in body_search.candidates(obj, scene)
              if _is_skinned(other, rigs) and body_search.is_finite(other)]
    boxes = np.array([(rest.min(axis=0), rest.max(axis=0))
                      for rest in map(body_search.rest_in_world, (obj, *others))], np.float64)
    names = {group.name for each in (obj, *others) for group in each.vertex_groups}
    bones = [(rig, bone) for rig in sorted(rigs, key=lambda rig: rig.name_full) for bone in rig.data.bones
             if _moves_meshes(bone, names)]
    number = {(rig, bone.name): index for index, (rig, bone) in enumerate(bones)}
    parents = np.array([next((number[rig, one.name] for one in bone.parent_recursive if (rig, one.name) in number), -1)
                        for rig, bone in bones], np.int64)
    heads = np.array([rig.matrix_world @ bone.head_local for rig, bone in bones], np.float64).reshape(-1, 3)
    metre = scene.unit_settings.scale_length * rig_scale.of(obj, scene)
    found = height_of(metre * boxes, metre * heads, parents)
    return found / metre / _scale(obj) if metre > 0.0 and _scale(obj) > 0.0 else 0.0


def in_world(obj: bpy.types.Object) -> float:
    """The stored height of the figure at rest, in world units; 0 if it is unknown."""
    return obj.rumple.figure * _scale(obj)


def _scale(obj: bpy.types.Object) -> float:
    return sum(map(abs, obj.matrix_world.to_scale())) / 3.0


def _is_skinned(obj: bpy.types.Object, rigs: set[bpy.types.Object]) -> bool:
    """Whether several bones move a mesh."""
    return len(obj.data.polygons) > 0 and sum(
        any(group.name in rig.data.bones for rig in rigs) for group in obj.vertex_groups) >= LEAST_BONES


def _moves_meshes(bone: bpy.types.Bone, names: set[str]) -> bool:
    """Whether a bone may be one of a body, and no control. names: of vertex groups. A garment alone often has groups
    only of the bones that move it. Then the legs are known by their chains: a target without a chain is none."""
    if not bone.use_deform:
        return False
    depth = len(bone.parent_recursive)
    return bone.name in names or depth > 1 or (depth == 1 and len(bone.children) > 0)
