# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender simulations that collide with a wrinkled garment: Cloth, Soft Body or particles.

Folds are written into a mesh at every frame. Blender takes this for an edit of the collision object, whether the folds
are solved or baked. It discards the cache behind the frame and restarts at the first frame. Only a baked cache stays.
Rigid bodies keep their cache.
"""
from __future__ import annotations

from collections.abc import Iterator

import bpy

from . import units


def notes(garment: bpy.types.Object) -> list[str]:
    """One sentence about the first simulation that loses its cache. Only reads."""
    if not _is_collider(garment):
        return []
    return [f"{garment.name}: \"{obj.name}\" collides with it, and loses its cache with every new fold: bake that "
            "cache before you render"
            for obj in units.scene_of(garment).objects if obj != garment
            for cache, colliders in _simulations(obj)
            if not cache.is_baked and (colliders is None or colliders.all_objects.get(garment.name) == garment)][:1]


def _is_collider(obj: bpy.types.Object) -> bool:
    return any(m.type == "COLLISION" and m.settings.use and (m.show_viewport or m.show_render) for m in obj.modifiers)


def _simulations(obj: bpy.types.Object) -> Iterator[tuple[bpy.types.PointCache, bpy.types.Collection | None]]:
    """Each cache, with its collision collection; None: the whole scene."""
    for m in obj.modifiers:
        if not (m.show_viewport or m.show_render):
            continue
        if m.type == "CLOTH" and m.collision_settings.use_collision:
            yield m.point_cache, m.collision_settings.collection
        elif m.type == "SOFT_BODY":
            yield m.point_cache, m.settings.collision_collection
        elif m.type == "PARTICLE_SYSTEM":
            particles = m.particle_system
            if particles.settings.type != "HAIR" or particles.use_hair_dynamics:
                yield particles.point_cache, particles.settings.collision_collection
