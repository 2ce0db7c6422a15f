# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's application handlers. They are persistent, call other modules, and never raise."""
from __future__ import annotations

import functools
from typing import Any, Callable

import bpy
from bpy.app.handlers import persistent

from . import render_lock, scheduler
from .frame import baking, clip_status, disk_frames, first_pass, path_curves, rebuild, solve
from .maps import (changes as maps_changes, modifier as maps_modifier, rebuild as maps_rebuild,
                   runtimes as maps_runtimes, solve as maps_solve)
from .objects import (bodies, building, changes, kept_lists, made_collections, messages, modifier, runtimes,
                      undo_references)


_PATIENCE = 30.0  # seconds that a render waits for rebuilds after recent edits

_RUNTIMES = (runtimes, maps_runtimes)


def _forget_all() -> None:
    for table in _RUNTIMES:
        table.forget_all()
    bodies.forget_all()
    clip_status.forget_all()
    building.drop_all()


def _guarded(function: Callable[..., None]) -> Callable[..., None]:
    """A function that prints exceptions on the console instead of raising them."""
    @functools.wraps(function)
    def guarded(*arguments: Any) -> None:
        with messages.console_errors(function.__name__):
            function(*arguments)
    return guarded


def _handler(function: Callable[..., None]) -> Callable[..., None]:
    """A handler that never raises, and stays registered when another file is opened."""
    return persistent(_guarded(function))


@_handler
def _before_frame(scene: bpy.types.Scene, *_arguments: object) -> None:
    changes.before_frame(scene)
    first_pass.hand_on_coarse(scene)


@_handler
def _on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    try:
        _follow(scene, depsgraph)
    finally:
        changes.after_frame()
        first_pass.show_fine(scene)


@_handler
def _on_update(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    _follow(scene, depsgraph)
    if scheduler.in_main_thread() and not scheduler.rendering():
        path_curves.note_deleted(scene)


def _follow(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    kept_lists.forget_all()
    scheduler.note_thread()
    # All updates are read before anything is rebuilt. If a rebuild removes a mesh, the depsgraph still lists its
    # evaluated copy, whose original is then freed memory. The depsgraph of a job reports everything as updated.
    for system in (changes, maps_changes) if scheduler.in_main_thread() else ():
        with messages.console_errors("changes"):
            system.note_updates(depsgraph)
    for system in (solve, maps_solve):
        with messages.console_errors("frame"):
            system.process(scene, depsgraph)


@_handler
def _before_load(*_arguments: object) -> None:
    """While a file is read, handlers are called, but modifiers of the former file no longer exist."""
    scheduler.note_file()
    kept_lists.forget_all()


@_handler
def _on_load(*_arguments: object) -> None:
    """Forget everything about the former file. Structural work is allowed here."""
    scheduler.set_rendering(False)
    kept_lists.forget_all()
    _forget_all()
    baking.end()  # a running bake has ended with its file
    scheduler.sync_all()


@_handler
def _on_save(*_arguments: object) -> None:
    solve.show_fine_meshes()


@_handler
def _after_save(*_arguments: object) -> None:
    disk_frames.on_save()
    clip_status.on_save()


@_handler
def _before_undo(*_arguments: object) -> None:
    kept_lists.forget_all()
    undo_references.clear_references()


@_handler
def _on_undo(*_arguments: object) -> None:
    kept_lists.forget_all()
    undo_references.restore_references()
    made_collections.forget_members()
    for table in _RUNTIMES:
        table.invalidate_all()
    scheduler.request()


@_handler
def _on_render_start(*_arguments: object) -> None:
    # A script may have made changes since the last update, and the timer has not run since. The thread of an F12 job
    # must not rebuild, because the window draws at the same time: it waits until the window's timers have done it, and
    # they are not allowed to after the render has begun. The lock waits for a timer that is still working.
    if not scheduler.in_main_thread():
        scheduler.wait_for_work(_PATIENCE)
    with scheduler.LOCK:
        try:
            if scheduler.in_main_thread():
                scheduler.sync_all()
            kept_lists.forget_all()
            clip_status.check_before_render()
        finally:
            scheduler.set_rendering(True)  # also after an error, because 4.3 crashes without it


@_handler
def _on_render_end(*_arguments: object) -> None:
    """The output objects have the last rendered frame. Restore the window's frame."""
    with scheduler.LOCK:
        scheduler.set_rendering(False)
        for table in _RUNTIMES:
            table.invalidate_outputs()
    modifier.tag_soon(obj for obj, _ours in modifier.wrinkled_objects())
    scheduler.tag_soon(obj for obj, _ours in maps_modifier.mapped_objects())


def _pairs() -> tuple:
    handlers = bpy.app.handlers
    return ((handlers.frame_change_pre, _before_frame), (handlers.frame_change_post, _on_frame),
            (handlers.depsgraph_update_post, _on_update),
            (handlers.load_pre, _before_load), (handlers.load_post, _on_load), (handlers.save_pre, _on_save),
            (handlers.save_post, _after_save),
            (handlers.undo_pre, _before_undo), (handlers.redo_pre, _before_undo),
            (handlers.undo_post, _on_undo), (handlers.redo_post, _on_undo), (handlers.render_init, _on_render_start),
            (handlers.render_complete, _on_render_end), (handlers.render_cancel, _on_render_end))


def register() -> None:
    # The order matters: Maps depend on the other wrinkles.
    scheduler.set_workers(_guarded(rebuild.sync_all), _guarded(maps_rebuild.sync))
    scheduler.set_regular_check(_guarded(render_lock.keep_on))
    for functions, function in _pairs():
        if function not in functions:
            functions.append(function)
    scheduler.look_for_threads()


def unregister() -> None:
    for functions, function in _pairs():
        if function in functions:
            functions.remove(function)
    scheduler.stop()
    disk_frames.stop()
    _forget_all()
