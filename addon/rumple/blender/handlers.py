# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's application handlers: thin, persistent, and they never throw."""
from __future__ import annotations

import threading

import bpy
from bpy.app.handlers import persistent

from . import scheduler
from .frame import clip_status, rebuild, solve
from .maps import modifier as maps_modifier, sync as maps_sync
from .objects import bodies, changes, kept_lists, modifier, runtimes


@persistent
def _on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    _follow(scene, depsgraph)


@persistent
def _on_update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    _follow(scene, depsgraph)


def _follow(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    kept_lists.forget_all()
    # All updates are read before anything is made anew: the depsgraph goes on listing the copy of a mesh that was
    # removed since, and what it is the copy of is freed memory then.
    changes.note_updates(depsgraph)
    maps_sync.note_updates(depsgraph)
    solve.process(scene, depsgraph)
    maps_sync.process(depsgraph)


@persistent
def _on_load(*_arguments: object) -> None:
    """Another file: nothing of the former one counts. Structural work is allowed here."""
    scheduler.set_rendering(False)
    kept_lists.forget_all()
    runtimes.forget_all()
    maps_sync.forget_all()
    bodies.forget_all()
    scheduler.sync_all()


@persistent
def _on_save(*_arguments: object) -> None:
    solve.show_fine_meshes()


@persistent
def _on_undo(*_arguments: object) -> None:
    kept_lists.forget_all()
    runtimes.invalidate_all()
    maps_sync.invalidate_all()
    scheduler.request()


@persistent
def _on_render_start(*_arguments: object) -> None:
    # A script may have changed things since the last update, and the timer had no turn. Not in the thread of an F12
    # job: the window draws meanwhile, and data-blocks must not come and go under it.
    if threading.get_ident() == threading.main_thread().ident:
        scheduler.sync_all()
    kept_lists.forget_all()
    clip_status.check_before_render()
    scheduler.set_rendering(True)


@persistent
def _on_render_end(*_arguments: object) -> None:
    """The output objects hold the last rendered frame: the window needs its own again."""
    with scheduler.LOCK:
        scheduler.set_rendering(False)
        for obj, _ours in modifier.wrinkled_objects():
            runtimes.of(obj).invalidate_output()
        maps_sync.invalidate_output()
    if not bpy.app.background and not bpy.app.timers.is_registered(_tag_all):
        bpy.app.timers.register(_tag_all, first_interval=0.0)


def _tag_all() -> None:
    for obj, _ours in (*modifier.wrinkled_objects(), *maps_modifier.mapped_objects()):
        obj.update_tag()


def _pairs() -> tuple:
    handlers = bpy.app.handlers
    return ((handlers.frame_change_post, _on_frame), (handlers.depsgraph_update_post, _on_update),
            (handlers.load_post, _on_load), (handlers.save_pre, _on_save), (handlers.undo_post, _on_undo),
            (handlers.redo_post, _on_undo), (handlers.render_init, _on_render_start),
            (handlers.render_complete, _on_render_end), (handlers.render_cancel, _on_render_end))


def register() -> None:
    scheduler.set_workers(rebuild.sync_all, maps_sync.sync)  # in this order: Maps look at the wrinkles before them
    for functions, function in _pairs():
        if function not in functions:
            functions.append(function)


def unregister() -> None:
    for functions, function in _pairs():
        if function in functions:
            functions.remove(function)
    if bpy.app.timers.is_registered(_tag_all):
        bpy.app.timers.unregister(_tag_all)
    scheduler.stop()
    maps_sync.forget_all()
    bodies.forget_all()
    runtimes.forget_all()
