# SPDX-License-Identifier: GPL-3.0-or-later
"""Clears the references of our modifiers and settings to hidden data-blocks during an undo.

Undo does not replace a data-block in memory if it is linked, or if both undo steps have the same version of it. Then
references written into it since the last step also stay; handlers and timers write such references to output objects.
But undo frees data-blocks that the step does not have, and replaces changed ones. The references would then point to
freed memory, and Blender crashed. So our modifiers and settings have no such references during an undo.
"""
from __future__ import annotations

from typing import Any, NamedTuple

import bpy

from .. import compat
from ..nodes.modifier_inputs import get_input, set_relations
from . import kept_lists, messages

_SETTINGS = {"rumple": ("incoming", "captured", "profile_curve"), "rumple_maps": ("group",)}


class _Block(NamedTuple):
    """The identity of a data-block. In 3.4 its key is its address. After the undo another data-block may have this
    address: a mesh of the artist or of another garment. So the name is compared too: two data-blocks of one type have
    different names."""

    key: int
    kind: type[bpy.types.ID]
    name: str

    @classmethod
    def of(cls, block: bpy.types.ID) -> "_Block":
        return cls(compat.session_key(block), type(block), block.name_full)

    def found(self, present: dict[int, bpy.types.ID]) -> bpy.types.ID | None:
        """The same data-block, found by session key, if it still exists."""
        block = present.get(self.key)
        return block if isinstance(block, self.kind) and block.name_full == self.name else None


class _Named(NamedTuple):
    """The references of one of our modifiers and of the settings of its object, by input and setting."""

    obj: _Block
    modifier: str
    inputs: dict[str, _Block]
    settings: dict[tuple[str, str], _Block]


_named: list[_Named] = []


def clear_references() -> None:
    """Called before an undo or a redo. Cost: as a search for our modifiers. Blender evaluates their objects again."""
    restore_references()  # in case the last undo was aborted
    for obj, nodes_mod, names in list(kept_lists.with_hidden()):
        with messages.console_errors(obj.name):
            inputs = _blocks({name: get_input(nodes_mod, name) for name in names})
            settings = _blocks({(group, name): getattr(getattr(obj, group), name)
                                for group, names in _SETTINGS.items() for name in names if compat.is_editable(obj)})
            _named.append(_Named(_Block.of(obj), nodes_mod.name, inputs, settings))
            for group, name in settings:
                setattr(getattr(obj, group), name, None)
            set_relations(nodes_mod, dict.fromkeys(inputs))


def restore_references() -> None:
    """Called after it. Restores the references of objects that undo has not replaced, as far as the data-blocks exist.
    The others are rebuilt."""
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
    # An object that was replaced already has some of them, or needs none.
    if all(getattr(getattr(obj, group), name) is None for group, name in named.settings):
        for (group, name), block in named.settings.items():
            setattr(getattr(obj, group), name, block.found(present))
    if all(get_input(nodes_mod, name) is None for name in named.inputs):
        inputs = {name: block.found(present) for name, block in named.inputs.items()}
        set_relations(nodes_mod, {name: block for name, block in inputs.items() if block is not None})


def _blocks(blocks: dict[Any, object]) -> dict[Any, _Block]:
    """The data-blocks that undo may free or replace."""
    return {name: _Block.of(block) for name, block in blocks.items()
            if isinstance(block, bpy.types.ID) and compat.is_editable(block)}
