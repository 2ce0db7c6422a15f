# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks which parts of the Wrinkle Maps must be rebuilt after a change."""
from __future__ import annotations

import bpy

from .. import compat, scheduler
from ..scheduler import LOCK
from . import materials, modifier as maps_modifier, runtimes as maps_runtimes


_last_frame: tuple[str, float] | None = None  # that note_updates() has seen


def rig_changed(obj: bpy.types.Object) -> None:
    """Poses, bones or weights changed: rebuild the comparison after a moment without further changes."""
    if maps_modifier.find(obj) is not None:
        maps_runtimes.of(obj).stale = True
        scheduler.request(scheduler.DELAY)
        obj.update_tag()


def maps_changed(obj: bpy.types.Object) -> None:
    """The images or their blending changed: rebuild the shader's nodes."""
    materials.fill(obj)
    rig_changed(obj)


def note_updates(depsgraph: bpy.types.Depsgraph) -> None:
    """Mark objects whose mesh, weights, shape keys or armature were edited."""
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
    """Whether shape keys are animated. Then every frame changes the mesh, and looks like an edit."""
    keys = obj.data.shape_keys
    return keys is not None and keys.animation_data is not None
