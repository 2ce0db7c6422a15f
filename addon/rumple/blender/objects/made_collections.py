# SPDX-License-Identifier: GPL-3.0-or-later
"""Collections that Rumple makes, with the garments that another one is worn over. They are in no scene. So Blender does
not remove deleted objects from them, and does not copy them for a duplicate.

Scripts that move an object to another collection unlink it from all its collections, including these. An artist who
removes a member by hand leaves it in its other collections. This distinguishes the two cases.
"""
from __future__ import annotations

from typing import Iterable, NamedTuple

import bpy

from .. import compat

KEY = "rumple_worn_over"
_ENDING = " Is Worn Over"  # older files do not have the key


def make(garment: bpy.types.Object, members: Iterable[bpy.types.Object]) -> bpy.types.Collection:
    """A new collection for the garments under a garment."""
    made = bpy.data.collections.new(garment.name + _ENDING)
    made[KEY] = True
    for member in members:
        made.objects.link(member)
    return made


def is_ours(collection: bpy.types.Collection) -> bool:
    """Whether Rumple made the collection, and no artist has put it into a scene or into another collection."""
    name, dot, number = collection.name.rpartition(".")
    ends_so = collection.name.endswith(_ENDING) or bool(dot) and number.isdigit() and name.endswith(_ENDING)
    return (KEY in collection or ends_so) and not any(
        compat.holds(parent.children, collection)
        for parent in (*(scene.collection for scene in bpy.data.scenes), *bpy.data.collections))


# ---------------------------------------------------------------- members that were moved
class _Member(NamedTuple):
    """A member when it was last seen."""

    key: int  # compat.session_key(), because another object may get the name
    places: set[str]  # names of its other collections


_seen: dict[int, dict[str, _Member]] = {}  # session key of a collection -> its members, by name


def forget_members() -> None:
    """Called when the state of the file changes: earlier members are no longer valid."""
    _seen.clear()


def lost_members(collection: bpy.types.Collection | None) -> list[bpy.types.Object]:
    """Objects that have left the collection and all their other collections, and are in a new one."""
    known, found = {} if collection is None else _seen.get(compat.session_key(collection), {}), []
    for name in known.keys() - {member.name for member in collection.objects} if known else ():
        obj = bpy.data.objects.get(name)
        if obj is None or compat.session_key(obj) != known[name].key:
            continue
        places = _places(obj)
        if places & known[name].places:
            del known[name]  # removed by hand
        elif places:
            found.append(obj)
    return found


def take_back(collection: bpy.types.Collection | None) -> None:
    """Link lost members to the collection again. Do not call it in handlers."""
    if collection is None:
        return
    if not compat.is_editable(collection) or not is_ours(collection):
        _seen.pop(compat.session_key(collection), None)  # an artist uses it now: forget its former members
        return
    for obj in lost_members(collection):
        collection.objects.link(obj)
    key = compat.session_key(collection)
    on_the_way = {name: member._replace(places=set()) for name, member in _seen.get(key, {}).items()
                  if name in bpy.data.objects and not _places(bpy.data.objects[name])}  # accept any new collection
    _seen[key] = on_the_way | {member.name: _Member(compat.session_key(member), _places(member))
                               for member in collection.objects}


def _places(obj: bpy.types.Object) -> set[str]:
    """The other collections of an object."""
    return {collection.name for collection in obj.users_collection if not is_ours(collection)}
