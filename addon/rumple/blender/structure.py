# SPDX-License-Identifier: GPL-3.0-or-later
"""Structural work: fine meshes, carriers, duplicates, leftovers.

It makes and removes data-blocks, so it runs outside handlers: from operators, from a timer in the window, and in
background mode directly while nothing renders; also before a render that runs in the main thread, but never in the
thread of an F12 job. live.py asks for it with request().
"""
from __future__ import annotations

import hashlib
import traceback
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Iterator

import bpy
import numpy as np

from .. import native
from ..core import engine
from ..core.settings import FieldSettings
from . import carrier as carriers
from . import bodies, field_curve, field_nodes, mesh_io, modifier, node_tree, properties, registry, versions
from .registry import LOCK, Runtime

CARRIER_KEY = "rumple_carrier"  # custom property on carriers and players: tells leftovers from the artist's objects
SETTLE_SECONDS = 0.25  # an artist who drags a slider or paints gets the rebuilt mesh when the hand rests

_BUSY_MODES = frozenset(("EDIT", "SCULPT"))  # the mesh there is not what the object will be


# ---------------------------------------------------------------- when
_render_running = False
_wanted = False
_half_done = False


def rendering() -> bool:
    return _render_running


def set_rendering(running: bool) -> None:
    global _render_running
    _render_running = running
    if not running and _wanted:
        request()


def allowed_now() -> bool:
    """In background mode there are no timers: structural work is done on the spot unless a render runs."""
    return bpy.app.background and not _render_running


@contextmanager
def half_done() -> Iterator[None]:
    """While an operator changes the stack: 3.4 evaluates, and calls the handlers, in the middle of it."""
    global _half_done
    _half_done = True
    try:
        yield
    finally:
        _half_done = False


def is_half_done() -> bool:
    return _half_done


def request(delay: float = 0.0) -> None:
    """Do the structural work soon. Several requests become one, after the last."""
    global _wanted
    _wanted = True
    if bpy.app.background or _render_running:
        return  # the next handler in background, or the end of the render, sees to it
    timers = bpy.app.timers
    if timers.is_registered(_on_timer):  # not a flag of our own: loading a file kills timers
        if delay == 0.0:
            return
        timers.unregister(_on_timer)
    timers.register(_on_timer, first_interval=delay)


def _on_timer() -> float | None:
    if _render_running:
        return 0.5
    settle_all()
    return None


def stop() -> None:
    """For unregister()."""
    for function in (_on_timer, _tag_due):
        if bpy.app.timers.is_registered(function):
            bpy.app.timers.unregister(function)


_due: set[str] = set()


def tag_dependents(written: list[bpy.types.Object], wrinkled: list[bpy.types.Object]) -> None:
    """Wrinkled objects that lean on a written one saw its last picture: let them be evaluated once more.

    In background and in renders nothing can be tagged in time: they are one solve late there (bake_state.py says so).
    """
    if bpy.app.background or _render_running:
        return
    tag_soon({obj.name for obj in wrinkled if obj.library is None and modifier.leans_on(obj, written)})


def tag_soon(names: set[str]) -> None:
    """Let objects be evaluated once more: from where nothing may be tagged."""
    _due.update(names)
    if _due and not bpy.app.timers.is_registered(_tag_due):
        bpy.app.timers.register(_tag_due, first_interval=0.0)


def _tag_due() -> None:
    names = set(_due)
    _due.clear()
    for name in names:
        if name in bpy.data.objects:
            bpy.data.objects[name].update_tag()


# ---------------------------------------------------------------- everything
def settle_all() -> None:
    """Bring every wrinkled object in order: node groups, shared carriers, stale meshes, leftovers."""
    global _wanted
    _wanted = False
    with LOCK:
        for group in list(bpy.data.node_groups):
            if node_tree.is_ours(group):
                node_tree.upgrade(group)
        objects = list(modifier.wrinkled_objects())
        registry.forget_all_but(obj for obj, _ in objects)
        _split_shared_carriers(objects)
        bodies.connect_all()
        for obj, ours in objects:
            if registry.runtime(obj).stale:
                prepare(obj, ours)
        _tidy_removed({obj.name_full for obj, _ in objects})
        from . import maps_live, path_curves  # they ask this module when structural work is allowed
        path_curves.settle([obj for obj, _ in modifier.wrinkled_objects()])
        maps_live.settle()


def prepare(obj: bpy.types.Object, ours: bpy.types.NodesModifier) -> bool:
    """Make the fine mesh and the carrier what they should be. True when something was rebuilt.

    Never raises: what is wrong becomes the object's message and the last good mesh stays.
    """
    if obj.mode in _BUSY_MODES or obj.data.is_editmode:  # by another object that shares it
        return False
    entry = registry.runtime(obj)
    entry.stale = False
    entry.groups = [group.name for group in obj.vertex_groups]
    try:
        changed = _prepare(obj, ours, entry)
        registry.refuse(entry, entry.bake_note)
        return changed
    except (engine.Refused, native.NativeMissing) as error:
        registry.refuse(entry, str(error))
    except Exception as error:  # a message on the panel, never a traceback
        registry.refuse(entry, unexpected(obj, error))
    return False


