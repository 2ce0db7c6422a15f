# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects have one of our modifiers: searched for once after something may have changed, then kept.

Kept are names, not objects: undo and deletion free those behind Python's back. Every use looks them up again. What
adds, removes or copies modifiers outside of our own code is followed by an update, a frame, a file or an undo, and
handlers.py lets go of the lists then.
"""
from __future__ import annotations

from typing import Callable, Iterable, Iterator

import bpy

from .. import compat, scheduler
from ..nodes.modifier_inputs import get_input, set_input

Found = tuple[bpy.types.Object, bpy.types.NodesModifier]


class ModifiedObjects:
    """The objects with a modifier of some kind, in the order of their names."""

    def __init__(self, is_ours: Callable[[bpy.types.NodeTree | None], bool], hidden: tuple[str, ...] = ()) -> None:
        """is_ours: of the node groups of that kind. hidden: their inputs that hold hidden objects."""
        self.is_ours, self.hidden = is_ours, hidden
        self._names: list[tuple[str, str | None]] | None = None  # with the file that a linked object comes from
        self._count = 0  # when they were searched for last
        _all.append(self)

    def find(self, obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
        """The first such modifier of an object, by its node group: artists may rename modifiers."""
        return next((m for m in obj.modifiers if m.type == "NODES" and self.is_ours(m.node_group)), None)

    def forget(self) -> None:
        """Search again."""
        self._names = None

    def remove(self, obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, inputs: Iterable[str]) -> None:
        """Take the modifier away, and its node group when it was the last. inputs: names of those that hold
        data-blocks, which lose a user."""
        group = nodes_mod.node_group
        for name in inputs:
            if get_input(nodes_mod, name) is not None:
                set_input(nodes_mod, name, None)
        obj.modifiers.remove(nodes_mod)
        self.forget()
        _drop_unused(group)

    def drop_unused_groups(self) -> None:
        """Node groups whose last modifier was removed by Blender's own buttons."""
        for group in [group for group in bpy.data.node_groups if self.is_ours(group)]:
            _drop_unused(group)

    def __iter__(self) -> Iterator[Found]:
        found = self._looked_up()
        if found is None:
            found = self._searched()
            self._names = [(obj.name, obj.library and obj.library.filepath) for obj, _ in found]
            if len(found) < self._count:
                scheduler.request()  # Blender's X says nothing: what the modifier leaves behind is to go
            self._count = len(found)
        return iter(found)

    def _looked_up(self) -> list[Found] | None:
        """None where the list does not hold any more."""
        names = self._names  # of now: a render's thread may forget them meanwhile
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
        """From bpy.data, not from the scene: scene.objects misses the insides of collection instances."""
        if not any(self.is_ours(group) for group in bpy.data.node_groups):
            return []  # the common case in big files must cost nothing
        candidates = (obj for obj in bpy.data.objects if obj.type == "MESH" and len(obj.modifiers))
        pairs = ((obj, self.find(obj)) for obj in candidates)
        return [(obj, nodes_mod) for obj, nodes_mod in pairs if nodes_mod is not None]


def _drop_unused(group: bpy.types.NodeTree) -> None:
    if group.users == 0 and compat.is_editable(group):
        bpy.data.node_groups.remove(group)


_all: list[ModifiedObjects] = []


def with_hidden() -> Iterator[tuple[bpy.types.Object, bpy.types.NodesModifier, tuple[str, ...]]]:
    """All modifiers that hold hidden objects, with the names of these inputs."""
    for objects in _all:
        if objects.hidden:
            yield from ((obj, nodes_mod, objects.hidden) for obj, nodes_mod in objects)


def forget_all() -> None:
    """Anything may have been added, removed or renamed."""
    for objects in _all:
        objects.forget()
