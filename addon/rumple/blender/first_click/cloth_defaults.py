# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings that the first click chooses for a skinned or simulated garment, and where such a garment is pinned."""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...core.base import transforms
from ...core.mesh import outer_side
from ...core.mesh.base_mesh import BaseMesh
from ...core.parts import flared
from ...core.systems import wrinkle_field, wrinkle_mesh, wrinkle_paths
from ..objects import mesh_reader, modifier, on_bone, properties, rig_scale
from . import closed_garments, named_skin

# Their result is already cloth: its small compressions come from the simulation.
SIMULATED = frozenset(("CLOTH", "SOFT_BODY", "MESH_CACHE", "MESH_SEQUENCE_CACHE"))
SIMULATED_DEFAULTS: dict[str, dict[str, Any]] = {
    "MESH": wrinkle_mesh.SIMULATED_DEFAULTS, "FIELD": wrinkle_field.SIMULATED_DEFAULTS}
CHOICES = ("base_cloth", "layers", "hem_rings", "up", "slack", "buckling_threshold", "threshold")  # not lengths


def apply(obj: bpy.types.Object, scene: bpy.types.Scene, lengths: set[str], sheet: bool, closed: bool,
          has_body: bool) -> None:
    """Make a skinned garment cloth, and give a simulated one layers, unless the artist has set one of the two. Other
    settings stay.

    lengths: names of the lengths that nobody has set. sheet, closed: from is_sheet() and is_closed(). has_body: whether
    a body is under most of it: then it is not cut wider than it is modelled.
    """
    settings = properties.group_of(obj)
    if any(name in properties.fields_of(obj) and settings.is_property_set(name) for name in ("base_cloth", "layers")):
        return
    values = defaults(obj, scene, sheet, closed)
    if has_body:
        values.pop("slack", None)  # a simulation of legs over a body is smooth too while the figure stands
    free = lengths - ({"wavelength"} if getattr(settings, "density", "") == "LEVEL" else set())
    properties.apply_values(obj, scene, {name: value for name, value in values.items() if name in free or (
        name in CHOICES and not settings.is_property_set(name))})


def defaults(obj: bpy.types.Object, scene: bpy.types.Scene, sheet: bool = False,
             closed: bool = False) -> dict[str, Any]:
    """Settings that depend on how the object moves; empty if it is neither skinned nor simulated. sheet, closed: from
    is_sheet() and is_closed()."""
    method = properties.system_of(obj).method
    if is_simulated(obj):
        return SIMULATED_DEFAULTS.get(method, {})
    if not (is_skinned(obj) or (sheet and on_bone.bone_of(obj) is not None)):
        return {}
    base = cloth_at_rest(obj)
    if not len(base.triangle_corner):
        return {}
    if not (sheet or closed or wrinkle_mesh.suits_cloth(base)):
        return {}
    metres = rig_scale.metres_at_rest(obj, scene)
    values = wrinkle_mesh.cloth_defaults(base, metres, _turn(obj), sheet)
    if method == "MESH":
        return values
    of_folds = wrinkle_paths.cloth_defaults(base, metres) if method == "PATHS" else wrinkle_field.CLOTH_DEFAULTS
    of_cloth = ("base_cloth", "up", "room", "slide_room", "free_room", "thickness")
    return {name: values[name] for name in of_cloth} | of_folds


def is_closed(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether an object is a garment without openings, because its ends are closed. With a body in it, it is not made
    cloth (set_up.py)."""
    base = cloth_at_rest(obj)
    return not wrinkle_mesh.suits_cloth(base) and closed_garments.is_one(obj, scene, base, _turn(obj)[2])


def is_sheet(obj: bpy.types.Object, body: bpy.types.Object | None) -> bool:
    """Whether a garment is a sheet, for example a cape. body: the object that it is worn over."""
    if body is None or not len(body.data.vertices):
        return False
    into = np.array(on_bone.world_at_rest(obj).inverted_safe() @ on_bone.world_at_rest(body), np.float32)
    wearer = transforms.placed(into, mesh_reader.rest_positions(body, "REST_POSE", ""))
    return flared.is_sheet(cloth_at_rest(obj), wearer)


def is_skirt(obj: bpy.types.Object) -> bool:
    """Whether a garment has two openings, and the lower one is far wider."""
    return flared.is_flared(cloth_at_rest(obj), _turn(obj)[2])


def cloth_at_rest(obj: bpy.types.Object) -> BaseMesh:
    """The mesh at rest without skin that its materials name, and without the inner side of a modelled thickness."""
    return outer_side.without_inner_side(named_skin.without(obj, mesh_reader.base_mesh(obj, "REST_POSE", "")))


def _turn(obj: bpy.types.Object) -> np.ndarray:
    return np.array(on_bone.world_at_rest(obj).to_3x3(), np.float32)


def is_cloth(obj: bpy.types.Object) -> bool:
    """Whether an object is cloth: it has a base cloth or is simulated. Skin and heads are not cloth."""
    return properties.group_of(obj).base_cloth != "OFF" or is_simulated(obj)


def is_simulated(obj: bpy.types.Object) -> bool:
    keys = obj.data.shape_keys
    return (keys is not None and not keys.use_relative) or any(
        m.type in SIMULATED or modifier.is_simulation_nodes(m) for m in obj.modifiers)


def is_skinned(obj: bpy.types.Object) -> bool:
    """Whether an object is moved by bones."""
    return any(m.type == "ARMATURE" and m.object is not None for m in obj.modifiers) or (
        obj.parent is not None and obj.parent.type == "ARMATURE" and obj.parent_type == "ARMATURE")
