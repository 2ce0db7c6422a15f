# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks data that must be read, solved or rebuilt after a change. Frames and the scheduler do the work."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.systems.all_systems import SYSTEMS
from .. import compat, scheduler
from ..nodes import field_profile, wrinkle_tree
from ..scheduler import LOCK
from . import (bodies, guide_curves, held_by_others, incoming_mesh, made_collections, modifier, output_mesh,
               rest_position, runtimes)


def settings_changed(obj: bpy.types.Object, affects: str, structural: bool) -> None:
    """Called by every property. Marks the necessary work; the scheduler and the next update do it.

    affects: see core/settings/setting.py. structural: the fine mesh may change.
    """
    if obj.rumple.method == "NONE" or modifier.find(obj) is None:
        return
    runtime = runtimes.of(obj)
    if runtime.evaluator is not None:
        runtime.evaluator.frame_cache.limit_bytes = obj.rumple.memory_limit << 20
    if affects == "PAINT":
        runtime.paint.forget()
    if affects == "BODY":
        bodies.connect_all()  # of all objects: one that was refused because of this one may be valid now
    if structural or modifier.is_baked(modifier.find(obj)):
        runtime.build.stop()
        runtime.stale = True
        scheduler.request(scheduler.DELAY)
    _look_at_clips_over(obj)
    obj.update_tag()


def _look_at_clips_over(obj: bpy.types.Object) -> None:
    """Garments that are worn over a changed one may have clips of its former folds: let these be checked."""
    for other, nodes_mod in modifier.wrinkled_objects():
        if modifier.is_baked(nodes_mod) and obj in bodies.all_under(other):
            runtimes.of(other).stale = True
            scheduler.request(scheduler.DELAY)


# ---------------------------------------------------------------- what an update touched
_animation_alone = False  # during the evaluation of a frame: whether no vertex group was edited before it
_converted = False  # see take_converted()
_missed = False  # whether an update was not looked at since the last frame that was


def before_frame(scene: bpy.types.Scene) -> None:
    """Called before a frame is evaluated. Its updates list an object that is animated like one whose vertex groups were
    edited. But an edit has already tagged a mesh now."""
    global _animation_alone
    graphs = [layer.depsgraph for layer in scene.view_layers]
    _animation_alone = not _missed and not any(graph is not None and graph.id_type_updated("MESH") for graph in graphs)


def after_frame() -> None:
    """Called after the evaluation that before_frame() announced, and what follows it."""
    global _animation_alone, _missed
    _animation_alone = False
    _missed = _missed and _ignores_updates()


def _ignores_updates() -> bool:
    return scheduler.rendering() or scheduler.is_suspended()


def note_updates(depsgraph: bpy.types.Depsgraph) -> None:
    """Mark data that must be read again: painted groups, edited meshes, own meshes, materials."""
    global _missed
    if _ignores_updates():
        _missed = True
        return
    _note_moved()
    _note_converted(depsgraph)
    _note_shown_outputs(depsgraph)
    touched = _touched_ids(depsgraph)
    if not touched:
        return
    with LOCK:
        for obj, ours in modifier.wrinkled_objects():
            runtime = runtimes.known(obj)
            if runtime is None:
                continue
            held_by_others.note_updates(obj, runtime)
            if not scheduler.playing():
                guide_curves.note_updates(obj, touched)
            bodies.note_updates(obj, touched)
            own = obj.rumple.own_mesh
            edited = compat.session_key(obj.data) in touched
            edited = edited or _restacked(obj, runtime, touched)
            edited = edited or (compat.session_key(obj) in touched and rest_position.is_outdated(obj, ours))
            if edited or (own is not None and own.data is not None and compat.session_key(own.data) in touched):
                runtime.stale = True
                runtime.paint.forget()
                _look_at_clips_over(obj)
                scheduler.request(scheduler.DELAY)  # once per stroke, at its end: frames follow the brush
            elif runtime.paint.values and compat.session_key(obj) in touched and not scheduler.playing():
                runtime.paint.values = None
                if not _animation_alone:
                    runtime.paint.forget()  # an edit of vertex groups may list only the object, as animation does


def take_converted() -> bool:
    """Whether an object was converted to a mesh since the last call: what its wrinkles left on it must be removed."""
    global _converted
    found, _converted = _converted, False
    return found


def _note_converted(depsgraph: bpy.types.Depsgraph) -> None:
    """Object > Convert to Mesh, and Blender's own Apply, remove the modifier. The object's method stays as it was."""
    global _converted
    for update in depsgraph.updates:
        if update.is_updated_geometry and isinstance(update.id, bpy.types.Object):
            obj = update.id.original
            if (obj.type == "MESH" and obj.rumple.method in SYSTEMS and modifier.find(obj) is None
                    and wrinkle_tree.BASE_POSITION in obj.data.attributes and compat.is_editable(obj)):
                _converted = True
                scheduler.request()


def _note_shown_outputs(depsgraph: bpy.types.Depsgraph) -> None:
    """Output objects are in no scene, but Blender may have linked one to it: see rebuild.drop_orphan_outputs()."""
    for update in depsgraph.updates:
        if isinstance(update.id, bpy.types.Object) and output_mesh.KEY in update.id:
            output = update.id.original
            if output.users_collection and compat.is_editable(output):
                scheduler.request()


def _note_moved() -> None:
    """The bodies of a garment may have left the collection that Rumple keeps them in."""
    for obj, _ours in modifier.wrinkled_objects():
        if made_collections.lost_members(obj.rumple.body_collection):
            runtimes.of(obj).stale = True
            scheduler.request()


def _restacked(obj: bpy.types.Object, runtime: runtimes.Runtime, touched: set[int]) -> bool:
    """Whether the topology-changing modifiers in front were changed."""
    return (not incoming_mesh.is_own(obj) and compat.session_key(obj) in touched and not scheduler.playing()
            and runtime.seen.stack != incoming_mesh.stack_fingerprint(obj))


_WATCHED = (bpy.types.Mesh, bpy.types.Object, bpy.types.Key, bpy.types.Curve)


def _is_moved_curve(update: bpy.types.DepsgraphUpdate) -> bool:
    return update.is_updated_transform and isinstance(update.id, bpy.types.Object) and update.id.type == "CURVE"


def _touched_ids(depsgraph: bpy.types.Depsgraph) -> set[int]:
    """Session keys of the original objects, meshes and curves whose geometry changed, and of curves that moved."""
    keys = set()
    for update in depsgraph.updates:
        if isinstance(update.id, _WATCHED) and (update.is_updated_geometry or _is_moved_curve(update)):
            original = update.id.original
            keys.add(compat.session_key(original.user if isinstance(original, bpy.types.Key) else original))
    return keys


def note_drawn_profile(obj: bpy.types.Object) -> None:
    """Called by the panel that shows the curve, because Blender does not report edits of curves."""
    runtime = runtimes.of(obj)
    used = runtime.paint.values.get("profile") if runtime.paint.values is not None else None
    if used is not None and not np.array_equal(used, field_profile.heights(obj)):
        runtime.stale = True
        scheduler.request(scheduler.DELAY)