def unexpected(obj: bpy.types.Object, error: Exception) -> str:
    """A mistake of ours in one line, with the place for the report."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    file = place.filename.replace("\\", "/").rsplit("/", 1)[-1]
    return f"{obj.name}: unexpected {type(error).__name__} in {file}:{place.lineno}: {error}"


def _prepare(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime) -> bool:
    method = modifier.system(ours).method
    if versions.is_editable(obj) and obj.rumple.method != method:
        obj.rumple.method = method  # the modifier came by Copy Modifiers or an older file
    if modifier.is_baked(ours) and modifier.carrier(ours) is not None:
        from . import bake_state  # it asks this module what clips are made from
        entry.bake_note = bake_state.check(obj, modifier.carrier(ours))
        return False  # the clip counts on the carrier as it is
    entry.bake_note = ""
    if method == "FIELD":
        _settle_profile(obj, entry)
    former = entry.fine
    ensure_fine(obj, entry)
    if entry.fine is not former:
        obj.update_tag()  # the carrier may fit as it is, but nothing is solved by this one
    source = source_of(obj)
    held = modifier.carrier(ours)
    count = len(obj.data.vertices)
    if held is None or held.type != "MESH" or not _is_local(held):
        held = carriers.make(obj, entry.fine, source)
        held[CARRIER_KEY] = True
    elif not carriers.is_embedding_of(held.data, entry.fine):
        carriers.fill(held, obj, entry.fine, source)
    elif not carriers.carry_changes(held, obj, entry.fine, source):
        if modifier.coarse_vertices(ours) == count:
            return False
    modifier.set_carrier(ours, held, count)
    entry.forget_written()
    return True


def _settle_profile(obj: bpy.types.Object, entry: Runtime) -> None:
    """The materials, and the fine mesh, have the profile that is set, or drawn."""
    if obj.rumple.field.profile == "CURVE":
        field_curve.ensure(obj)
        entry.paint = None
        obj.update_tag()
    for material in field_nodes.materials_of(obj):
        field_nodes.set_profile(material, obj)
    field_nodes.drop_orphans()


def note_drawn_profile(obj: bpy.types.Object) -> None:
    """Called by the panel that shows the curve: editing a curve tells nobody."""
    entry = registry.runtime(obj)
    used = entry.paint.get("profile") if entry.paint is not None else None
    if used is not None and not np.array_equal(used, field_curve.heights(obj)):
        entry.stale = True
        request(SETTLE_SECONDS)


def _is_local(held: bpy.types.Object) -> bool:
    return versions.is_editable(held) and versions.is_editable(held.data)


# ---------------------------------------------------------------- the fine mesh
@dataclass
class Sources:
    """What a fine mesh is made from."""

    base: engine.BaseMesh
    own: engine.BaseMesh | None
    attached: np.ndarray | None
    settings: Any  # of the system
    unit_scale: float  # metres per object unit
    shape: str  # fingerprint of all of these


def sources(obj: bpy.types.Object) -> Sources:
    """Read them from the object as it is now. Raises engine.Refused."""
    scene = scene_of(obj)
    settings = properties.settings_of(obj, scene)
    base = mesh_io.base_mesh(obj, settings.rest_shape, obj.rumple.rest_key)
    if isinstance(settings, FieldSettings) and settings.output == "SHADING":
        base.uv = mesh_io.render_uv(obj.data)
    own = _own_mesh(obj, settings)
    attached = mesh_io.attached(obj.rumple.own_mesh) if own is not None else None
    unit_scale = metres_per_unit(obj, scene)
    return Sources(base, own, attached, settings, unit_scale,
                   _shape_fingerprint(base, own, attached, settings, unit_scale))


def ensure_fine(obj: bpy.types.Object, entry: Runtime) -> None:
    """Make entry.fine for the object as it is now. Reads only: allowed in any handler. Raises engine.Refused."""
    now = sources(obj)
    if entry.fine is not None and entry.shape == now.shape:
        return
    if entry.refused == now.shape:
        raise engine.Refused(entry.refusal)
    try:
        entry.fine = _build(obj, now)
    except engine.Refused as error:
        entry.refused = now.shape
        registry.refuse(entry, str(error))
        raise
    entry.shape, entry.refused, entry.paint = now.shape, "", None
    entry.inputs = None  # solved by the former one: who draws by them must wait
    entry.notes = list(entry.fine.warnings)
    if versions.has_custom_normals(obj.data):
        entry.notes.append(f"{obj.name}: custom normals are not carried to the fine mesh")
    entry.fine.history.limit_bytes = obj.rumple.memory_limit << 20


def _build(obj: bpy.types.Object, now: Sources) -> engine.Wrinkles:
    more = dict(own=now.own, attached=now.attached) if now.own is not None else {}
    fine = modifier.system(modifier.find(obj)).wrinkles.build(now.base, now.settings, unit_scale=now.unit_scale, **more)
    coarse = len(now.base.positions)
    if fine.vertex_count < coarse:  # the result could not bring the coarse positions back to us
        raise engine.Refused(f"{obj.name}: the fine mesh has {fine.vertex_count} vertices, fewer than the coarse one "
                             f"({coarse}): choose a denser one")
    return fine


def _own_mesh(obj: bpy.types.Object, settings: Any) -> engine.BaseMesh | None:
    if not _wants_own_mesh(settings):
        return None
    own = obj.rumple.own_mesh
    if own is None or own.type != "MESH":
        raise engine.Refused(f"{obj.name}: choose your own fine mesh first")
    return mesh_io.own_mesh(obj, own)


def source_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The object whose materials, UV maps and attributes the fine mesh inherits."""
    own = obj.rumple.own_mesh
    return own if own is not None and _wants_own_mesh(properties.group_of(obj)) else obj


