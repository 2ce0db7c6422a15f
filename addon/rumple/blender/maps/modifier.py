# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier "Wrinkle Maps": a node tree that does not change the mesh, but adds the masks as point attributes.

    rumple_poses_0 .. rumple_poses_5    FLOAT_VECTOR    masks of poses 1 to 3, 4 to 6, ...: for the shader
    rumple_pose_<name>                  FLOAT           0..1: where and how strongly the map of this pose is visible
Every object has its own tree, because the tree contains the names of its poses. maps_mask_tree.py makes the nodes,
maps/hidden_meshes.py the hidden objects that they read.
"""
from __future__ import annotations

from typing import Iterator

import bpy

from ..nodes import maps_mask_tree
from ..nodes.builder import empty_modifier_group
from ..nodes.maps_mask_tree import BONES, COUNT, SKIN, WRINKLES, Shape
from ..nodes.modifier_inputs import get_input, get_object, set_relations
from ..objects import modifier
from ..objects.kept_lists import ModifiedObjects

NAME = "Wrinkle Maps"
KEY = "rumple_maps_tree"  # custom property of the trees


def is_ours(group: bpy.types.NodeTree | None) -> bool:
    return group is not None and KEY in group


_HIDDEN = (SKIN, BONES, WRINKLES)
_MAPPED = ModifiedObjects(is_ours, _HIDDEN)


def find(obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """The Wrinkle Maps modifier of an object."""
    return _MAPPED.find(obj)


def mapped_objects() -> Iterator[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """Every object with the modifier, in the order of their names. The list is kept."""
    return iter(_MAPPED)


# ---------------------------------------------------------------- the tree
def new_tree(name: str) -> bpy.types.NodeTree:
    group = bpy.data.node_groups.new(f"Rumple {NAME} {name}", "GeometryNodeTree")
    group[KEY] = ""
    fill(group, Shape())
    return group


def fill(group: bpy.types.NodeTree, shape: Shape) -> None:
    """Make the nodes, if necessary, and sockets that an older file lacks."""
    if group[KEY] == repr(shape):
        return
    empty_modifier_group(group, maps_mask_tree.INPUTS)
    maps_mask_tree.Builder(group, shape).build()
    group[KEY] = repr(shape)


# ---------------------------------------------------------------- the modifier and what it reads
def add(obj: bpy.types.Object) -> bpy.types.NodesModifier:
    """Add the modifier after the last deforming modifier and after other wrinkles, with its own tree."""
    wrinkles = modifier.find(obj)
    place = modifier.place_behind_deforming(obj) if wrinkles is None else list(obj.modifiers).index(wrinkles) + 1
    made = obj.modifiers.new(NAME, "NODES")
    made.node_group = new_tree(obj.name)
    _MAPPED.forget()
    modifier.move_new(made, place)
    return find(obj)


def remove(obj: bpy.types.Object) -> None:
    """Remove the modifier, its tree and its hidden objects."""
    nodes_mod = find(obj)
    if nodes_mod is None:
        return
    read = hidden(nodes_mod)
    _MAPPED.remove(obj, nodes_mod, _HIDDEN)
    still_hidden = {other for _, another in mapped_objects() for other in hidden(another)}
    for former in read - still_hidden:
        modifier.delete_hidden(former)


def drop_unused_trees() -> None:
    """Remove the trees of modifiers that were removed with Blender's own buttons."""
    _MAPPED.drop_unused_groups()


def _mesh_object(nodes_mod: bpy.types.NodesModifier, name: str) -> bpy.types.Object | None:
    found = get_object(nodes_mod, name)
    return found if found is not None and found.type == "MESH" else None


def skin(nodes_mod: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object with the weights."""
    return _mesh_object(nodes_mod, SKIN)


def skeleton(nodes_mod: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object that follows the bones."""
    return _mesh_object(nodes_mod, BONES)


def wrinkles(nodes_mod: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The output object of other wrinkles that it knows of."""
    return _mesh_object(nodes_mod, WRINKLES)


def hidden(nodes_mod: bpy.types.NodesModifier) -> set[bpy.types.Object]:
    """Skin and skeleton, if it has them."""
    return {read for read in (skin(nodes_mod), skeleton(nodes_mod)) if read is not None}


def connect(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, new_skin: bpy.types.Object | None,
            new_skeleton: bpy.types.Object | None, wrinkles: bpy.types.Object | None) -> None:
    """Make the modifier read these objects, and store the current number of vertices. The former objects are removed,
    unless other modifiers read them.

    wrinkles: the output object of the modifier that makes other wrinkles in front of this one.
    """
    count, former = len(obj.data.vertices), hidden(nodes_mod)
    wanted = {SKIN: new_skin, BONES: new_skeleton, WRINKLES: wrinkles, COUNT: count}
    if all((get_input(nodes_mod, name) or None) == (value or None) for name, value in wanted.items()):
        return
    set_relations(nodes_mod, wanted)
    for unread in former - {new_skin, new_skeleton}:
        if unread.users == 0:
            modifier.delete_hidden(unread)
