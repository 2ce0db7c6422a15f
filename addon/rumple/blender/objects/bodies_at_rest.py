# SPDX-License-Identifier: GPL-3.0-or-later
"""The positions of bodies relative to their garment at rest. Parts that are far from the cloth at rest are not under
it, wherever the animation moves them. Only reads, so any handler may call it."""
from __future__ import annotations

import bpy
import numpy as np

from mathutils import Matrix

from ...core.base import transforms
from ...core.cloth import worn_at_rest
from ...core.mesh.body import Body, side
from .. import compat
from . import incoming_mesh, mesh_reader, rig_scale, units

Placing = tuple[tuple[float, ...], ...]  # 4x4 matrices, each row by row, applied one after the other
OTHER_SHAPES = ("FRAME", "SHAPE_KEY")  # rest shapes of a garment that differ from the armature's rest position
TRANSFORMS = ("location", "rotation", "scale", "delta_")  # prefixes of data paths


def placing(garment: bpy.types.Object, body: bpy.types.Object) -> Placing | None:
    """The transform from the object space of a body to that of a garment with the same armature. It is the same in all
    frames, even if common parents are animated. None if it is unknown: the armatures differ (props), or one of the two
    objects is animated itself. Cost: about 20 us."""
    if not armatures(garment) & armatures(body) or _rest_shape(garment) in OTHER_SHAPES:
        return None
    chains = [list(units.with_parents(obj)) for obj in (garment, body)]
    while all(chains) and chains[0][-1] == chains[1][-1]:
        for chain in chains:
            chain.pop()  # common parents
    if any(_moves(one) for chain in chains for one in chain):
        return None
    up, down = [_own(one) for one in chains[1]], [_own(one).inverted_safe() for one in reversed(chains[0])]
    return tuple(tuple(value for row in matrix for value in row) for matrix in (*up, *down))


def of(garment: bpy.types.Object, body: bpy.types.Object, posed: Body, found: Placing | None) -> np.ndarray | None:
    """(b, 3) float32, the vertices of a body at rest, object space of the garment. posed: the body in a frame. found:
    from placing(). NaN for vertices that cloth covers at rest, because any part of the cloth may come over them later:
    a thigh in a skirt. None if it is unknown: the mesh has other vertices, the body is a garment with folds, or it is
    mirrored."""
    if found is None:
        return None
    rest = mesh_reader.rest_positions(body, "REST_POSE", "")
    if len(rest) != len(posed.positions) or not np.isfinite(rest).all():
        return None
    scale = np.float32(rig_scale.of_rest(garment, "REST_POSE"))
    for matrix in found:
        rest = transforms.placed(np.array(matrix, np.float32).reshape(4, 4), rest)
    cloth = mesh_reader.rest_positions(garment, "REST_POSE", "")
    if side(rest, posed.triangles) < 0 or not worn_at_rest.is_worn(cloth, rest):
        return None
    size = worn_at_rest.size_of(cloth, rig_scale.metres_at_rest(garment, units.scene_of(garment)),
                                garment.rumple.figure)
    bare = ~worn_at_rest.is_covered(rest, posed.triangles, cloth, _normals(garment), size)
    return np.where(bare[:, None], scale * rest, np.float32(np.nan))


def _moves(obj: bpy.types.Object) -> bool:
    """Whether the object's transform relative to its parent may change between frames."""
    return (obj.parent_type not in ("OBJECT", "ARMATURE") or bool(obj.constraints)
            or any(path.startswith(TRANSFORMS) for path in compat.animated_paths(obj)))


def _own(obj: bpy.types.Object) -> Matrix:
    """The object's matrix in the space of its parent."""
    return obj.matrix_basis if obj.parent is None else obj.matrix_parent_inverse @ obj.matrix_basis


def armatures(obj: bpy.types.Object) -> set[bpy.types.Object]:
    """The armatures that an object follows, as its parent or by a modifier."""
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
