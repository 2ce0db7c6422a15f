# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored frames on disk (core/files/kept_frames.py): the folder, and when they are written.

They are never written during a frame. They are written when a file is saved, and in a window in small batches while
nothing is played, moved or rendered. They are read if a requested frame is not in memory.
"""
from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Iterator

import bpy

from ...core.files.kept_frames import KeptFrames
from .. import scheduler
from ..objects import clip_place, messages, modifier, runtimes
from ..objects.evaluator import solved_alike
from ..objects.runtimes import Runtime

SUFFIX = ".frames"
_IDLE = 2.0  # seconds without a new frame before writing starts
_AT_ONCE, _BETWEEN = 0.02, 0.2  # seconds of writing, and of the pause after it
_AT_SAVE = 2.0  # seconds in a window; the rest is written later

_due = 0.0
_told: set[str] = set()


def of(obj: bpy.types.Object) -> KeptFrames | None:
    """The stored frames that an object currently reads."""
    runtime = runtimes.known(obj)
    kept = None if runtime is None or runtime.evaluator is None else runtime.evaluator.frame_cache.on_disk
    return kept if isinstance(kept, KeptFrames) else None


def follow(obj: bpy.types.Object, runtime: Runtime) -> None:
    """Called before a frame is solved: use the object's current folder, if it stores frames. Does not access the
    disk."""
    evaluator = runtime.evaluator
    if evaluator is None:
        return
    folder = _folder(obj) if obj.rumple.keep_frames else None
    if folder is None:
        evaluator.frame_cache.on_disk = None
        return
    kept, identity = evaluator.frame_cache.on_disk, repr(solved_alike(runtime.build.shape))
    if not isinstance(kept, KeptFrames) or (kept.folder, kept.about) != (folder, identity):
        kept = evaluator.frame_cache.on_disk = KeptFrames(evaluator, folder, identity, 0)
    kept.limit_bytes = obj.rumple.disk_limit << 20
    _request()


def _folder(obj: bpy.types.Object) -> Path | None:
    clip = clip_place.of(obj)
    return None if clip is None else clip.with_suffix(SUFFIX)


def _all() -> Iterator[KeptFrames]:
    for obj, _nodes_mod in modifier.wrinkled_objects():
        kept = of(obj)
        if kept is not None:
            yield kept


# ---------------------------------------------------------------- writing
def _write(seconds: float) -> bool:
    """Write for about this time, but at least one frame of each object. Returns whether there are more."""
    ends, more = time.monotonic() + seconds, False
    for kept in _all():
        more = kept.write(max(ends - time.monotonic(), 0.0)) or more
        if kept.note and kept.note not in _told:
            _told.add(kept.note)
            print(f"Rumple: {kept.note}")
            scheduler.redraw_panels_soon()
    return more


def on_save() -> None:
    """Called after the file was saved, perhaps under another name."""
    with scheduler.LOCK:
        for obj, _nodes_mod in modifier.wrinkled_objects():
            runtime = runtimes.known(obj)
            if runtime is not None:
                follow(obj, runtime)
        _write(math.inf if bpy.app.background else _AT_SAVE)


def clear(obj: bpy.types.Object) -> None:
    """Remove the stored frames of an object."""
    kept = of(obj)
    if kept is not None:
        kept.clear()


def _request() -> None:
    global _due
    _due = time.monotonic() + _IDLE
    if bpy.app.background or not scheduler.in_main_thread() or bpy.app.timers.is_registered(_on_timer):
        return  # only the main thread can start timers: its next frame does
    bpy.app.timers.register(_on_timer, first_interval=_IDLE)


def _on_timer() -> float | None:
    left = _due - time.monotonic()
    if left > 0.0:
        return left
    if scheduler.rendering() or bpy.app.is_job_running("RENDER") or scheduler.playing():
        return _IDLE
    more = False
    with messages.console_errors("stored frames"):
        if not scheduler.LOCK.acquire(blocking=False):
            return _BETWEEN
        try:
            more = _write(_AT_ONCE)
        finally:
            scheduler.LOCK.release()
    return _BETWEEN if more else None


def stop() -> None:
    """Called by unregister()."""
    if bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.unregister(_on_timer)
