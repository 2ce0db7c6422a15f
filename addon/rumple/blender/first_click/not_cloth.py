# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds skinned objects with the shape of a garment that are none, for the first click: skin, hair and shoes by the
names of all of their materials, and small things that one bone moves, such as a lamp, a wristband or a part of a robot.
"""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from ...core.parts.closed_garment import LEAST_SIZE, bends
from ...core.parts.skin_materials import names_skin
from ..objects import bodies_at_rest, incoming_mesh, mesh_reader
from . import body_search


def is_skin(obj: bpy.types.Object) -> bool:
    """Whether all of an object's materials name skin, hair, shoes or metal."""
    names = [slot.name for slot in obj.material_slots if slot.name]
    return bool(names) and all(map(names_skin, names))


def is_rigid(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether an object is far smaller than its figure, and one bone moves it. The figure: all meshes of its armature.
    Cost: 1 ms for 1,000 vertices of a small object."""
    rest = [body_search.rest_in_world(each) for each in (obj, *body_search.candidates(obj, scene))
            if len(each.data.vertices) and body_search.is_finite(each)]
    if len(rest) < 2 or _diagonal(rest[0]) >= LEAST_SIZE * np.ptp(np.concatenate(rest)[:, 2]):
        return False
    bones = {bone.name for rig in bodies_at_rest.armatures(obj) for bone in rig.data.bones}
    weights = mesh_reader.group_weights(obj, incoming_mesh.of(obj), [
        group.name for group in obj.vertex_groups if group.name in bones])
    return bool(weights.size) and bool(weights.any()) and not bends(weights)


def _diagonal(points: np.ndarray) -> float:
    return float(Vector(np.ptp(points, axis=0)).length)
