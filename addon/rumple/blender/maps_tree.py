# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier "Wrinkle Maps": a node tree that hands the mesh on as it is, with the masks as point attributes.

The masks lie on the points of a carrier, a hidden mesh without faces, which handlers write:
    rumple_poses_0 .. rumple_poses_5    FLOAT_VECTOR    masks of poses 1 to 3, 4 to 6, ...: for the shader
On the result they stand again, and one by one:
    rumple_pose_<name>                  FLOAT           0..1: where the map of that pose shows, and how much
Every object has a tree of its own, for the names of its poses stand in it.
"""
from __future__ import annotations

from typing import Iterator, Sequence

import bpy
import numpy as np

from ..core.poses import PACKED
from . import modifier, versions
from .maps_nodes import MASKS

NAME = "Wrinkle Maps"
KEY = "rumple_maps_tree"  # custom property of the trees ...
CARRIER_KEY = "rumple_maps_carrier"  # ... and of the carriers
MASK = "rumple_pose_{}"
CARRIER, COUNT = "Carrier", "Vertices"
SUFFIX = ".maps"


def is_ours(group: bpy.types.NodeTree | None) -> bool:
    return group is not None and KEY in group


def find(obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """The Wrinkle Maps modifier of an object."""
    return next((m for m in obj.modifiers if m.type == "NODES" and is_ours(m.node_group)), None)


def mapped_objects() -> Iterator[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """Every object with the modifier, in the order of their names."""
    if not any(is_ours(group) for group in bpy.data.node_groups):
        return  # the common case in big files must cost nothing
    for obj in bpy.data.objects:
        if obj.type == "MESH" and len(obj.modifiers):
            found = find(obj)
            if found is not None:
                yield obj, found


# ---------------------------------------------------------------- the tree
def new_tree(name: str) -> bpy.types.NodeTree:
    group = bpy.data.node_groups.new(f"Rumple {NAME} {name}", "GeometryNodeTree")
    group[KEY] = ""
    for socket, kind in (("Geometry", "NodeSocketGeometry"), (CARRIER, "NodeSocketObject"), (COUNT, "NodeSocketInt")):
        versions.new_group_socket(group, socket, "INPUT", kind)
    versions.new_group_socket(group, "Geometry", "OUTPUT", "NodeSocketGeometry")
    versions.mark_as_modifier(group)
    fill(group, ())
    return group


def fill(group: bpy.types.NodeTree, names: Sequence[str]) -> None:
    """Make the nodes for poses of these names, unless they are there."""
    wanted = repr(list(names))
    if group[KEY] == wanted:
        return
    group.nodes.clear()
    _build(group, names)
    group[KEY] = wanted


def _build(group: bpy.types.NodeTree, names: Sequence[str]) -> None:
    def node(kind: str, **properties: object) -> bpy.types.Node:
        made = group.nodes.new(kind)
        for name, value in properties.items():
            setattr(made, name, value)
        made.location = (180.0 * (len(group.nodes) // 6), -160.0 * (len(group.nodes) % 6))
        return made

    def link(output: bpy.types.NodeSocket, target: bpy.types.Node, name: str) -> None:
        group.links.new(output, versions.socket(target.inputs, name))

    def stored(geometry: bpy.types.NodeSocket, name: str, data_type: str, value: bpy.types.NodeSocket
               ) -> bpy.types.NodeSocket:
        made = node("GeometryNodeStoreNamedAttribute", data_type=data_type, domain="POINT")
        made.inputs["Name"].default_value = name
        link(geometry, made, "Geometry")
        link(value, made, "Value")
        return made.outputs[0]

    inputs = node("NodeGroupInput").outputs
    info = node("GeometryNodeObjectInfo")
    link(inputs[CARRIER], info, "Object")
    index = node("GeometryNodeInputIndex").outputs[0]
    geometry = inputs["Geometry"]
    for pack in range((len(names) + PACKED - 1) // PACKED):
        named = node("GeometryNodeInputNamedAttribute", data_type="FLOAT_VECTOR")
        named.inputs["Name"].default_value = MASKS.format(pack)
        sample = node("GeometryNodeSampleIndex", data_type="FLOAT_VECTOR", domain="POINT")
        link(info.outputs["Geometry"], sample, "Geometry")
        link(versions.socket(named.outputs, "Attribute"), sample, "Value")
        link(index, sample, "Index")
        masks = versions.socket(sample.outputs, "Value")
        geometry = stored(geometry, MASKS.format(pack), "FLOAT_VECTOR", masks)
        parts = node("ShaderNodeSeparateXYZ")
        group.links.new(masks, parts.inputs[0])
        for name, part in zip(names[PACKED * pack:], parts.outputs):
            geometry = stored(geometry, MASK.format(name), "FLOAT", part)
    size = node("GeometryNodeAttributeDomainSize", component="MESH")
    group.links.new(inputs["Geometry"], size.inputs[0])
    fits = node("FunctionNodeCompare", data_type="INT", operation="EQUAL")
    link(size.outputs["Point Count"], fits, "A")
    link(inputs[COUNT], fits, "B")
    switch = node("GeometryNodeSwitch", input_type="GEOMETRY")
    link(fits.outputs[0], switch, "Switch")
    link(inputs["Geometry"], switch, "False")
    link(geometry, switch, "True")
    group.links.new(versions.socket(switch.outputs, "Output"), node("NodeGroupOutput").inputs[0])


# ---------------------------------------------------------------- the modifier and its carrier
def add(obj: bpy.types.Object) -> bpy.types.NodesModifier:
    """Put the modifier behind the last deforming one, and behind other wrinkles, with a tree of its own."""
    wrinkles = modifier.find(obj)
    place = modifier.place_behind_deforming(obj) if wrinkles is None else list(obj.modifiers).index(wrinkles) + 1
    made = obj.modifiers.new(NAME, "NODES")
    made.node_group = new_tree(obj.name)
    last = len(obj.modifiers) - 1
    if place != last:
        versions.move_modifier(obj, last, place)
    return find(obj)


def remove(obj: bpy.types.Object) -> None:
    """The modifier, its tree and its carrier."""
    ours = find(obj)
    if ours is None:
        return
    group, held = ours.node_group, carrier(ours)
    _set(ours, CARRIER, None)
    obj.modifiers.remove(ours)
    if group.users == 0 and versions.is_editable(group):
        bpy.data.node_groups.remove(group)
    if held is not None and not any(carrier(other) == held for _, other in mapped_objects()):
        modifier.delete_hidden(held)


def _set(ours: bpy.types.NodesModifier, name: str, value: object) -> None:
    versions.set_modifier_input(ours, versions.group_sockets(ours.node_group, "INPUT")[name], value)


def _get(ours: bpy.types.NodesModifier, name: str) -> object:
    identifier = versions.group_sockets(ours.node_group, "INPUT").get(name)
    return versions.modifier_input(ours, identifier) if identifier else None


def carrier(ours: bpy.types.NodesModifier) -> bpy.types.Object | None:
    found = _get(ours, CARRIER)
    return found if isinstance(found, bpy.types.Object) and found.type == "MESH" else None


def vertices(ours: bpy.types.NodesModifier) -> int:
    """The number of points that the masks were made for."""
    return int(_get(ours, COUNT) or 0)


def give_carrier(obj: bpy.types.Object, ours: bpy.types.NodesModifier, count: int) -> bpy.types.Object:
    """A new carrier of so many points, in no collection: the modifier's input keeps it alive."""
    mesh = bpy.data.meshes.new(obj.name + SUFFIX)
    mesh.vertices.add(count)
    held = bpy.data.objects.new(obj.name + SUFFIX, mesh)
    held[CARRIER_KEY] = True
    former = carrier(ours)
    _set(ours, CARRIER, held)
    _set(ours, COUNT, count)
    # An input set from Python does not tell the dependency graph about the new relation; setting the group does.
    ours.node_group = ours.node_group
    obj.update_tag()
    if former is not None and former.users == 0:
        modifier.delete_hidden(former)
    return held


def write(held: bpy.types.Object, packs: Sequence[np.ndarray]) -> None:
    """One frame's masks. The only thing that handlers write."""
    for number, pack in enumerate(packs):
        versions.write_attribute(held.data, MASKS.format(number), "FLOAT_VECTOR", "POINT", pack)
    held.data.update()
