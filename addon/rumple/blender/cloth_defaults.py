# SPDX-License-Identifier: GPL-3.0-or-later
"""What the first click sets for a garment: that it becomes cloth, and where it is pinned."""
from __future__ import annotations

import bpy
import numpy as np

from ..core import wrinkle_mesh, wrinkle_paths
from . import mesh_io, properties, registry, structure

# Their result is cloth already: its small compressions are the simulation's own.
SIMULATED = frozenset(("CLOTH", "SOFT_BODY", "MESH_CACHE", "MESH_SEQUENCE_CACHE"))
STEPS = 20  # of the weights that a group starts from


def apply(obj: bpy.types.Object, scene: bpy.types.Scene, lengths: set[str]) -> None:
    """Make a skinned garment cloth, unless it was ever said what its wrinkles lie on. What else was set stays.

    lengths: names of those that nobody has set.
    """
    settings, method = properties.group_of(obj), obj.rumple.method
    choices = ("base_cloth", "layers") if method == "MESH" else ("base_cloth",)
    if any(settings.is_property_set(name) for name in choices) or not is_skinned(obj):
        return
    base = mesh_io.base_mesh(obj, "REST_POSE", "")
    if not len(base.triangle_corner) or not wrinkle_mesh.suits_cloth(base):
        return
    metres = structure.metres_per_unit(obj, scene)
    values = wrinkle_mesh.cloth_defaults(base, metres, np.array(obj.matrix_world.to_3x3(), np.float32))
    taken = {*choices, "up", *(lengths & {"room", "thickness"})}
    if method == "MESH" and settings.density != "LEVEL":  # the Wrinkle Field chooses its own by the mesh
        taken |= lengths & {"wavelength"}
    if method == "PATHS":
        values |= wrinkle_paths.cloth_defaults(base, metres)
        taken |= lengths & {"width"} | ({"threshold"} if not settings.is_property_set("threshold") else set())
    properties.apply_values(obj, scene, {name: value for name, value in values.items() if name in taken})


def is_skinned(obj: bpy.types.Object) -> bool:
    """Whether bones move it, and no simulation."""
    kinds = {m.type for m in obj.modifiers}
    keys = obj.data.shape_keys
    simulated = bool(kinds & SIMULATED) or (keys is not None and not keys.use_relative)
    return not simulated and ("ARMATURE" in kinds or (obj.parent is not None and obj.parent.type == "ARMATURE"
                                                      and obj.parent_type == "ARMATURE"))


def fill_follow(obj: bpy.types.Object, group: bpy.types.VertexGroup) -> None:
    """Start a new group from where the base cloth is pinned by itself."""
    fine = registry.runtime(obj).fine
    if fine is None:
        return
    settings = properties.settings_of(obj, structure.scene_of(obj))
    weights = np.round(fine.suggested_follow(settings) * STEPS) / STEPS
    for weight in np.unique(weights):
        group.add(np.flatnonzero(weights == weight).tolist(), float(weight), "REPLACE")
