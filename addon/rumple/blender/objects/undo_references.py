# SPDX-License-Identifier: GPL-3.0-or-later
"""The hidden data-blocks that our modifiers and settings name, while something is undone.

Undo leaves a data-block as it is in memory where it is linked, or where both undo steps have the same of it. What was
written into it since, outside of a step, stays as well: handlers and timers make output objects. Undo frees what no
step has, and reads the rest anew, so such a data-block would name memory that was freed: Blender crashed. So ours name
nothing of that kind meanwhile.
"""
from __future__ import annotations

from typing import Any, NamedTuple

import bpy

from .. import compat
from ..nodes.modifier_inputs import get_input, set_input
from . import kept_lists, messages

_SETTINGS = {"rumple": ("incoming", "captured", "profile_curve"), "rumple_maps": ("group",)}


class _Block(NamedTuple):
    """A data-block as it was. In 3.4 its key is its address, which another one may have after the undo: a mesh of the
    artist's, or that of another garment. Two data-blocks of one type do not have the same name."""

    key: int
    kind: type[bpy.types.ID]
    name: str

    @classmethod
    def of(cls, block: bpy.types.ID) -> "_Block":
        return cls(compat.session_key(block), type(block), block.name_full)

    def found(self, present: dict[int, bpy.types.ID]) -> bpy.types.ID | None:
        """The same one, by session key, if it is there."""
        block = present.get(self.key)
        return block if isinstance(block, self.kind) and block.name_full == self.name else None


class _Named(NamedTuple):
    """What one of our modifiers, and the settings of its object, named, by input and setting."""

    obj: _Block
    modifier: str
    inputs: dict[str, _Block]
    settings: dict[tuple[str, str], _Block]


_named: list[_Named] = []


def clear_references() -> None:
    """Before an undo or a redo. Cost: as a search for our modifiers; Blender evaluates their objects again."""
    restore_references()  # after one that was broken off
    for obj, nodes_mod, names in list(kept_lists.with_hidden()):
        with messages.console_errors(obj.name):
            inputs = _blocks({name: get_input(nodes_mod, name) for name in names})
            settings = _blocks({(group, name): getattr(getattr(obj, group), name)
                                for group, names in _SETTINGS.items() for name in names if compat.is_editable(obj)})
            _named.append(_Named(_Block.of(obj), nodes_mod.name, inputs, settings))
            for group, name in settings:
                setattr(getattr(obj, group), name, None)
            _set(nodes_mod, dict.fromkeys(inputs))


def restore_references() -> None:
    """After it: where undo left an object as it was, as far as that is there. The rest is made anew."""
    named, _named[:] = list(_named), []
    if not named:
        return
    present = {compat.session_key(block): block
               for blocks in (bpy.data.objects, bpy.data.meshes, bpy.data.node_groups) for block in blocks}
    for each in named:
        with messages.console_errors("undo"):
            _restore(each, present)


def _restore(named: _Named, present: dict[int, bpy.types.ID]) -> None:
    obj = named.obj.found(present)
    nodes_mod = None if obj is None else obj.modifiers.get(named.modifier)
    if nodes_mod is None:
        return
    # An object that was read anew has some of it again, or it needs none of it.
    if all(getattr(getattr(obj, group), name) is None for group, name in named.settings):
        for (group, name), block in named.settings.items():
            setattr(getattr(obj, group), name, block.found(present))
    if all(get_input(nodes_mod, name) is None for name in named.inputs):
        inputs = {name: block.found(present) for name, block in named.inputs.items()}
        _set(nodes_mod, {name: block for name, block in inputs.items() if block is not None})


def _set(nodes_mod: bpy.types.NodesModifier, values: dict[str, bpy.types.Object | None]) -> None:
    for name, value in values.items():
        set_input(nodes_mod, name, value)
    if values:
        # An input set from Python does not tell the dependency graph about the new relation; setting the group does.
        nodes_mod.node_group = nodes_mod.node_group
        nodes_mod.id_data.update_tag()


def _blocks(blocks: dict[Any, object]) -> dict[Any, _Block]:
    """Those that undo may free or read anew."""
    return {name: _Block.of(block) for name, block in blocks.items()
            if isinstance(block, bpy.types.ID) and compat.is_editable(block)}
