# SPDX-License-Identifier: GPL-3.0-or-later
"""What linked garments show, while something is undone.

The output object of a linked garment is local: a linked one could not be written. Undo leaves what is linked as it is
in memory and reads what is local anew, so the linked modifier would name an object that was freed: linking a wrinkled
garment and undoing it ended Blender 5.2.
"""
from __future__ import annotations

from typing import NamedTuple

import bpy

from . import modifier, output_mesh


class _Shown(NamedTuple):
    garment: tuple[str, str]  # its name, and the file that it is linked from
    output: str
    viewport_output: str | None
    coarse_vertices: int


_shown: list[_Shown] = []


def let_go() -> None:
    """Before an undo or a redo. Cost: as a search for wrinkled objects."""
    _shown.clear()
    for obj, nodes_mod in modifier.wrinkled_objects():
        output, viewport_output = modifier.output_object(nodes_mod), modifier.viewport_output(nodes_mod)
        if obj.library is None or output is None or output.library is not None:
            continue
        count = modifier.coarse_vertices(nodes_mod)
        _shown.append(_Shown((obj.name, obj.library.filepath), output.name,
                             None if viewport_output is None else viewport_output.name, count))
        modifier.set_viewport_output(nodes_mod, None)
        modifier.set_output_object(nodes_mod, None, count)


def take_again() -> None:
    """After it, as far as garments and output objects are there. The others are made anew."""
    for garment, output, viewport_output, count in _shown:
        obj = bpy.data.objects.get(garment)
        nodes_mod = None if obj is None else modifier.find(obj)
        if nodes_mod is None or _local(output) is None:
            continue
        modifier.set_output_object(nodes_mod, _local(output), count)
        modifier.set_viewport_output(nodes_mod, _local(viewport_output))
    _shown.clear()


def _local(name: str | None) -> bpy.types.Object | None:
    """An output object by its name."""
    found = None if name is None else bpy.data.objects.get((name, None))
    return found if found is not None and output_mesh.KEY in found else None
