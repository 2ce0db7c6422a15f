# SPDX-License-Identifier: GPL-3.0-or-later
"""Collections that Rumple makes: the garments that another one is worn over. They are in no scene, so Blender neither
takes out of them what is deleted, nor gives a duplicate one of its own."""
from __future__ import annotations

from typing import Iterable

import bpy

from .. import compat

KEY = "rumple_worn_over"
_ENDING = " Is Worn Over"  # older files have no key


def make(garment: bpy.types.Object, members: Iterable[bpy.types.Object]) -> bpy.types.Collection:
    """A new one for what a garment is worn over."""
    made = bpy.data.collections.new(garment.name + _ENDING)
    made[KEY] = True
    for member in members:
        made.objects.link(member)
    return made


def is_ours(collection: bpy.types.Collection) -> bool:
    """Whether Rumple made it and no artist took it into a scene, or into another collection."""
    name, dot, number = collection.name.rpartition(".")
    ends_so = collection.name.endswith(_ENDING) or bool(dot) and number.isdigit() and name.endswith(_ENDING)
    return (KEY in collection or ends_so) and not any(
        compat.holds(parent.children, collection)
        for parent in (*(scene.collection for scene in bpy.data.scenes), *bpy.data.collections))
