# SPDX-License-Identifier: GPL-3.0-or-later
"""The bodies that garments are worn over: which objects these are, and their surfaces in a frame.

The modifier refers to the bodies too, in inputs that no node reads. Because of these inputs Blender evaluates a body
before its garment, even if the body is hidden. Without them a hidden body would silently stay in its rest pose.
Everything except connecting only reads, so any handler may call it.
"""
from __future__ import annotations

import weakref
from contextlib import contextmanager
from typing import Any, Callable, Iterator, NamedTuple

import bpy
import numpy as np

from ...core.base import transforms
from ...core.base.wording import UserError
from ...core.mesh.body import Body, digest_of_triangles, joined_rest
from .. import compat
from ..nodes import path_curves_tree
from . import (baked_surface, bodies_at_rest, incoming_mesh, made_collections, mesh_reader, messages, modifier,
               output_mesh, posed_coarse, runtimes)
from .body_triangles import Connections, Triangulated

Wrinkled = tuple[bpy.types.Object, bpy.types.NodesModifier]
SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")  # object types that Blender shows with faces


# ---------------------------------------------------------------- which
def can_be_body(obj: bpy.types.Object) -> bool:
    """Whether an object has a surface, is not one of Rumple's hidden objects, and was not deleted."""
    return _is_surface(obj) and not _is_deleted(obj)


