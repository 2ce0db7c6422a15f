# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows the frame range of the scene: see units.first_frame() and the property bake_scene_range.

The scene's Start may be moved into the clip, to render a part again. So the range that the clip has is stored, and only
a range that begins after it is another clip.
"""
from __future__ import annotations

import bpy

from .. import compat
from . import units


def follow(obj: bpy.types.Object) -> None:
    """Store the clip's range. This is structural work, because it writes a property."""
    if is_outdated(obj):
        obj.rumple.bake_known_range = _now(obj)


def is_outdated(obj: bpy.types.Object) -> bool:
    """Whether follow() would change something."""
    about = obj.rumple
    return about.bake_scene_range and compat.is_editable(obj) and tuple(about.bake_known_range) != _now(obj)


def _now(obj: bpy.types.Object) -> tuple[int, int]:
    scene = units.scene_of(obj)
    first, last = obj.rumple.bake_known_range
    if scene.frame_start > last:
        return scene.frame_start, scene.frame_end
    return min(scene.frame_start, first), max(scene.frame_end, last)


def keep(obj: bpy.types.Object, scene: bpy.types.Scene, start: int, end: int) -> None:
    """Called after a bake of these frames: they stay its range when the scene's range changes. Not if only a part of
    the clip was baked, because the clip still begins before it."""
    about = obj.rumple
    if about.bake_scene_range and start <= units.first_frame(obj, scene):
        about.bake_start, about.bake_end = start, end


def edited(group: bpy.types.PropertyGroup, name: str) -> None:
    """Called when bake_start or bake_end was set: the range no longer follows the scene's."""
    if group.bake_scene_range:
        value = getattr(group, name)
        group.bake_scene_range = False
        setattr(group, name, value)


def switched(group: bpy.types.PropertyGroup) -> None:
    """Called when bake_scene_range was set. On: the clip begins anew with the range of the scene. Off: its own range
    begins as that of the scene."""
    scene = units.scene_of(group.id_data)
    now = scene.frame_start, scene.frame_end
    if group.bake_scene_range:
        group.bake_known_range = now
    else:
        group.bake_start, group.bake_end = now
