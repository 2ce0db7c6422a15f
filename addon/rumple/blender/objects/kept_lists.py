# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists of the objects with one of our modifiers. A search runs only after something may have changed.

The lists store names, not objects, because undo and deletion free objects without telling Python. Every use looks the
names up. Other code that adds, removes or copies modifiers is always followed by an update, a frame, a file or an undo.
handlers.py then discards the lists.
"""
from __future__ import annotations

from typing import Callable, Iterable, Iterator

import bpy

from .. import compat, scheduler
from ..nodes.modifier_inputs import get_input, set_input

Found = tuple[bpy.types.Object, bpy.types.NodesModifier]


class ModifiedObjects:
    """The objects with a modifier of some kind, ordered by name."""

    def __init__(self, is_ours: Callable[[bpy.types.NodeTree | None], bool], hidden: tuple[str, ...] = ()) -> None:
        """is_ours: tests whether a node group is of that kind. hidden: its inputs that refer to hidden objects."""
        self.is_ours, self.hidden = is_ours, hidden
        self._names: list[tuple[str, str | None]] | None = None  # with the file of a linked object
        self._count = 0  # at the last search
        _all.append(self)

    def find(self, obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
        """The first such modifier of an object. It is found by its node group, because artists may rename modifiers."""
        return next((m for m in obj.modifiers if m.type == "NODES" and self.is_ours(m.node_group)), None)

    def forget(self) -> None:
        """Search again at the next use."""
        self._names = None

    def remove(self, obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, inputs: Iterable[str]) -> None:
        """Remove the modifier, and its node group if this was the last one. inputs: names of inputs with data-blocks,
        which lose a user."""
        group = nodes_mod.node_group
        for name in inputs:
            if get_input(nodes_mod, name) is not None:
                set_input(nodes_mod, name, None)
        obj.modifiers.remove(nodes_mod)
        self.forget()
        _drop_unused(group)

    def drop_unused_groups(self) -> None:
        """Remove node groups whose last modifier was removed with Blender's own buttons."""
        for group in [group for group in bpy.data.node_groups if self.is_ours(group)]:
            _drop_unused(group)

    def __iter__(self) -> Iterator[Found]:
        found = self._looked_up()
        if found is None:
            found = self._searched()
            self._names = [(obj.name, obj.library and obj.library.filepath) for obj, _ in found]
            if len(found) < self._count:
                scheduler.request()  # Blender's X reports nothing: request the removal of leftovers
            self._count = len(found)
        return iter(found)

    def _looked_up(self) -> list[Found] | None:
        """None if the list is no longer valid."""
        names = self._names  # read once, because a render's thread may discard the list
        if names is None:
            return None
        found = []
        for name in names:
            obj = bpy.data.objects.get(name)
            nodes_mod = self.find(obj) if obj is not None and obj.type == "MESH" else None
            if nodes_mod is None:
                return None
            found.append((obj, nodes_mod))
        return found

    def _searched(self) -> list[Found]:
        """Search bpy.data, because scene.objects misses objects inside collection instances."""
        if not any(self.is_ours(group) for group in bpy.data.node_groups):
            return []  # the common case in big files must be cheap
        candidates = (obj for obj in bpy.data.objects if obj.type == "MESH" and len(obj.modifiers))
        pairs = ((obj, self.find(obj)) for obj in candidates)
        return [(obj, nodes_mod) for obj, nodes_mod in pairs if nodes_mod is not None]


def _drop_unused(group: bpy.types.NodeTree) -> None:
    if group.users == 0 and compat.is_editable(group):
        bpy.data.node_groups.remove(group)


_all: list[ModifiedObjects] = []


def with_hidden() -> Iterator[tuple[bpy.types.Object, bpy.types.NodesModifier, tuple[str, ...]]]:
    """All modifiers that refer to hidden objects, with the names of these inputs."""
    for objects in _all:
        if objects.hidden:
            yield from ((obj, nodes_mod, objects.hidden) for obj, nodes_mod in objects)


def forget_all() -> None:
    """Called when objects or modifiers may have been added, removed or renamed."""
    for objects in _all:
        objects.forget()