def _wants_own_mesh(settings: Any) -> bool:
    """settings: of the system, or their properties."""
    return getattr(settings, "source", "") == "OBJECT"


def _shape_fingerprint(base: engine.BaseMesh, own: engine.BaseMesh | None, attached: object, settings: Any,
                       unit_scale: float) -> str:
    digest = hashlib.sha1(mesh_io.shape_fingerprint(base).encode())
    if own is not None:
        digest.update(mesh_io.shape_fingerprint(own).encode())
        digest.update(b"" if attached is None else attached.tobytes())
    digest.update(repr((settings.structural(), f"{unit_scale:.4g}")).encode())
    return digest.hexdigest()


def scene_of(obj: bpy.types.Object) -> bpy.types.Scene:
    """The scene whose units and frames count for an object."""
    return next(iter(obj.users_scene), None) or bpy.context.scene


def metres_per_unit(obj: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """Mean absolute scale of an object times the scene's unit scale.

    From the parents' own transforms, not from matrix_world: that one is not there yet after loading a file.
    """
    matrix, parent = obj.matrix_basis.copy(), obj.parent
    inverse = obj.matrix_parent_inverse
    while parent is not None:
        matrix = parent.matrix_basis @ inverse @ matrix
        inverse, parent = parent.matrix_parent_inverse, parent.parent
    scale = matrix.to_scale()
    return sum(abs(s) for s in scale) / 3.0 * scene.unit_settings.scale_length


# ---------------------------------------------------------------- duplicates and leftovers
def _split_shared_carriers(objects: list[tuple[bpy.types.Object, bpy.types.NodesModifier]]) -> None:
    """Every object needs a local carrier of its own: Shift-D and Alt-D share one, linked ones cannot be written."""
    seen: set[int] = set()
    for obj, ours in objects:
        held = modifier.carrier(ours)
        if held is None or held.type != "MESH":
            registry.runtime(obj).stale = True
            continue
        key = versions.session_key(held)
        if key in seen or not _is_local(held):
            held = carriers.copy_for(obj, held)
            held[CARRIER_KEY] = True
            modifier.set_carrier(ours, held, modifier.coarse_vertices(ours))
            registry.runtime(obj).stale = True
            registry.runtime(obj).forget_written()
        seen.add(versions.session_key(held))


def _tidy_removed(wrinkled: set[str]) -> None:
    """Where the modifier was applied or removed by Blender's own buttons, clean up as our operators do."""
    for obj in bpy.data.objects:
        if obj.type != "MESH" or obj.name_full in wrinkled or not versions.is_editable(obj):
            continue
        if obj.rumple.method != "NONE":
            drop_traces(obj)
    drop_orphan_carriers()
    field_curve.drop_orphans()


def drop_orphan_carriers() -> None:
    """Carriers and players without an object. Asked of the user map: 5.2's count keeps applied modifiers."""
    held = {hidden(ours) for _, ours in modifier.wrinkled_objects() for hidden in (modifier.carrier, modifier.player)}
    candidates = {o for o in bpy.data.objects if CARRIER_KEY in o} - held
    if not candidates:
        return  # the user map looks at the whole file
    for candidate, users in bpy.data.user_map(subset=candidates).items():
        if not users:
            modifier.delete_hidden(candidate)


def drop_traces(obj: bpy.types.Object) -> None:
    """What the wrinkles of an object leave behind when their modifier has gone. Settings and paint stay."""
    if obj.rumple.method == "FIELD":
        field_nodes.unshade_object(obj, [o for o, _ in modifier.wrinkled_objects() if o.rumple.method == "FIELD"])
    obj.rumple.method = "NONE"
    drop_internal_attributes(obj)


def drop_internal_attributes(obj: bpy.types.Object) -> None:
    """Rumple's own attributes on a coarse (or applied) mesh; what is for shaders stays where it was applied."""
    mesh = obj.data
    if not versions.is_editable(mesh) or obj.mode == "EDIT":
        return
    shared = any(other != obj and other.data == mesh for other, _ in modifier.wrinkled_objects())
    internal = (*node_tree.CARRIER_ONLY, node_tree.BASE_POSITION, node_tree.BASE_INDEX, node_tree.REST_POSITION)
    for name in internal:
        if name in mesh.attributes and not shared:
            mesh.attributes.remove(mesh.attributes[name])
