# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's force fields, for cloth that swings. Only reads, so any handler may call it."""
from __future__ import annotations

from typing import Iterator

import bpy
from mathutils import Matrix, Vector

from ...core.cloth.surroundings import Field, Surroundings, surroundings_of
from ...core.settings.cloth_settings import ClothSettings

KINDS = ("WIND", "FORCE", "VORTEX", "HARMONIC", "DRAG", "TURBULENCE")
SHAPES = ("POINT", "LINE", "PLANE")
SIDES = {"POSITIVE": "ABOVE", "NEGATIVE": "BELOW"}
# These affect only particles, hair and smoke, and not Blender's Cloth either.
OTHERS = ("BOID", "GUIDE", "CHARGE", "LENNARDJ")


def surroundings(evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph, settings: ClothSettings) -> Surroundings:
    """The surroundings of a garment in a depsgraph. settings: of its system."""
    if not settings.swings:
        return Surroundings()
    fields = [_field(obj.field, obj.matrix_world) for obj in _effectors(depsgraph)
              if obj.field.type in KINDS and obj.field.apply_to_location]
    return surroundings_of(_three(evaluated.matrix_world.translation), depsgraph.scene.frame_current, fields,
                           settings.drag, _not_felt(depsgraph))


def _not_felt(depsgraph: bpy.types.Depsgraph) -> tuple[str, ...]:
    """Names of objects with a force field that Blender's Cloth would react to, and ours does not."""
    return tuple(sorted({obj.name for obj in _effectors(depsgraph) if obj.field.type not in (*KINDS, *OTHERS)}))


def _effectors(depsgraph: bpy.types.Depsgraph) -> Iterator[bpy.types.Object]:
    return (obj for obj in depsgraph.objects if obj.field is not None and obj.field.type != "NONE")


def _three(vector: Vector) -> tuple[float, float, float]:
    x, y, z = vector
    return x, y, z


def _field(field: bpy.types.FieldSettings, world: Matrix) -> Field:
    """A force field for the core. If the distance is from a surface or from points, the object's origin is used
    instead. Blender's Linear Drag depends on the square of the velocity, and its Quadratic Drag on the velocity."""
    damping = {"HARMONIC": field.harmonic_damping, "DRAG": field.quadratic_drag}.get(field.type, 0.0)
    size = {"HARMONIC": field.rest_length, "TURBULENCE": field.size}.get(field.type, 0.0)
    return Field(
        field.type, _three(world.translation), _three(world.to_3x3().col[2]),
        field.linear_drag if field.type == "DRAG" else field.strength,
        field.shape if field.shape in SHAPES else "POINT", field.falloff_type, SIDES.get(field.z_direction, "BOTH"),
        damping, size, field.flow, field.noise, field.seed, field.falloff_power,
        field.distance_min if field.use_min_distance else 0.0,
        field.distance_max if field.use_max_distance else None, field.radial_falloff,
        field.radial_min if field.use_radial_min else 0.0, field.radial_max if field.use_radial_max else None,
        field.use_gravity_falloff and field.type == "FORCE", field.use_global_coords)
