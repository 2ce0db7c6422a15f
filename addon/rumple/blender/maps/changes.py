# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks what of the Wrinkle Maps must be compared, written or made anew after a change."""
from __future__ import annotations

import bpy

from .. import compat, scheduler
from ..nodes import maps_shader
from ..scheduler import LOCK
from . import modifier as maps_modifier, rig as maps_rig, runtimes as maps_runtimes


_last_frame: tuple[str, float] | None = None  # that note_updates() has seen


def rig_changed(obj: bpy.types.Object) -> None:
    """Poses, bones or weights are others: compare anew after a moment without another change."""
    if maps_modifier.find(obj) is not None:
        maps_runtimes.of(obj).stale = True
        scheduler.request(scheduler.DELAY)
        obj.update_tag()


def maps_changed(obj: bpy.types.Object) -> None:
    """The images are others, or how they are blended: the shader's nodes are made anew."""
    group = obj.rumple_maps.group
    if group is not None and compat.is_editable(group):
        maps_shader.fill(group, maps_rig.usable_images(obj), obj.rumple_maps.maps, obj.rumple_maps.uv_map)
    rig_changed(obj)


def note_updates(depsgraph: bpy.types.Depsgraph) -> None:
    """Edited meshes, painted weights, edited shape keys and edited armatures are read again."""
    global _last_frame
    if scheduler.rendering():
        return
    frame = depsgraph.scene.name, depsgraph.scene.frame_current_final
    steps, _last_frame = frame != _last_frame, frame
    touched = {compat.session_key(update.id.original) for update in depsgraph.updates
               if isinstance(update.id, (bpy.types.Mesh, bpy.types.Armature)) and update.is_updated_geometry}
    if not touched:
        return
    with LOCK:
        for obj, _ours in maps_modifier.mapped_objects():
            armature = obj.find_armature()
            if {compat.session_key(data) for data in (obj.data, armature and armature.data) if data} & touched:
                runtime = maps_runtimes.of(obj)
                if steps and _has_animated_keys(obj):
                    runtime.unsure = True
                else:
                    runtime.stale = True
                scheduler.request(scheduler.DELAY)


def _has_animated_keys(obj: bpy.types.Object) -> bool:
    """Every frame then changes the mesh, as an edit does."""
    keys = obj.data.shape_keys
    return keys is not None and keys.animation_data is not None
