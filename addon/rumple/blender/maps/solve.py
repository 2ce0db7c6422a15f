# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles a frame of the Wrinkle Maps. It follows the rules in frame/solve.py that prevent crashes of Blender.

Nodes compute the masks (nodes/maps_mask_tree.py). The handler only does what nodes cannot: it writes changed gain,
strength, mute and solo, and notices edited weights, bones or poses.
"""
from __future__ import annotations

import bpy

from .. import compat, scheduler
from ..objects import mesh_reader, messages
from ..scheduler import LOCK
from . import hidden_meshes as maps_meshes, modifier as maps_modifier, rebuild, runtimes as maps_runtimes
from .runtimes import Runtime


def process(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Write gain and strengths of the objects in this depsgraph. Never raises."""
    if not scheduler.may_process(depsgraph):
        return
    with LOCK:
        objects = list(maps_modifier.mapped_objects())
        for obj, nodes_mod in objects:
            with messages.frame_errors(obj, maps_runtimes.of(obj)):
                _note_others(obj, nodes_mod)
        editable = [obj for obj, _ in objects if compat.is_editable(obj)]
        if scheduler.allowed_now() and any(maps_runtimes.of(obj).stale for obj in editable):
            with messages.console_errors("Wrinkle Maps"):
                rebuild.sync()
        for obj, nodes_mod in objects:
            _process_guarded(obj, nodes_mod, depsgraph)


def _note_others(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> None:
    if compat.is_editable(obj) and not maps_runtimes.of(obj).stale and rebuild.is_behind_others(obj, nodes_mod):
        maps_runtimes.of(obj).stale = True
        scheduler.request()


def _process_guarded(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph) -> None:
    runtime = maps_runtimes.of(obj)
    with messages.frame_errors(obj, runtime):
        _process(obj, nodes_mod, runtime, depsgraph)
        messages.set_frame_error(runtime, "")


def _process(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime, depsgraph: bpy.types.Depsgraph
             ) -> None:
    if runtime.comparison is None or runtime.refusal or mesh_reader.is_busy(obj):
        return
    if len(obj.data.vertices) != runtime.comparison.model.vertex_count:
        runtime.stale = True
        scheduler.request()  # the topology was edited
        return
    skin = maps_modifier.skin(nodes_mod)
    if maps_meshes.made_from(skin, runtime.shape):
        # The evaluated copy has the right animated settings, in renders too.
        settings = obj.evaluated_get(depsgraph).rumple_maps
        # Until a changed list of poses is built, the nodes still have the former poses: keep their strengths.
        if [pose.name for pose in runtime.comparison.rig.poses] == [pose.name for pose in settings.poses]:
            rebuild.write_gain(skin, runtime, settings)
