# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds skin in an object of clothes by the names of its materials, for the first click: a character in one mesh."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.base.wording import UserError
from ...core.mesh.base_mesh import BaseMesh
from ...core.parts import skin_materials
from ..objects import incoming_mesh, mesh_reader


def materials(obj: bpy.types.Object) -> list[str]:
    """The names of its materials that name skin; empty if all of them do."""
    names = [slot.name for slot in obj.material_slots if slot.name]
    skin = [name for name in dict.fromkeys(names) if skin_materials.names_skin(name)]
    return skin if len(skin) < len(set(names)) else []


def faces(obj: bpy.types.Object, base: BaseMesh) -> np.ndarray | None:
    """(p,) bool of a base's polygons: skin beside cloth. None if there is none. base: of the object, as it was read or
    healed. Cost: 1 ms for 10,000 triangles; nothing if no material names skin."""
    named = materials(obj)
    if not named or not len(base.triangle_corner):
        return None
    slots = [number for number, slot in enumerate(obj.material_slots) if slot.name in named]
    skin = np.isin(_slots(obj, base), slots)
    return skin if skin_materials.is_beside_cloth(base, skin) else None


def is_dressed(obj: bpy.types.Object) -> bool:
    """Whether an object has both skin and cloth: a figure in its clothes, also where others are worn over it."""
    return faces(obj, mesh_reader.base_mesh(obj, "REST_POSE", "")) is not None


def materials_of(obj: bpy.types.Object, base: BaseMesh, polygons: np.ndarray) -> list[str]:
    """The names of the materials of some polygons of a base, each once. polygons: (p,) bool."""
    slots = np.unique(_slots(obj, base)[polygons]).tolist()
    return list(dict.fromkeys(obj.material_slots[number].name for number in slots))


def _slots(obj: bpy.types.Object, base: BaseMesh) -> np.ndarray:
    """(p,) int32: the material slots of a base's polygons."""
    return mesh_reader.material_slots(obj, incoming_mesh.of(obj))[base.own_origin().polygon]


def without(obj: bpy.types.Object, base: BaseMesh) -> BaseMesh:
    """A base without the polygons of faces(), healed. It is the same base if there are none, or if it has an error,
    which the build reports."""
    if not materials(obj):
        return base
    try:
        healed = base.healed(True)
    except UserError:
        return base
    found = faces(obj, healed)
    return base if found is None else healed.only(~found)
