# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds garments in objects of their own whose ends are closed, for the first click."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.base import transforms
from ...core.mesh.base_mesh import BaseMesh
from ...core.parts.closed_garment import bends, is_closed_garment
from ..objects import bodies_at_rest, incoming_mesh, mesh_reader, on_bone
from . import body_search


def is_one(obj: bpy.types.Object, scene: bpy.types.Scene, base: BaseMesh, up: np.ndarray) -> bool:
    """Whether an object is such a garment. base: its mesh at rest, without skin. up: (3,) in its object space. Cost:
    that of is_closed_garment(), and 1 ms for 1,000 vertices of what has its shape."""
    own = on_bone.world_at_rest(obj).inverted_safe()
    others = [transforms.placed(np.array(own @ on_bone.world_at_rest(other), np.float32),
                                mesh_reader.rest_positions(other, "REST_POSE", ""))
              for other in body_search.candidates(obj, scene) if body_search.is_finite(other)]
    if not others or not is_closed_garment(base, np.concatenate(others), up):
        return False
    bones = {bone.name for rig in bodies_at_rest.armatures(obj) for bone in rig.data.bones}
    groups = [group.name for group in obj.vertex_groups if group.name in bones]
    return bends(mesh_reader.group_weights(obj, incoming_mesh.of(obj), groups))
