# SPDX-License-Identifier: GPL-3.0-or-later
"""Collections that Rumple makes: the garments that another one is worn over. They are in no scene, so Blender neither
takes out of them what is deleted, nor gives a duplicate one of its own.

Scripts that move an object to another collection unlink it from all that it is in, and these are among them. Who takes
a member out of one by hand leaves it where else it was: so the two can be told apart.
"""
from __future__ import annotations

from typing import Iterable, NamedTuple

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


# ---------------------------------------------------------------- members that were moved
class _Member(NamedTuple):
    """As it was seen last."""

    key: int  # compat.session_key(): another object may have its name
    places: set[str]  # names of the other collections that it was in


_seen: dict[int, dict[str, _Member]] = {}  # by the session key of a collection: its members, by name


def forget_members() -> None:
    """Another state of the file: what was seen before does not count."""
    _seen.clear()


def lost_members(collection: bpy.types.Collection | None) -> list[bpy.types.Object]:
    """What is no longer in it, nor in any of the other collections that it was in, but in another one."""
    known, found = {} if collection is None else _seen.get(compat.session_key(collection), {}), []
    for name in known.keys() - {member.name for member in collection.objects} if known else ():
        obj = bpy.data.objects.get(name)
        if obj is None or compat.session_key(obj) != known[name].key:
            continue
        places = _places(obj)
        if places & known[name].places:
            del known[name]  # by hand
        elif places:
            found.append(obj)
    return found


def take_back(collection: bpy.types.Collection | None) -> None:
    """Let it have its lost members again. Not in handlers."""
    if collection is None:
        return
    if not compat.is_editable(collection) or not is_ours(collection):
        _seen.pop(compat.session_key(collection), None)  # an artist took it over: what it had does not count any more
        return
    for obj in lost_members(collection):
        collection.objects.link(obj)
    key = compat.session_key(collection)
    on_the_way = {name: member._replace(places=set()) for name, member in _seen.get(key, {}).items()
                  if name in bpy.data.objects and not _places(bpy.data.objects[name])}  # whichever it comes to
    _seen[key] = on_the_way | {member.name: _Member(compat.session_key(member), _places(member))
                               for member in collection.objects}


def _places(obj: bpy.types.Object) -> set[str]:
    """The other collections that it is in."""
    return {collection.name for collection in obj.users_collection if not is_ours(collection)}
