# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Wind force fields, as cloth that swings meets them. Only reads: allowed in any handler.

Blender's Python tells no effector's force, so what it does is done here: the objects of the scene whose field is Wind
blow along their Z axis, as fast as their strength says in metres a second, less with the distance from the garment's
origin as their Falloff says. One velocity for the whole garment.
"""
from __future__ import annotations

import math

import bpy
from mathutils import Vector

from ..core.settings import ClothSettings
from ..core.surroundings import Surroundings


def surroundings(evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph, settings: ClothSettings) -> Surroundings:
    """Of a garment, as a depsgraph has it. settings: of its system."""
    if not getattr(settings, "swings", False):
        return Surroundings()
    blows = _velocity(evaluated, depsgraph) if settings.drag > 0.0 else Vector()
    return Surroundings(tuple(evaluated.matrix_world.translation), tuple(blows))


def _velocity(evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Vector:
    """m/s, world space."""
    total = Vector()
    for obj in depsgraph.objects:
        field = obj.field
        if field is None or field.type != "WIND":
            continue
        along = obj.matrix_world.to_3x3().col[2]
        if along.length > 0.0:
            apart = (evaluated.matrix_world.translation - obj.matrix_world.translation).length
            total += field.strength * _falloff(field, apart) * along.normalized()
    return total if all(map(math.isfinite, total)) else Vector()


def _falloff(field: bpy.types.FieldSettings, distance: float) -> float:
    """Share of the strength that is left, as Blender counts it for the shape Sphere."""
    if field.use_max_distance and distance > field.distance_max:
        return 0.0
    least = field.distance_min if field.use_min_distance else 0.0
    return (1.0 + max(distance - least, 0.0)) ** -field.falloff_power
