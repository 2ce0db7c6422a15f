# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and sets shape keys for the Wrinkle Maps: their values, and how far each key moves every vertex."""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...core.systems.shape_keys import weights_of_key
from ..objects import mesh_reader

SET = 1e-3  # a smaller difference of values is the rounding of a driver


def blocks(obj: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    """The relative shape keys of a mesh without its Basis."""
    keys = obj.data.shape_keys
    return list(keys.key_blocks)[1:] if keys is not None and keys.use_relative else []


def are_absolute(obj: bpy.types.Object) -> bool:
    keys = obj.data.shape_keys
    return keys is not None and not keys.use_relative and len(keys.key_blocks) > 1


def value_of(block: bpy.types.ShapeKey) -> float:
    """Its value in the shape: 0 if it is muted."""
    return 0.0 if block.mute else block.value


def values(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> dict[str, float]:
    """The current value of every key, with drivers and animation. Without a depsgraph: the last evaluated values."""
    if not blocks(obj):
        return {}
    keys = obj.data.shape_keys
    found = keys if depsgraph is None else keys.evaluated_get(depsgraph)
    return {block.name: value_of(block) for block in list(found.key_blocks)[1:]}


def are_set(obj: bpy.types.Object, names: list[str]) -> bool:
    """Whether one of these keys differs from the neutral pose."""
    neutral = {record.name: record.value for record in obj.rumple_maps.neutral_keys}
    now = values(obj)
    return any(abs(now.get(name, 0.0) - neutral.get(name, 0.0)) > SET for name in names)


# ---------------------------------------------------------------- which vertices
def weights(obj: bpy.types.Object, name: str) -> np.ndarray:
    """(n,) 0..1: how far a key moves each vertex, used like a skin weight."""
    block = obj.data.shape_keys.key_blocks[name]
    displacements = mesh_reader.key_positions(block) - mesh_reader.key_positions(block.relative_key)
    if block.vertex_group in obj.vertex_groups:
        displacements *= mesh_reader.group_weights(obj, obj.data, [block.vertex_group])
    return weights_of_key(displacements)


def moving(obj: bpy.types.Object) -> list[str]:
    """Names of the keys that move any vertex."""
    return [block.name for block in blocks(obj) if weights(obj, block.name).any()]


# ---------------------------------------------------------------- setting them
def choose(chosen: bpy.types.bpy_prop_collection, names: list[str]) -> None:
    """Compare exactly these keys, or bones. Settings of those that stay are kept."""
    for place in reversed(range(len(chosen))):
        if chosen[place].name not in names:
            chosen.remove(place)
    for name in names:
        if name not in chosen:
            chosen.add().name = name


def set_values(obj: bpy.types.Object, wanted: dict[str, float]) -> list[str]:
    """Set keys; returns the names that the mesh does not have."""
    known = {block.name: block for block in blocks(obj)}
    for name, value in wanted.items():
        block = known.get(name)
        if block is not None and not (block.mute and value == 0.0):  # a muted key already has the effect of 0
            block.value = value
    return [name for name, value in wanted.items() if name not in known and value]


def astray(obj: bpy.types.Object, wanted: dict[str, float]) -> list[str]:
    """Names of keys that do not have the wanted value, because a driver or a mute overrides it."""
    now = values(obj)
    return [name for name, value in wanted.items() if name in now and abs(now[name] - value) > SET]


def freeze(mesh: bpy.types.Mesh, wanted: dict[str, float]) -> None:
    """Set the keys of a mesh that nothing else uses, whatever drives or animates them."""
    if mesh.shape_keys is None or not mesh.shape_keys.use_relative:
        return
    mesh.shape_keys.animation_data_clear()
    for block in list(mesh.shape_keys.key_blocks)[1:]:
        if block.name in wanted:
            block.mute, block.value = False, wanted[block.name]


def of_records(records: Any) -> dict[str, float]:
    return {record.name: record.value for record in records}
