# SPDX-License-Identifier: GPL-3.0-or-later
"""The structural work of the Wrinkle Maps: comparisons, trees, hidden meshes, duplicates, leftovers."""
from __future__ import annotations

import bpy

from ...core.base.wording import UserError
from ...core.systems.poses import strengths
from .. import compat
from ..frame import rebuild as frame_rebuild
from ..nodes import use_nodes
from ..nodes.maps_mask_tree import Shape
from ..objects import messages, modifier
from . import (comparison as comparisons, hidden_meshes as maps_meshes, modifier as maps_modifier,
               runtimes as maps_runtimes, stored_poses)
from .runtimes import Runtime


def sync() -> None:
    """Update every object: trees, shared skins and groups, comparisons. Remove unused data."""
    objects = list(maps_modifier.mapped_objects())
    maps_runtimes.forget_all_but(obj for obj, _ in objects)
    used = {hidden for _, nodes_mod in objects for hidden in maps_modifier.hidden(nodes_mod)}
    objects = [(obj, nodes_mod) for obj, nodes_mod in objects
               if compat.is_editable(obj)]  # linked objects cannot be written
    _split_shared(objects)
    for obj, nodes_mod in objects:
        modifier.take_out_of_scenes(maps_modifier.hidden(nodes_mod))
        runtime = maps_runtimes.of(obj)
        if runtime.stale or runtime.unsure or is_behind_others(obj, nodes_mod):
            prepare(obj, nodes_mod)
    for obj in bpy.data.objects:
        note_method(obj)
    _tidy(used | {hidden for _, nodes_mod in objects for hidden in maps_modifier.hidden(nodes_mod)})


def note_method(obj: bpy.types.Object) -> None:
    """Set the method to MAPS if there are no other wrinkles."""
    method = obj.rumple.method
    if obj.type != "MESH" or not compat.is_editable(obj) or (method == "NONE" and not len(obj.modifiers)):
        return
    if maps_modifier.find(obj) is not None:
        if method != "MAPS" and modifier.find(obj) is None:
            obj.rumple.method = "MAPS"
    elif method == "MAPS":
        obj.rumple.method = "NONE"


def _wrinkles_in_front(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The output object of a Wrinkle Mesh, Field or Paths before the maps in the stack."""
    wrinkles, stack = modifier.find(obj), list(obj.modifiers)
    if wrinkles is None or stack.index(wrinkles) > stack.index(nodes_mod):
        return None
    return modifier.output_object(wrinkles)


def is_behind_others(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether other wrinkles were added, removed or rebuilt since the modifier was prepared."""
    return _wrinkles_in_front(obj, nodes_mod) != maps_modifier.wrinkles(nodes_mod)


def prepare(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> None:
    """Update comparison, tree, skin and skeleton. An error becomes the object's message."""
    runtime = maps_runtimes.of(obj)
    runtime.stale = runtime.unsure = False
    with messages.build_errors(obj, runtime):  # without the native library the existing nodes still work
        try:
            _prepare(obj, nodes_mod, runtime)
        except UserError:  # better no masks than wrong ones
            maps_modifier.connect(obj, nodes_mod, None, None, _wrinkles_in_front(obj, nodes_mod))
            raise
        messages.set_build_error(runtime, "")


def _prepare(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime) -> None:
    stored_poses.remember_rest(obj)
    comparisons.ensure(obj, runtime)
    comparison, front = runtime.comparison, _wrinkles_in_front(obj, nodes_mod)
    if comparison is None:
        maps_modifier.fill(nodes_mod.node_group, Shape())
        maps_modifier.connect(obj, nodes_mod, None, None, front)
        return
    table = comparison.table()
    maps_modifier.fill(nodes_mod.node_group, Shape(
        tuple(pose.name for pose in comparison.rig.poses), len(comparison.rig.elements), len(comparison.rig.keys),
        1 + len(table.more), bool((comparison.rig.group_numbers() >= 0).any()), front is not None))
    skin, skeleton = maps_modifier.skin(nodes_mod), maps_modifier.skeleton(nodes_mod)
    if not maps_meshes.made_from(skin, runtime.shape):
        skin = maps_meshes.new_skin(obj.name, comparison, runtime.shape)
        runtime.written = None  # even if the key is equal: in 3.4 it is an address, which the former skin may have had
    if not maps_meshes.made_from(skeleton, runtime.shape) or not maps_meshes.follows(skeleton, obj, comparison.rig):
        skeleton = maps_meshes.new_skeleton(obj, comparison, runtime.shape)
    write_gain(skin, runtime, obj.rumple_maps)
    maps_modifier.connect(obj, nodes_mod, skin, skeleton, front)


def write_gain(skin: bpy.types.Object, runtime: Runtime, settings: bpy.types.PropertyGroup) -> None:
    """Write gain, strengths, mute and solo, but only after a change, because a write causes another evaluation."""
    wanted, key = (settings.gain, tuple(strengths(settings.poses))), compat.session_key(skin.data)
    if wanted != runtime.written or key != runtime.output_key:
        maps_meshes.write_weights(skin, runtime.comparison, *wanted)
        runtime.written, runtime.output_key = wanted, key


def _split_shared(objects: list[tuple[bpy.types.Object, bpy.types.NodesModifier]]) -> None:
    """Give duplicates their own tree, skin and shader group, which they share with their original, or an override with
    the linked file. A skeleton is never written, so it may be shared until the poses differ."""
    seen: set[bpy.types.ID] = set()
    for obj, nodes_mod in objects:
        if nodes_mod.node_group in seen or not compat.is_editable(nodes_mod.node_group):
            nodes_mod.node_group = nodes_mod.node_group.copy()
        skin = maps_modifier.skin(nodes_mod)
        if skin is not None and skin in seen:
            maps_modifier.connect(obj, nodes_mod, None, maps_modifier.skeleton(nodes_mod),
                                  maps_modifier.wrinkles(nodes_mod))
            maps_runtimes.of(obj).stale = True
        group = obj.rumple_maps.group
        if group is not None and group in seen and use_nodes.keeps_nodes(group):  # a linked one: see materials.py
            obj.rumple_maps.group = group.copy()  # until it has its own materials, they show the original's maps
        seen |= {nodes_mod.node_group, maps_modifier.skin(nodes_mod), obj.rumple_maps.group}


def _tidy(used: set[bpy.types.Object | None]) -> None:
    """Remove trees, skins and skeletons whose modifier was removed or applied with Blender's own buttons."""
    maps_modifier.drop_unused_trees()
    candidates = {o for o in bpy.data.objects if maps_meshes.KEY in o} - used
    if candidates:
        for candidate, users in bpy.data.user_map(subset=candidates).items():
            if not users:
                modifier.delete_hidden(candidate)
    frame_rebuild.drop_orphan_outputs()  # output objects of removed wrinkles, which the maps read until now
