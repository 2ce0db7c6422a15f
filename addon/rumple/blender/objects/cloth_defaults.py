# SPDX-License-Identifier: GPL-3.0-or-later
"""What the first click sets for a garment that is skinned or simulated, and where it is pinned."""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils.kdtree import KDTree

from ...core import flared, outer_side, transforms, wrinkle_field, wrinkle_mesh, wrinkle_paths
from ...core.base_mesh import BaseMesh
from .. import compat
from . import incoming_mesh, mesh_reader, modifier, properties, rig_scale, runtimes, units

# Their result is cloth already: its small compressions are the simulation's own.
SIMULATED = frozenset(("CLOTH", "SOFT_BODY", "MESH_CACHE", "MESH_SEQUENCE_CACHE"))
SIMULATED_DEFAULTS: dict[str, dict[str, Any]] = {
    "MESH": wrinkle_mesh.SIMULATED_DEFAULTS, "FIELD": wrinkle_field.SIMULATED_DEFAULTS}
CHOICES = ("base_cloth", "layers", "hem_rings", "up", "buckling_threshold", "threshold")  # what is no length
STEPS = 20  # of the weights that a group starts from


def apply(obj: bpy.types.Object, scene: bpy.types.Scene, lengths: set[str], sheet: bool) -> None:
    """Make a skinned garment cloth, and give a simulated one layers, unless it was ever said what its wrinkles lie
    on. What else was set stays.

    lengths: names of those that nobody has set. sheet: of is_sheet().
    """
    settings = properties.group_of(obj)
    if any(name in properties.fields_of(obj) and settings.is_property_set(name) for name in ("base_cloth", "layers")):
        return
    values = defaults(obj, scene, sheet)
    free = lengths - ({"wavelength"} if getattr(settings, "density", "") == "LEVEL" else set())
    properties.apply_values(obj, scene, {name: value for name, value in values.items() if name in free or (
        name in CHOICES and not settings.is_property_set(name))})


def defaults(obj: bpy.types.Object, scene: bpy.types.Scene, sheet: bool = False) -> dict[str, Any]:
    """Settings by what moves the object; none for what is neither skinned nor simulated."""
    method = obj.rumple.method
    if is_simulated(obj):
        return SIMULATED_DEFAULTS.get(method, {})
    if not is_skinned(obj):
        return {}
    base = cloth_at_rest(obj)
    if not len(base.triangle_corner):
        return {}
    if not sheet and not wrinkle_mesh.suits_cloth(base):
        return {}
    metres = rig_scale.metres_at_rest(obj, scene)
    values = wrinkle_mesh.cloth_defaults(base, metres, _turn(obj), sheet)
    if method == "MESH":
        return values
    of_folds = wrinkle_paths.cloth_defaults(base, metres) if method == "PATHS" else wrinkle_field.CLOTH_DEFAULTS
    of_cloth = ("base_cloth", "up", "room", "slide_room", "free_room", "thickness")
    return {name: values[name] for name in of_cloth} | of_folds


def is_sheet(obj: bpy.types.Object, body: bpy.types.Object | None) -> bool:
    """Whether a garment is one, as a cape. body: that it is worn over."""
    if body is None or not len(body.data.vertices):
        return False
    into = np.array(obj.matrix_world.inverted_safe() @ body.matrix_world, np.float32)
    wearer = transforms.placed(into, mesh_reader.rest_positions(body, "REST_POSE", ""))
    return flared.is_sheet(cloth_at_rest(obj), wearer)


def is_skirt(obj: bpy.types.Object) -> bool:
    """Whether it has two openings, and the lower one is far wider."""
    return flared.is_flared(cloth_at_rest(obj), _turn(obj)[2])


def has_inner_side(obj: bpy.types.Object) -> bool:
    """Whether it has a modelled thickness."""
    base = mesh_reader.base_mesh(obj, "REST_POSE", "")
    return outer_side.without_inner_side(base) is not base


def cloth_at_rest(obj: bpy.types.Object) -> BaseMesh:
    """Of a Wrinkle Mesh without an inner side; the other systems are solved on the mesh as it is."""
    base = mesh_reader.base_mesh(obj, "REST_POSE", "")
    return outer_side.without_inner_side(base) if obj.rumple.method == "MESH" else base


def _turn(obj: bpy.types.Object) -> np.ndarray:
    return np.array(obj.matrix_world.to_3x3(), np.float32)


def is_cloth(obj: bpy.types.Object) -> bool:
    """Whether it is worn over something: a base cloth is on, or it is simulated. Skin and heads are not."""
    return properties.group_of(obj).base_cloth != "OFF" or is_simulated(obj)


def is_simulated(obj: bpy.types.Object) -> bool:
    keys = obj.data.shape_keys
    return (keys is not None and not keys.use_relative) or any(
        m.type in SIMULATED or modifier.is_simulation_nodes(m) for m in obj.modifiers)


def is_skinned(obj: bpy.types.Object) -> bool:
    """Whether bones move it."""
    return any(m.type == "ARMATURE" and m.object is not None for m in obj.modifiers) or (
        obj.parent is not None and obj.parent.type == "ARMATURE" and obj.parent_type == "ARMATURE")


def _nearest(places: np.ndarray, to: np.ndarray) -> list[int]:
    """Of every row of `to` the nearest of the places."""
    tree = KDTree(len(places))
    for number, place in enumerate(places.tolist()):
        tree.insert(place, number)
    tree.balance()
    return [tree.find(place)[1] for place in to.tolist()]


def follow_weights(obj: bpy.types.Object) -> np.ndarray | None:
    """(n,) float32 of the object's own vertices: where the base cloth is pinned by itself. None before it is made."""
    fine = runtimes.of(obj).evaluator
    if fine is None:
        return None
    settings = properties.settings_of(obj, units.scene_of(obj))
    return on_own_vertices(obj, in_steps(fine.suggested_follow(settings)))


def in_steps(weights: np.ndarray) -> np.ndarray:
    """float32: so that a vertex group holds few values, and is written in little time."""
    return (np.round(weights * STEPS) / STEPS).astype(np.float32)


def on_own_vertices(obj: bpy.types.Object, weights: np.ndarray) -> np.ndarray:
    """Of what modifiers in front made, (m,), to the vertices that are painted, (n,)."""
    if incoming_mesh.is_own(obj):
        return weights
    return weights[_nearest(compat.positions(incoming_mesh.of(obj)), compat.positions(obj.data))]
