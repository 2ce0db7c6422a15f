# SPDX-License-Identifier: GPL-3.0-or-later
"""What garments are worn over: which objects these are, and their surfaces in a frame.

The modifier names them too, in inputs that no node reads: for the sake of those Blender evaluates a body before its
garment, also where it is hidden. Without them a hidden body stands at rest, and nothing says so. Everything but
connecting only reads: allowed in any handler.
"""
from __future__ import annotations

import weakref
from typing import Any, Callable, NamedTuple

import bpy
import numpy as np

from ...core import engine, transforms
from ...core.body import Body, digest_of_triangles, is_nearly_closed, joined_rest, side
from .. import compat
from ..nodes import path_curves_tree
from . import (bodies_at_rest, incoming_mesh, made_collections, mesh_reader, messages, modifier, output_mesh,
               posed_coarse, runtimes, units)

Wrinkled = tuple[bpy.types.Object, bpy.types.NodesModifier]


SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")  # types of objects that Blender shows with faces


# ---------------------------------------------------------------- which
def can_be_body(obj: bpy.types.Object) -> bool:
    """What has a surface, is not Rumple's own, and was not deleted."""
    return _is_surface(obj) and not _is_deleted(obj)


def of(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The objects that a garment is worn over, as they are set: the garment itself may be among them."""
    body, collection = obj.rumple.body, obj.rumple.body_collection
    found = [body] if body is not None and can_be_body(body) else []
    if collection is not None:
        found += [member for member in collection.all_objects if member != body and _is_surface(member)
                  and not _is_left_over(member, collection)]
    return found


def _is_left_over(member: bpy.types.Object, collection: bpy.types.Collection) -> bool:
    """Whether it was deleted, or joined to another object, and only a collection of Rumple's still has it."""
    return compat.is_editable(member) and _is_deleted(member) and made_collections.is_ours(collection)


def _is_surface(obj: bpy.types.Object) -> bool:
    groups = (getattr(m, "node_group", None) for m in obj.modifiers)
    return (obj.type in SURFACES and output_mesh.KEY not in obj and not obj.rumple_guide.is_guide
            and not any(path_curves_tree.is_ours(group) for group in groups))


def _is_deleted(obj: bpy.types.Object) -> bool:
    """Whether it was in a collection, other than Rumple's, and is in none: Blender keeps what a garment names. What a
    script has appended, and linked to no collection yet, was in none before."""
    last = bpy.data.collections.get(_found_in.get(obj.name_full, ""))
    collections = (*(scene.collection for scene in bpy.data.scenes), *bpy.data.collections)
    for collection in collections if last is None else (last, *collections):
        if compat.holds(collection.objects, obj) and not made_collections.is_ours(collection):
            _found_in[obj.name_full] = collection.name
            return False
    return obj.name_full in _found_in


# The collection to look into first, by the full name of an object: some files have hundreds. Undo leaves names.
_found_in: dict[str, str] = {}


def refusal(obj: bpy.types.Object) -> str:
    """What is wrong with the bodies that are set, in a sentence; empty when nothing is.

    Where garments are worn over one another in a circle, the last of them by name is refused.
    """
    for body in of(obj):
        if body == obj:
            return f"{obj.name}: it is worn over itself: take it out of its bodies"
        if _leads_to(body, obj):
            return (f"{obj.name}: its body {body.name} is worn over {obj.name} in turn: choose another body for one of "
                    "the two")
    return ""


def _leads_to(body: bpy.types.Object, garment: bpy.types.Object) -> bool:
    """Whether a body is worn over a garment, by way of others before it by name."""
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
    """The same objects, each behind those that it is worn over, else as they were."""
    waiting, ordered = {obj: nodes_mod for obj, nodes_mod in wrinkled}, []

    def take(obj: bpy.types.Object) -> None:
        nodes_mod = waiting.pop(obj, None)
        if nodes_mod is None:
            return
        if not refusal(obj):
            for body in of(obj):
                take(body)
        ordered.append((obj, nodes_mod))

    for obj, _ours in wrinkled:
        take(obj)
    return ordered


def all_under(obj: bpy.types.Object) -> set[bpy.types.Object]:
    """What a garment is worn over or follows by a modifier, and what these are worn over or follow, and so on."""
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
    """What the modifier has to name. Nothing of what is refused: it would be a circle."""
    found = of(obj)
    if not found or refusal(obj):
        return None, None
    return (obj.rumple.body if obj.rumple.body in found else None), obj.rumple.body_collection


def is_connected(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the modifier names the bodies that are set, or cannot."""
    return (not compat.is_editable(obj) or not modifier.can_name_bodies(nodes_mod)
            or modifier.bodies(nodes_mod) == _wanted(obj))


def connect_all() -> None:
    """Let the modifiers name the bodies that are set. Not in handlers."""
    for obj, nodes_mod in list(modifier.wrinkled_objects()):
        body = obj.rumple.body
        if body is not None and compat.is_editable(obj) and _is_deleted(body):
            obj.rumple.body = None  # else what was deleted stays in the file, for it has a user
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
    """While a body is edited its garments stay as they are."""
    return any(mesh_reader.is_busy(body) for body in of(obj))


def read(obj: bpy.types.Object, evaluated: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Body | None:
    """The bodies of a garment as a depsgraph has them; None where it has none. Those without faces are left out, and
    the first of them is named. Raises engine.UserError."""
    found, refused = of(obj), refusal(obj)
    if refused:
        raise engine.UserError(refused)
    if not found:
        messages.note_left_out(runtimes.of(obj), "")
        return None
    if not modifier.can_name_bodies(modifier.find(obj)):
        raise engine.UserError(f"{obj.name}: its node group is linked from a file of an older Rumple: open that file "
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
    joined = _joined_triangles((compat.session_key(obj), depsgraph.mode), surfaces, (runtimes.of(obj).shape, placed),
                               lambda: list(map(bodies_at_rest.of, [obj] * len(shown), shown, surfaces, placed)))
    return Body(np.concatenate([surface.positions for surface in surfaces]), joined.triangles, joined.digest,
                joined.rest)


def _surface(obj: bpy.types.Object, evaluated: bpy.types.Object, body: bpy.types.Object,
             depsgraph: bpy.types.Depsgraph) -> Body | None:
    """One body in the object space of the garment; None where it has no faces. Raises engine.UserError."""
    worn = body.evaluated_get(depsgraph)
    surface = _folded(body, units.frame_of(depsgraph.scene)) or _plain(body, worn, depsgraph)
    if surface is None:
        return None
    if not np.isfinite(surface.positions).all():
        first = int(np.isfinite(surface.positions).all(axis=1).argmin())
        raise engine.UserError(f"{obj.name}: vertex {first} of its body {body.name} has no valid position in this "
                               "frame: repair it, or choose another one")
    into = evaluated.matrix_world.inverted_safe() @ worn.matrix_world
    triangles = surface.triangles
    if into.determinant() < 0.0:  # mirrored: the other way round is counter-clockwise now
        triangles = triangles[:, ::-1]
    matrix = np.array(into, np.float32)
    return Body(np.ascontiguousarray(transforms.placed(matrix, surface.positions)),
                np.ascontiguousarray(triangles))  # the same array, where it was not turned


def _folded(body: bpy.types.Object, frame: float) -> Body | None:
    """A garment that is worn under another one, as it was solved for this frame: it comes first in in_order()."""
    nodes_mod, runtime = modifier.find(body), runtimes.known(body)
    if (nodes_mod is None or runtime is None or runtime.evaluator is None or runtime.message
            or modifier.is_baked(nodes_mod)):
        return None
    if runtime.inputs is None or runtime.inputs.frame != frame:
        return None
    return runtime.evaluator.worn_surface(frame, runtime.inputs.positions)


def _plain(body: bpy.types.Object, worn: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Body | None:
    """A body as Blender shows it; a garment that is not baked without its folds. None where it has no faces. Raises
    engine.UserError."""
    if body.type != "MESH":
        return _converted(body, worn, depsgraph.mode)
    mesh, positions, nodes_mod = worn.data, None, modifier.find(body)
    if nodes_mod is not None and not modifier.is_baked(nodes_mod):
        positions = posed_coarse.positions(body, len(incoming_mesh.of(body).vertices), depsgraph)
        mesh = incoming_mesh.of(body) if positions is not None else mesh
    if not len(mesh.polygons):
        return None
    positions = compat.positions(mesh) if positions is None else positions
    return Body(positions, _triangles(body, mesh, positions, depsgraph.mode))


def _converted(body: bpy.types.Object, worn: bpy.types.Object, mode: str) -> Body | None:
    """A curve, a text or a metaball as Blender shows it. None where it has no faces."""
    mesh = worn.to_mesh()
    try:
        if mesh is None or not len(mesh.polygons):
            return None
        positions = compat.positions(mesh)
        return Body(positions, _triangles(body, mesh, positions, mode))
    finally:
        worn.to_mesh_clear()


# ---------------------------------------------------------------- triangles
ByDepsgraph = tuple[int, str]  # an object and a kind of depsgraph


class _Connections(NamedTuple):
    """What is connected to what."""

    counts: tuple[int, int, int]
    corners: np.ndarray

    @classmethod
    def of(cls, mesh: bpy.types.Mesh) -> "_Connections":
        return cls((len(mesh.vertices), len(mesh.polygons), len(mesh.loops)), compat.corner_vertices(mesh))

    def same_as(self, other: "_Connections") -> bool:
        return self.counts == other.counts and np.array_equal(self.corners, other.corners)


_SOME = 1_000


class _Triangulated(NamedTuple):
    """The triangles of a body."""

    connections: _Connections
    outwards: np.ndarray  # at rest
    some: np.ndarray  # of these, about _SOME, from all over: what mirrors a body turns them all
    mirrored: np.ndarray | None  # all, turned; None where nothing tells a mirrored one from a bent one

    @classmethod
    def of(cls, rest: bpy.types.Mesh, connections: _Connections) -> "_Triangulated":
        found, positions = compat.triangle_vertices(rest), compat.positions(rest)
        faced, may_turn = side(positions, found), is_nearly_closed(positions, found)
        turned = np.ascontiguousarray(found[:, ::-1])
        outwards, inwards = (turned, found) if faced < 0 else (found, turned)
        some = np.ascontiguousarray(outwards[::max(len(outwards) // _SOME, 1)])
        return cls(connections, outwards, some, inwards if faced and may_turn else None)

    def facing_outwards(self, positions: np.ndarray) -> np.ndarray:
        """In a pose. A look at some of them is mostly enough: all take 2 ms of 28,000."""
        if self.mirrored is None or side(positions, self.some) > 0 or side(positions, self.outwards) >= 0:
            return self.outwards
        return self.mirrored


class _Joined(NamedTuple):
    """The triangles of all bodies of a garment, and of what they were made."""

    parts: list[weakref.ref[np.ndarray]]  # an array of a native model keeps that
    first: list[int]
    triangles: np.ndarray
    digest: bytes
    rest: np.ndarray | None  # as Body has it
    rest_of: Any  # what that is made of, beside the triangles


_triangulated: dict[ByDepsgraph, _Triangulated] = {}  # by body
_joined: dict[ByDepsgraph, _Joined] = {}  # by garment


def forget_all() -> None:
    _triangulated.clear()
    _joined.clear()
    _found_in.clear()
    made_collections.forget_members()


def _joined_triangles(key: ByDepsgraph, surfaces: list[Body], rest_of: Any,
                      at_rest: Callable[[], list[np.ndarray | None]]) -> _Joined:
    """The same array as long as those of the bodies are: then nobody has to look whether it is another. at_rest: of
    each; asked anew where rest_of is another."""
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
    """Forget which way an edited body faces: applying a negative scale turns it inside out, and leaves its
    connections. touched: session keys of what an update changed."""
    for body in of(garment):
        if body.type == "MESH" and compat.session_key(body.data) in touched:
            for key in [key for key in _triangulated if key[0] == compat.session_key(body)]:
                del _triangulated[key]


def _triangles(body: bpy.types.Object, mesh: bpy.types.Mesh, positions: np.ndarray, mode: str) -> np.ndarray:
    """(t, 3) int32 vertices, kept as long as the connections stay: how a frame bends a polygon does not count.

    Where modifiers leave the connections alone they are those of the mesh at rest, whichever frame comes first. Those
    of a body that is inside out are turned: at rest, or by what mirrors it in a frame (nodes, a bone).
    """
    key, now = (compat.session_key(body), mode), _Connections.of(mesh)
    kept = _triangulated.get(key)
    if kept is None or not kept.connections.same_as(now):
        meshes = (body.data, incoming_mesh.of(body)) if body.type == "MESH" else ()
        rest = next((known for known in meshes if _Connections.of(known).same_as(now)), mesh)
        kept = _triangulated[key] = _Triangulated.of(rest, now)
    return kept.facing_outwards(positions)
