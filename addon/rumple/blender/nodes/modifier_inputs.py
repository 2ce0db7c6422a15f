# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs of modifiers by the names that their node groups give them."""
from __future__ import annotations

from typing import Any

import bpy

from .. import compat


def get_input(nodes_mod: bpy.types.NodesModifier, name: str) -> Any:
    """Its value; None where it was never set, and where an older group has no such input."""
    identifier = compat.group_sockets(nodes_mod.node_group, "INPUT").get(name)
    return compat.modifier_input(nodes_mod, identifier) if identifier else None


def values(nodes_mod: bpy.types.NodesModifier) -> list[Any]:
    """Of all its inputs."""
    if nodes_mod.node_group is None:
        return []
    return [compat.modifier_input(nodes_mod, identifier)
            for identifier in compat.group_sockets(nodes_mod.node_group, "INPUT").values()]


def set_input(nodes_mod: bpy.types.NodesModifier, name: str, value: object) -> None:
    """The caller tags the object."""
    compat.set_modifier_input(nodes_mod, compat.group_sockets(nodes_mod.node_group, "INPUT")[name], value)
