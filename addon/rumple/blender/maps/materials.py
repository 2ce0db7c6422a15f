# SPDX-License-Identifier: GPL-3.0-or-later
"""The wrinkle maps in the materials of an object.

A library override cannot change what it has from the linked file: its shader group and its materials. So it gets a
group of its own as soon as its maps are other ones. Of its materials only those of this file can show that.
"""
from __future__ import annotations

from typing import Any

import bpy

from ...core.base.wording import UserError
from .. import compat
from ..nodes import maps_shader, use_nodes
from . import modifier as maps_modifier, rig as maps_rig


def materials_of(obj: bpy.types.Object) -> list[bpy.types.Material]:
    """The materials of an object, in the order of their names."""
    return sorted({slot.material for slot in obj.material_slots} - {None}, key=lambda material: material.name_full)


def fill(obj: bpy.types.Object) -> None:
    """Let the object's shader group, if it has one, show its maps."""
    settings = obj.rumple_maps
    if settings.group is None or not compat.is_editable(obj):
        return
    if not use_nodes.keeps_nodes(settings.group):
        settings.group = settings.group.copy()
        _replace_linked(obj)
    maps_shader.fill(settings.group, maps_rig.usable_images(obj), settings.maps, settings.uv_map)


def _replace_linked(obj: bpy.types.Object) -> None:
    """Let the materials that only this object shows have its own group in place of a linked one."""
    others = {material for other, _ in maps_modifier.mapped_objects() if other != obj
              for material in materials_of(other)}
    for material in set(filter(use_nodes.keeps_nodes, materials_of(obj))) - others:
        for node in maps_shader.nodes_in(material):
            if not use_nodes.keeps_nodes(node.node_tree):
                node.node_tree = obj.rumple_maps.group


def show(obj: bpy.types.Object) -> None:
    """Add the node group to all materials of the object. At the end, raises UserError for materials that cannot have
    it."""
    settings = obj.rumple_maps
    if settings.group is None:
        settings.group = maps_shader.new_group(obj.name)
    fill(obj)
    _replace_linked(obj)
    materials = materials_of(obj)
    refused = [_cannot_show(obj, material) for material in _left_behind(obj)]
    for material in filter(use_nodes.keeps_nodes, materials):
        try:
            maps_shader.insert(material, settings.group)
        except UserError as error:
            refused.append(str(error))
    if not materials:
        refused.append(f"{obj.name}: it has no material that could show wrinkle maps")
    if refused:
        raise UserError("; ".join(refused))


def hide(obj: bpy.types.Object) -> list[str]:
    """Take this object's node group out of its materials. Returns sentences about those that cannot be changed."""
    refused = []
    for material in materials_of(obj):
        if maps_shader.shown_in(material) != obj.rumple_maps.group or obj.rumple_maps.group is None:
            continue
        if use_nodes.keeps_nodes(material):
            maps_shader.remove(material)
        else:
            refused.append(f"{obj.name}: its material {material.name} is linked from another file and still shows the "
                           "maps: set its slot to Object and choose a local copy of the material there")
    return refused


def notes(obj: bpy.types.Object) -> list[str]:
    """Warnings about linked materials that show other maps than this object has."""
    group = obj.rumple_maps.group
    if group is None or not use_nodes.keeps_nodes(group):
        return []
    return [_cannot_show(obj, material) for material in _left_behind(obj)
            if maps_shader.shown_in(material) is not None]


def _left_behind(obj: bpy.types.Object) -> list[bpy.types.Material]:
    """The materials that cannot be changed and do not show the object's maps."""
    wanted = _shown_by(obj.rumple_maps.group)
    return [material for material in materials_of(obj)
            if not use_nodes.keeps_nodes(material) and _shown_by(maps_shader.shown_in(material)) != wanted]


def _shown_by(group: bpy.types.NodeTree | None) -> Any:
    """What must be equal in two groups that show the same."""
    return group and [(node.bl_idname, getattr(node, "image", None)) for node in group.nodes]


def _cannot_show(obj: bpy.types.Object, material: bpy.types.Material) -> str:
    return (f"{obj.name}: its material {material.name} is linked from another file and cannot show the maps of this "
            "one: set its slot to Object, choose a local copy of the material there, and press Show in Materials")
