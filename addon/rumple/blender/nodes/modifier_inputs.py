# SPDX-License-Identifier: GPL-3.0-or-later
"""Access to modifier inputs by their names in the node group."""
from __future__ import annotations

from typing import Any, Iterator

import bpy

from .. import compat


def get_input(nodes_mod: bpy.types.NodesModifier, name: str) -> Any:
    """The value of an input; None if it was never set, or if an older group does not have it."""
    identifier = compat.socket_identifier(nodes_mod.node_group, name)
    return compat.modifier_input(nodes_mod, identifier) if identifier else None


def get_object(nodes_mod: bpy.types.NodesModifier, name: str) -> bpy.types.Object | None:
    """The object that an input refers to."""
    found = get_input(nodes_mod, name)
    return found if isinstance(found, bpy.types.Object) else None


def values(nodes_mod: bpy.types.NodesModifier) -> list[Any]:
    """The values of all inputs."""
    if nodes_mod.node_group is None:
        return []
    return [compat.modifier_input(nodes_mod, identifier)
            for identifier in compat.group_sockets(nodes_mod.node_group, "INPUT").values()]


def objects_read(nodes_mod: bpy.types.NodesModifier) -> Iterator[bpy.types.Object]:
    """The objects that its inputs name, also by a collection. Not those that are set inside the node group: this is
    called in every frame, and a simulation has thousands of nodes."""
    for value in values(nodes_mod):
        if isinstance(value, bpy.types.Object):
            yield value
        elif isinstance(value, bpy.types.Collection):
            yield from value.all_objects


def set_input(nodes_mod: bpy.types.NodesModifier, name: str, value: object) -> None:
    """Set an input. The caller must tag the object."""
    compat.set_modifier_input(nodes_mod, compat.group_sockets(nodes_mod.node_group, "INPUT")[name], value)


def set_relations(nodes_mod: bpy.types.NodesModifier, inputs: dict[str, object]) -> None:
    """Set inputs, by name, that refer to other objects. If Python sets an input, the dependency graph does not get the
    new relation. It does if the group is set."""
    for name, value in inputs.items():
        set_input(nodes_mod, name, value)
    if inputs:
        nodes_mod.node_group = nodes_mod.node_group
        nodes_mod.id_data.update_tag()
