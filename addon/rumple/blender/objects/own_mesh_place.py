# SPDX-License-Identifier: GPL-3.0-or-later
"""The transform of an artist's own fine mesh relative to its garment. The mesh is bound at rest. An animation may move
only one of the two objects, so the result must not depend on the current frame. So the transform is stored until the
artist moves one of them."""
from __future__ import annotations

import json
from typing import Any

import bpy
from mathutils import Matrix

from .. import compat

KEY = "rumple_own_mesh_place"  # custom property of the garment
DIGITS = 6


def keep(obj: bpy.types.Object) -> None:
    """Store the transform in this frame, unless a valid one is stored. It writes, so do not call it in a handler."""
    own = obj.rumple.own_mesh
    if own is not None and compat.is_editable(obj) and _kept(obj, own) is None:
        rows = [list(row) for row in _now(obj, own)]
        obj[KEY] = json.dumps(dict(moved_by_hand=_moved_by_hand(obj, own), rows=rows))


def forget(obj: bpy.types.Object) -> None:
    """Called when an own mesh was chosen, perhaps the same one again."""
    obj.pop(KEY, None)


def of(obj: bpy.types.Object, own: bpy.types.Object) -> Matrix:
    """The transform from own to the object space of obj: 4 x 4."""
    kept = _kept(obj, own)
    return _now(obj, own) if kept is None else kept


def _now(obj: bpy.types.Object, own: bpy.types.Object) -> Matrix:
    return obj.matrix_world.inverted_safe() @ own.matrix_world


def _kept(obj: bpy.types.Object, own: bpy.types.Object) -> Matrix | None:
    try:
        kept = json.loads(obj[KEY])
        return Matrix(kept["rows"]) if kept["moved_by_hand"] == _moved_by_hand(obj, own) else None
    except (KeyError, TypeError, ValueError):
        return None


def _moved_by_hand(*objects: bpy.types.Object) -> list[Any]:
    """The transforms of objects and their parents that are not animated."""
    found: list[Any] = []
    for obj in objects:
        one: bpy.types.Object | None = obj
        while one is not None:
            found += [one.parent_type, one.parent_bone]
            if not _is_animated(one):
                found += [round(value, DIGITS) for matrix in (one.matrix_parent_inverse, one.matrix_basis)
                          for row in matrix for value in row]
            one = one.parent
    return found


def _is_animated(obj: bpy.types.Object) -> bool:
    about = obj.animation_data
    return bool(obj.constraints) or (about is not None and bool(about.action or about.drivers or about.nla_tracks))
