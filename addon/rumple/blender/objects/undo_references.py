# SPDX-License-Identifier: GPL-3.0-or-later
"""The hidden data-blocks that our modifiers and settings name, while something is undone.

Undo leaves a data-block as it is in memory where it is linked, or where both undo steps have the same of it. What was
written into it since, outside of a step, stays as well: handlers and timers make output objects. Undo frees what no
step has, and reads the rest anew, so such a data-block would name memory that was freed: Blender ended. So ours name
nothing of that kind meanwhile.
"""
from __future__ import annotations

from typing import NamedTuple

import bpy

from .. import compat
from ..nodes.modifier_inputs import get_input, set_input
from . import kept_lists

_OF_SETTINGS = ("incoming", "captured", "profile_curve")  # of obj.rumple


class _Named(NamedTuple):
    """What one of our modifiers, and the settings of its object, named: session keys by input and setting."""

    obj: int  # session key
    modifier: str
    inputs: dict[str, int]
    settings: dict[str, int]


_named: list[_Named] = []


def let_go() -> None:
    """Before an undo or a redo. Cost: as a search for our modifiers; Blender evaluates their objects again."""
    take_again()  # after one that was broken off
    for obj, nodes_mod, names in list(kept_lists.with_hidden()):
        inputs = _keys({name: get_input(nodes_mod, name) for name in names})
        settings = _keys({name: getattr(obj.rumple, name) for name in _OF_SETTINGS if compat.is_editable(obj)})
        for name in settings:
            setattr(obj.rumple, name, None)
        _set(nodes_mod, dict.fromkeys(inputs))
        _named.append(_Named(compat.session_key(obj), nodes_mod.name, inputs, settings))


def take_again() -> None:
    """After it: where undo left an object as it was, as far as that is there. The rest is made anew."""
    if not _named:
        return
    present = {compat.session_key(block): block
               for blocks in (bpy.data.objects, bpy.data.meshes, bpy.data.node_groups) for block in blocks}
    for named in _named:
        obj = present.get(named.obj)
        nodes_mod = obj.modifiers.get(named.modifier) if isinstance(obj, bpy.types.Object) else None
        if nodes_mod is None:
            continue
        for name, key in named.settings.items():
            if getattr(obj.rumple, name) is None and key in present:
                setattr(obj.rumple, name, present[key])
        _set(nodes_mod, {name: present[key] for name, key in named.inputs.items()
                         if key in present and get_input(nodes_mod, name) is None})
    _named.clear()


def _set(nodes_mod: bpy.types.NodesModifier, values: dict[str, bpy.types.Object | None]) -> None:
    for name, value in values.items():
        set_input(nodes_mod, name, value)
    if values:
        # An input set from Python does not tell the dependency graph about the new relation; setting the group does.
        nodes_mod.node_group = nodes_mod.node_group
        nodes_mod.id_data.update_tag()


def _keys(blocks: dict[str, object]) -> dict[str, int]:
    """Of what undo may free or read anew."""
    return {name: compat.session_key(block) for name, block in blocks.items()
            if isinstance(block, bpy.types.ID) and compat.is_editable(block)}
