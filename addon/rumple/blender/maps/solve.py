# SPDX-License-Identifier: GPL-3.0-or-later
"""A frame of the Wrinkle Maps. The rules that keep Blender alive are those of frame/solve.py.

Nodes compute the masks (nodes/maps_mask_tree.py). The handler only sees to what they cannot: gain, strength, mute and
solo where they change, and weights, bones or poses that were edited.
"""
from __future__ import annotations

import bpy

from .. import compat, scheduler
from ..objects import mesh_reader, messages
from ..scheduler import LOCK
from . import hidden_meshes as maps_meshes, modifier as maps_modifier, rebuild, runtimes as maps_runtimes
from .runtimes import Runtime


def process(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Gain and strengths of what this depsgraph shows. Never raises."""
    if not scheduler.may_process(depsgraph):
        return
    with LOCK:
        objects = list(maps_modifier.mapped_objects())
        for obj, ours in objects:
            if compat.is_editable(obj) and not maps_runtimes.of(obj).stale and rebuild.is_behind_others(obj, ours):
                maps_runtimes.of(obj).stale = True
                scheduler.request()
        editable = [obj for obj, _ in objects if compat.is_editable(obj)]
        if scheduler.allowed_now() and any(maps_runtimes.of(obj).stale for obj in editable):
            rebuild.sync()
        for obj, ours in objects:
            _process_guarded(obj, ours, depsgraph)


def _process_guarded(obj: bpy.types.Object, ours: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph) -> None:
    entry = maps_runtimes.of(obj)
    with messages.frame_errors(obj, entry):
        _process(obj, ours, entry, depsgraph)
        messages.set_frame_error(entry, "")


def _process(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime, depsgraph: bpy.types.Depsgraph
             ) -> None:
    if entry.comparison is None or entry.refusal or obj.mode in mesh_reader.BUSY_MODES:
        return
    if len(obj.data.vertices) != entry.comparison.model.vertex_count:
        entry.stale = True
        scheduler.request()  # the topology was edited
        return
    skin = maps_modifier.skin(ours)
    if maps_meshes.made_from(skin, entry.shape):
        # The evaluated copy: animated settings are right there, in renders too.
        rebuild.write_gain(skin, entry, obj.evaluated_get(depsgraph).rumple_maps)
