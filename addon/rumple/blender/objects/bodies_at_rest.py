# SPDX-License-Identifier: GPL-3.0-or-later
"""Where bodies are while the garment over them is as at rest: what lies far from cloth there is not under it, wherever
the animation puts it. Only reads: allowed in any handler."""
from __future__ import annotations

import bpy
import numpy as np

from ...core import transforms, worn_at_rest
from ...core.body import Body, side
from . import incoming_mesh, mesh_reader, rig_scale, units

OTHER_SHAPES = ("FRAME", "SHAPE_KEY")  # of a garment at rest, which its armature has not in its rest position


def of(garment: bpy.types.Object, body: bpy.types.Object, posed: Body) -> np.ndarray | None:
    """(b, 3) float32, the vertices of a body that follows the armature of a garment, object space of the garment.
    posed: as it is in a frame. NaN where cloth covers it at rest: a thigh in a skirt may come under any of it. None
    where that is not known: of a prop, of a mesh with other vertices, of clothes with folds, of what is mirrored."""
    if not armatures(garment) & armatures(body) or _rest_shape(garment) in OTHER_SHAPES:
        return None
    rest = mesh_reader.rest_positions(body, "REST_POSE", "")
    if len(rest) != len(posed.positions) or not np.isfinite(rest).all():
        return None
    scale = np.float32(rig_scale.of_rest(garment, "REST_POSE"))
    into = np.array(garment.matrix_world.inverted_safe() @ body.matrix_world, np.float32)
    rest, cloth = transforms.placed(into, rest), mesh_reader.rest_positions(garment, "REST_POSE", "")
    if side(rest, posed.triangles) < 0 or not worn_at_rest.is_worn(cloth, rest):
        return None
    size = worn_at_rest.size_of(cloth, rig_scale.metres_at_rest(garment, units.scene_of(garment)))
    bare = ~worn_at_rest.is_covered(rest, posed.triangles, cloth, _normals(garment), size)
    return np.where(bare[:, None], scale * rest, np.float32(np.nan))


def armatures(obj: bpy.types.Object) -> set[bpy.types.Object]:
    """That an object follows, as parent or by a modifier."""
    if obj.type != "MESH":
        return set()
    found = {m.object for m in obj.modifiers if m.type == "ARMATURE"}
    return {rig for rig in (*found, obj.parent) if rig is not None and rig.type == "ARMATURE"}


def _normals(garment: bpy.types.Object) -> np.ndarray:
    vertices = incoming_mesh.of(garment).vertices
    flat = np.empty(3 * len(vertices), np.float32)
    vertices.foreach_get("normal", flat)
    return flat.reshape(-1, 3)


def _rest_shape(garment: bpy.types.Object) -> str:
    return getattr(getattr(garment.rumple, garment.rumple.method.lower(), None), "rest_shape", "")
