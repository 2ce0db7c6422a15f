# SPDX-License-Identifier: GPL-3.0-or-later
"""Duplicates of a character. Blender redirects pointers between the duplicated objects, but not the members of Rumple's
collections. Without this module the copy of a shirt would be worn over the trousers of the first character."""
from __future__ import annotations

import bpy

from .. import compat
from . import made_collections, units
from .bodies_at_rest import armatures


def split_worn_over(garments: list[bpy.types.Object]) -> None:
    """Give each garment its own collection, with the objects that move with it. Do not call it in handlers."""
    sharing: dict[int, list[bpy.types.Object]] = {}
    for garment in garments:
        collection = garment.rumple.body_collection
        if collection is not None and compat.is_editable(garment) and made_collections.is_ours(collection):
            sharing.setdefault(compat.session_key(collection), []).append(garment)
    for several in sharing.values():
        if len(several) > 1:
            _split(several)


def _split(garments: list[bpy.types.Object]) -> None:
    """The garment that the collection was made for keeps it."""
    collection = garments[0].rumple.body_collection
    members = list(collection.objects)
    wanted = {garment: [_counterpart(member, garment) for member in members] for garment in garments}
    keeper = next((garment for garment in garments if wanted[garment] == members), garments[0])
    for garment in garments:
        if garment != keeper:
            garment.rumple.body_collection = made_collections.make(garment, dict.fromkeys(wanted[garment]))


def _counterpart(member: bpy.types.Object, garment: bpy.types.Object) -> bpy.types.Object:
    """The object that follows the armature of a garment and has the same mesh as a member, or the same name except for
    the number. The member itself if it follows this armature, or if no other object fits."""
    rigs = armatures(garment)
    if not rigs or rigs & armatures(member):
        return member
    alike = [other for other in units.scene_of(garment).objects
             if other != garment and (other.data == member.data or _stem(other) == _stem(member))
             and rigs & armatures(other)]
    return min(alike, key=lambda other: (_stem(other) != _stem(member), other.data != member.data), default=member)


def _stem(obj: bpy.types.Object) -> str:
    """The name of an object without the number that Blender appends to duplicates."""
    name, _, number = obj.name.rpartition(".")
    return name if name and len(number) >= 3 and number.isdigit() else obj.name
