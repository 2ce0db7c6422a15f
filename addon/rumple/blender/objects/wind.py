# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Wind force fields, for cloth that swings. Only reads: allowed in any handler."""
from __future__ import annotations

import bpy
from mathutils import Matrix, Vector

from ...core.cloth_settings import ClothSettings
from ...core.surroundings import Surroundings, Wind, air_velocity


def surroundings(evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph, settings: ClothSettings) -> Surroundings:
    """Of a garment, as a depsgraph has it. settings: of its system."""
    if not settings.swings:
        return Surroundings()
    place = _three(evaluated.matrix_world.translation)
    return Surroundings(place, air_velocity(place, _winds(depsgraph) if settings.drag > 0.0 else ()))


def _winds(depsgraph: bpy.types.Depsgraph) -> list[Wind]:
    fields = ((obj.field, obj) for obj in depsgraph.objects)
    return [_wind(field, obj.matrix_world) for field, obj in fields if field is not None and field.type == "WIND"]


def _three(vector: Vector) -> tuple[float, float, float]:
    x, y, z = vector
    return x, y, z


def _wind(field: bpy.types.FieldSettings, world: Matrix) -> Wind:
    """It blows along the Z axis of its object."""
    return Wind(_three(world.translation), _three(world.to_3x3().col[2]), field.strength, field.falloff_power,
                field.distance_min if field.use_min_distance else None,
                field.distance_max if field.use_max_distance else None)