def of(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The objects that a garment is worn over, according to its settings. The garment itself may be among them."""
    body, collection = obj.rumple.body, obj.rumple.body_collection
    found = [body] if body is not None and can_be_body(body) else []
    if collection is not None:
        found += [member for member in collection.all_objects if member != body and _is_surface(member)
                  and not _is_left_over(member, collection)]
    return found


def _is_left_over(member: bpy.types.Object, collection: bpy.types.Collection) -> bool:
    """Whether an object was deleted or joined to another one, and is only left in a collection made by Rumple."""
    return compat.is_editable(member) and _is_deleted(member) and made_collections.is_ours(collection)


def _is_surface(obj: bpy.types.Object) -> bool:
    groups = (getattr(m, "node_group", None) for m in obj.modifiers)
    return (obj.type in SURFACES and output_mesh.KEY not in obj and not obj.rumple_guide.is_guide
            and not any(path_curves_tree.is_ours(group) for group in groups))


def _is_deleted(obj: bpy.types.Object) -> bool:
    """Whether an object was in a collection not made by Rumple, and is in none now. Blender keeps a deleted object that
    a garment refers to. An object that a script has appended but not yet linked to a collection does not count as
    deleted."""
    last = bpy.data.collections.get(_found_in.get(obj.name_full, ""))
    collections = (*(scene.collection for scene in bpy.data.scenes), *bpy.data.collections)
    for collection in collections if last is None else (last, *collections):
        if compat.holds(collection.objects, obj) and not made_collections.is_ours(collection):
            _found_in[obj.name_full] = collection.name
            return False
    return obj.name_full in _found_in


# Full name of an object -> the collection to search first, because some files have hundreds of collections. It stores
# names, because undo keeps them.
_found_in: dict[str, str] = {}


def refusal(obj: bpy.types.Object) -> str:
    """An error message about the chosen bodies; empty if they are valid.

    If garments are worn over one another in a circle, the last of them by name is refused.
    """
    for body in of(obj):
        if body == obj:
            return f"{obj.name}: it is worn over itself: take it out of its bodies"
        if _leads_to(body, obj):
            return (f"{obj.name}: its body {body.name} is worn over {obj.name} in turn: choose another body for one of "
                    "the two")
    return ""


def _leads_to(body: bpy.types.Object, garment: bpy.types.Object) -> bool:
    """Whether a body is worn over a garment, directly or through garments that are earlier by name."""
    todo, seen = [body], set()
    while todo:
        at = todo.pop()
        if at == garment:
            return True
        if at not in seen and at.name_full < garment.name_full and modifier.find(at) is not None:
            seen.add(at)
            todo += of(at)
    return False


def in_order(wrinkled: list[Wrinkled]) -> list[Wrinkled]:
    """The same objects, each one after those that it is worn over, otherwise in the same order."""
    modifiers = dict(wrinkled)
    return [(obj, modifiers[obj]) for obj in _levels(wrinkled)]


def in_levels(wrinkled: list[Wrinkled]) -> list[list[Wrinkled]]:
    """The same objects in groups, each one worn over objects of earlier groups only. In a group the order is that of
    in_order()."""
    modifiers, levels = dict(wrinkled), _levels(wrinkled)
    groups: list[list[Wrinkled]] = [[] for _ in range(1 + max(levels.values(), default=-1))]
    for obj, level in levels.items():
        groups[level].append((obj, modifiers[obj]))
    return groups


def _levels(wrinkled: list[Wrinkled]) -> dict[bpy.types.Object, int]:
    """0 for an object that is worn over none of the others, else one more than the highest of those under it. Each
    object comes after those that it is worn over."""
    waiting, levels = {obj for obj, _ours in wrinkled}, {}

    def take(obj: bpy.types.Object) -> int:
        if obj in waiting:
            waiting.remove(obj)
            under = [] if refusal(obj) else of(obj)
            levels[obj] = 1 + max((take(body) for body in under), default=-1)
        return levels.get(obj, -1)

    for obj, _ours in wrinkled:
        take(obj)
    return levels


def all_under(obj: bpy.types.Object) -> set[bpy.types.Object]:
    """All objects that a garment is worn over or follows by a modifier, also indirectly."""
    todo, found = [obj], {obj}
    while todo:
        one = todo.pop()
        followed = modifier.depends_on_wrinkled(one)
        below = {*of(one), *([] if followed is None else [followed])} if modifier.find(one) is not None else set()
        todo += below - found
        found |= below
    return found - {obj}


# ---------------------------------------------------------------- the dependency graph
def _wanted(obj: bpy.types.Object) -> tuple[bpy.types.Object | None, bpy.types.Collection | None]:
    """The body and the collection for the modifier. None if the bodies are refused, because they would make a
    circle."""
    found = of(obj)
    if not found or refusal(obj):
        return None, None
    return (obj.rumple.body if obj.rumple.body in found else None), obj.rumple.body_collection


def is_connected(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the modifier refers to the chosen bodies, or cannot."""
    return (not compat.is_editable(obj) or not modifier.can_name_bodies(nodes_mod)
            or modifier.bodies(nodes_mod) == _wanted(obj))


def connect_all() -> None:
    """Let the modifiers refer to the chosen bodies. Do not call it in handlers."""
    for obj, nodes_mod in list(modifier.wrinkled_objects()):
        body = obj.rumple.body
        if body is not None and compat.is_editable(obj) and _is_deleted(body):
            obj.rumple.body = None  # otherwise this reference keeps the deleted object in the file
        if obj.rumple.looks_again and of(obj) and compat.is_editable(obj):
            obj.rumple.looks_again = False
        _drop_left_overs(obj.rumple.body_collection)
        made_collections.take_back(obj.rumple.body_collection)
        if not is_connected(obj, nodes_mod):
            modifier.set_bodies(nodes_mod, *_wanted(obj))


def _drop_left_overs(collection: bpy.types.Collection | None) -> None:
    if collection is None or not compat.is_editable(collection) or collection.override_library is not None:
        return
    for member in [member for member in collection.objects if _is_left_over(member, collection)]:
        collection.objects.unlink(member)


# ---------------------------------------------------------------- a frame
def are_busy(obj: bpy.types.Object) -> bool:
    """Whether a body is being edited. Its garments do not change meanwhile."""
    return any(mesh_reader.is_busy(body) for body in of(obj))


def read(obj: bpy.types.Object, evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Body | None:
    """The bodies of a garment in a depsgraph; None if it has none. Bodies without faces are left out, with a message
    about the first of them. Raises UserError."""
    found, refused = of(obj), refusal(obj)
    if refused:
        raise UserError(refused)
    if not found:
        messages.note_left_out(runtimes.of(obj), "")
        return None
    if not modifier.can_name_bodies(modifier.find(obj)):
        raise UserError(f"{obj.name}: its node group is linked from a file of an older Rumple: open that file "
                        "and save it, or take the body away")
    read_now = [(body, _surface(obj, evaluated, body, depsgraph)) for body in found]
    surfaces = [surface for _, surface in read_now if surface is not None]
    empty = next((body for body, surface in read_now
                  if surface is None and (body.type == "MESH" or body == obj.rumple.body)), None)
    messages.note_left_out(runtimes.of(obj), "" if empty is None else (
        f"{obj.name}: its body {empty.name} has no faces and is left out: choose another one, or add Realize Instances "
        "to its nodes"))
    if not surfaces:
        return None
    shown = [body for body, surface in read_now if surface is not None]
    placed = [bodies_at_rest.placing(obj, body) for body in shown]
    rest_of = runtimes.of(obj).build.shape, placed
    joined = _joined_triangles((compat.session_key(obj), depsgraph.mode), surfaces, rest_of,
                               lambda: list(map(bodies_at_rest.of, [obj] * len(shown), shown, surfaces, placed)))
    return Body(np.concatenate([surface.positions for surface in surfaces]), joined.triangles, joined.digest,
                joined.rest)


def _surface(obj: bpy.types.Object, evaluated: bpy.types.Object, body: bpy.types.Object,
             depsgraph: bpy.types.Depsgraph) -> Body | None:
    """One body in the object space of the garment; None if it has no faces. Raises UserError."""
    worn = body.evaluated_get(depsgraph)
    surface = _folded(body) or _plain_once(body, worn, depsgraph)
    if surface is None:
        return None
    if not np.isfinite(surface.positions).all():
        first = int(np.isfinite(surface.positions).all(axis=1).argmin())
        raise UserError(f"{obj.name}: vertex {first} of its body {body.name} has no valid position in this "
                        "frame: repair it, or choose another one")
    if worn.matrix_world == evaluated.matrix_world:
        return surface
    into = evaluated.matrix_world.inverted_safe() @ worn.matrix_world
    triangles = surface.triangles
    if into.determinant() < 0.0:  # mirrored: reverse the triangles to keep them counter-clockwise
        triangles = _reversed((compat.session_key(body), depsgraph.mode), triangles)
    return Body(np.ascontiguousarray(transforms.placed(np.array(into, np.float32), surface.positions)), triangles)


def _folded(body: bpy.types.Object) -> Body | None:
    """The solved surface in this frame of a garment that is worn under another one. It is solved first: see
    in_levels()."""
    runtime = runtimes.known(body)
    if runtime is None or runtime.current is None or modifier.find(body) is None:
        return None
    now = runtime.current
    return runtime.evaluator.worn_surface(now.frame, now.positions, now.settings)


_read_now: dict[int, Body | None] | None = None  # by session key; None: outside of read_once()


@contextmanager
def read_once() -> Iterator[None]:
    """Inside this context bodies that are no garments of this frame are read once, for all garments that are worn over
    them. Nothing may be evaluated in it."""
    global _read_now
    _read_now = {}
    try:
        yield
    finally:
        _read_now = None


def _plain_once(body: bpy.types.Object, worn: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Body | None:
    if _read_now is None:
        return _plain(body, worn, depsgraph)
    key = compat.session_key(body)
    if key not in _read_now:
        _read_now[key] = _plain(body, worn, depsgraph)
    return _read_now[key]


def _plain(body: bpy.types.Object, worn: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Body | None:
    """A body as Blender shows it; of a garment that shows no clip, the surface without folds. None if it has no faces.
    Raises UserError."""
    if body.type != "MESH":
        return _converted(body, worn, depsgraph.mode)
    mesh, positions, nodes_mod = worn.data, None, modifier.find(body)
    if nodes_mod is not None and modifier.plays_clip(nodes_mod):
        mesh, positions = baked_surface.of(body, nodes_mod, depsgraph) or (mesh, None)
    elif nodes_mod is not None:
        positions = posed_coarse.positions(body, len(incoming_mesh.of(body).vertices), depsgraph)
        mesh = incoming_mesh.of(body) if positions is not None else mesh
    if not len(mesh.polygons):
        return None
    positions = compat.positions(mesh) if positions is None else positions
    return Body(positions, _triangles(body, mesh, positions, depsgraph.mode))


def _converted(body: bpy.types.Object, worn: bpy.types.Object, mode: str) -> Body | None:
    """A curve, a text or a metaball as Blender shows it. None if it has no faces."""
    mesh = worn.to_mesh()
    try:
        if mesh is None or not len(mesh.polygons):
            return None
        positions = compat.positions(mesh)
        return Body(positions, _triangles(body, mesh, positions, mode))
    finally:
        worn.to_mesh_clear()


# ---------------------------------------------------------------- triangles
ByDepsgraph = tuple[int, str]  # session key of an object, and depsgraph.mode


class _Joined(NamedTuple):
    """The triangles of all bodies of a garment, and the values that they depend on."""

    parts: list[weakref.ref[np.ndarray]]  # weak, because a native model keeps its array alive
    first: list[int]
    triangles: np.ndarray
    digest: bytes
    rest: np.ndarray | None  # as Body.rest
    rest_of: Any  # the values that `rest` depends on, beside the triangles


_triangulated: dict[ByDepsgraph, Triangulated] = {}  # by body
_turned: dict[ByDepsgraph, tuple[weakref.ref[np.ndarray], np.ndarray]] = {}  # by body: triangles, and reversed
_joined: dict[ByDepsgraph, _Joined] = {}  # by garment
_TABLES: tuple[dict[ByDepsgraph, Any], ...] = (_triangulated, _turned, _joined)


def forget_all() -> None:
    for table in _TABLES:
        table.clear()
    _found_in.clear()
    made_collections.forget_members()


def forget_removed() -> None:
    """Forget what is stored about objects that are gone."""
    there = {compat.session_key(obj) for obj in bpy.data.objects}
    for table in _TABLES:
        for key in [key for key in table if key[0] not in there]:
            del table[key]


def _reversed(body: ByDepsgraph, triangles: np.ndarray) -> np.ndarray:
    """The reversed triangles of a body: the same array as long as the given one is the same."""
    kept = _turned.get(body)
    if kept is None or kept[0]() is not triangles:
        kept = _turned[body] = weakref.ref(triangles), np.ascontiguousarray(triangles[:, ::-1])
    return kept[1]


def _joined_triangles(key: ByDepsgraph, surfaces: list[Body], rest_of: Any,
                      at_rest: Callable[[], list[np.ndarray | None]]) -> _Joined:
    """The joined triangles. The same array is returned as long as the arrays of the bodies are the same, so that nobody
    has to compare them. at_rest: returns the rest positions of each body; it is called again if rest_of has changed."""
    parts = [surface.triangles for surface in surfaces]
    first = np.cumsum([0] + [len(surface.positions) for surface in surfaces[:-1]], dtype=np.int32)
    kept = _joined.get(key)
    if (kept is None or kept.first != first.tolist() or len(kept.parts) != len(parts)
            or kept.rest_of != rest_of or any(ref() is not part for ref, part in zip(kept.parts, parts))):
        triangles = np.concatenate([part + at for part, at in zip(parts, first)])
        rest = joined_rest([(len(surface.positions), known) for surface, known in zip(surfaces, at_rest())])
        kept = _joined[key] = _Joined([weakref.ref(part) for part in parts], first.tolist(), triangles,
                                      digest_of_triangles(triangles, rest), rest, rest_of)
    return kept


def note_updates(garment: bpy.types.Object, touched: set[int]) -> None:
    """Forget the orientation of an edited body: applying a negative scale turns it inside out, but does not change its
    connectivity. touched: session keys of the data that an update changed."""
    for body in of(garment):
        if body.type == "MESH" and compat.session_key(body.data) in touched:
            for key in [key for key in _triangulated if key[0] == compat.session_key(body)]:
                del _triangulated[key]


def _triangles(body: bpy.types.Object, mesh: bpy.types.Mesh, positions: np.ndarray, mode: str) -> np.ndarray:
    """(t, 3) int32 vertices. They are kept as long as the connectivity is the same, so that they do not depend on how a
    frame bends polygons.

    If modifiers do not change the connectivity, the mesh at rest is triangulated, so the result does not depend on the
    first frame. The triangles of an inside-out body are reversed, whether it is so at rest or is mirrored in a frame
    (by nodes or a bone).
    """
    key, now = (compat.session_key(body), mode), Connections.of(mesh)
    kept = _triangulated.get(key)
    if kept is None or not kept.connections.same_as(now):
        meshes = (body.data, incoming_mesh.of(body)) if body.type == "MESH" else ()
        rest = next((known for known in meshes if Connections.of(known).same_as(now)), mesh)
        kept = _triangulated[key] = Triangulated.of(rest, now)
    return kept.facing_outwards(positions)
