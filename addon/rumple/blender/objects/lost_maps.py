# SPDX-License-Identifier: GPL-3.0-or-later
"""Notices that a painted map was renamed or deleted with Blender's own buttons. The map has a fixed name, so nothing is
painted then.

A map without a group is not wrong in itself. So only what was read in this session, and is gone now, is reported. What
Rumple itself removes, and what undo takes back, is not.
"""
from __future__ import annotations

from typing import Any

import bpy

from . import mesh_reader, runtimes
from .runtimes import Paint


def follow(obj: bpy.types.Object, paint: Paint, settings: Any) -> None:
    """Called when paint.values were read: compare them with what was read before."""
    names = mesh_reader.paint_groups(settings)
    groups = [group.name for group in obj.vertex_groups]
    in_use = {name for key, name in names.items() if key in paint.values}
    for name in paint.in_use - in_use:
        paint.lost[name] = _new_name(name, paint.groups, groups)
    paint.lost = {name: new for name, new in paint.lost.items() if name in names.values() and name not in in_use}
    paint.in_use, paint.groups = in_use, groups


def _new_name(name: str, before: list[str], now: list[str]) -> str:
    """The new name of a vertex group; empty if it was deleted."""
    place = before.index(name) if name in before else len(now)
    return now[place] if place < len(now) and now[place] not in before else ""


def forget(obj: bpy.types.Object, name: str) -> None:
    """Called before Rumple removes a map itself."""
    runtime = runtimes.known(obj)
    if runtime is not None:
        runtime.paint.in_use.discard(name)
        runtime.paint.lost.pop(name, None)


def renamed(obj: bpy.types.Object) -> list[str]:
    """Sentences about maps that have another name now."""
    return [f"{obj.name}: the vertex group \"{name}\" is called \"{new}\" now, so it is no painted map any more: give "
            "it its former name" for name, new in _lost(obj).items() if new in obj.vertex_groups]


def deleted(obj: bpy.types.Object) -> list[str]:
    """Sentences about maps that are gone."""
    return [f"{obj.name}: \"{name}\" is gone, and what was painted in it: Ctrl Z brings it back, or paint anew"
            for name, new in _lost(obj).items() if new not in obj.vertex_groups]


def _lost(obj: bpy.types.Object) -> dict[str, str]:
    runtime = runtimes.known(obj)
    return {} if runtime is None else runtime.paint.lost
