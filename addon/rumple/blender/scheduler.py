# SPDX-License-Identifier: GPL-3.0-or-later
"""When structural work is done: data-blocks are made and removed outside of handlers only.

In a window a timer does it. In background mode there are no timers: the next handler does it on the spot, unless a
render runs. While an operator changes the modifier stack nothing is done at all. What is done are the workers, which
handlers.py names when the add-on registers.
"""
from __future__ import annotations

import math
import threading
import time
from contextlib import contextmanager
from typing import Callable, Iterator, Protocol

import bpy

# Handlers run in the render job's thread while the window's thread draws: one at a time. Never "skip if busy",
# that would drop a frame.
LOCK = threading.RLock()
POLL = 0.05  # seconds between two looks at what threads make
LOOK = 0.5  # seconds between two looks at what threads have left to be done
JOB = 1.0  # seconds after the last frame that the job of an export evaluated
DELAY = 0.25  # seconds without another change before a dragged slider or a brush stroke is rebuilt


class Awaited(Protocol):
    """What a thread makes, for an object of that name."""

    name: str

    @property
    def seconds(self) -> float: ...

    def is_running(self) -> bool: ...


_render_running = False
_job_seen = -math.inf  # when a handler was called in the thread of a job that is no render
_wanted = False
_suspended = False
_files = 0  # that were opened
_due: set[str] = set()  # names of objects to tag
_workers: tuple[Callable[[], None], ...] = ()
_may_wait = False  # what is long may be left to threads
_awaited: list[Awaited] = []  # what these make
_tell_waiting: Callable[[], None] = lambda: None
_is_held: Callable[[], bool] = lambda: False  # whether the mouse drags something
_may_be_held = False  # whether what is wanted comes of a value or a mesh that somebody may still be dragging


def set_workers(*workers: Callable[[], None]) -> None:
    """What sync_all() calls, in this order."""
    global _workers
    _workers = workers


def note_file() -> None:
    """Another file was opened: what scripts hold of the former one may not be touched."""
    global _files
    _files += 1


def file_number() -> int:
    """Another one with every file that is opened."""
    return _files


def rendering() -> bool:
    return _render_running


def set_rendering(running: bool) -> None:
    global _render_running
    _render_running = running
    if not running and _wanted:
        request()


def playing() -> bool:
    """Whether a window plays the animation."""
    return any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows)


def in_main_thread() -> bool:
    """Jobs (F12, Alembic, Cycles' Bake) evaluate the file in threads of their own, and call the handlers there."""
    return threading.current_thread() is threading.main_thread()


def note_thread() -> None:
    """Called by every handler of a frame. While the job of an export runs no data-block may come or go: Blender says
    nothing of its end, so what is wanted waits until its last frame is a second old."""
    global _job_seen
    if not in_main_thread():
        _job_seen = time.monotonic()
    elif _wanted and not bpy.app.timers.is_registered(_on_timer):
        request()  # in the thread no timer could be started


def allowed_now() -> bool:
    """In background mode there are no timers: structural work is done on the spot unless a render runs."""
    return bpy.app.background and not _render_running


@contextmanager
def suspended() -> Iterator[None]:
    """While an operator changes the stack: 3.4 evaluates, and calls the handlers, in the middle of it."""
    global _suspended
    former, _suspended = _suspended, True
    try:
        yield
    finally:
        _suspended = former


def is_suspended() -> bool:
    return _suspended


def may_process(depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether handlers may solve and write what a depsgraph shows."""
    if _render_running and depsgraph.mode == "VIEWPORT":
        return False  # unguarded: a wrong frame in 3.4, a crash in 4.3
    return not _suspended


def may_prepare_frame() -> bool:
    """Whether something may be written before a frame is evaluated: while a window renders or exports, nobody knows for
    whom."""
    return not _suspended and (bpy.app.background or (in_main_thread() and not _render_running))


# ---------------------------------------------------------------- structural work
def request(delay: float = 0.0, until_released: bool = True) -> None:
    """Do the structural work soon. Several requests become one, after the last. With a delay it waits, too, for the
    mouse to be let go."""
    global _wanted, _may_be_held
    _wanted, _may_be_held = True, delay > 0.0 and until_released
    if bpy.app.background or _render_running or not in_main_thread():
        return  # the next handler in background and after a job, or the end of the render, sees to it
    timers = bpy.app.timers
    if timers.is_registered(_on_timer):  # not a flag of our own: loading a file kills timers
        if delay == 0.0:
            return
        timers.unregister(_on_timer)
    timers.register(_on_timer, first_interval=delay)


def job_runs() -> bool:
    """Whether a render or an export evaluates the file: nothing in it may come, go or be tagged."""
    return _render_running or time.monotonic() < _job_seen + JOB


def _on_timer() -> float | None:
    with LOCK:  # a render job that starts now waits for what is begun here
        if job_runs():
            return 0.5
        if _may_be_held and _is_held():
            return POLL
        if not awaited():
            _sync_and_wait()
        if not _awaited:
            return None
    _tell_waiting()
    return POLL


def hurry() -> None:
    """The mouse was let go: what waits for that is done now."""
    if bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.unregister(_on_timer)
        bpy.app.timers.register(_on_timer, first_interval=0.0)


def ask_whether_held(function: Callable[[], bool]) -> None:
    """Called before what somebody may still be dragging is rebuilt; it is tried again every POLL seconds."""
    global _is_held
    _is_held = function


@contextmanager
def waiting() -> Iterator[None]:
    """What takes long may be left to threads within it. Who uses it sees to it that the timer does the rest."""
    global _may_wait
    former, _may_wait = _may_wait, not bpy.app.background
    try:
        yield
    finally:
        _may_wait = former


def _sync_and_wait() -> None:
    """All structural work but what threads make."""
    with waiting():
        sync_all()


def sync_all() -> None:
    """All structural work, now. Not in handlers while a render or a window draws."""
    global _wanted
    _wanted = False
    _awaited.clear()
    with LOCK:
        for worker in _workers:
            worker()


def work_is_due() -> bool:
    """Whether the timer has something to do. Waits for the end of what it is doing."""
    with LOCK:
        return _wanted or bool(_awaited)


def may_wait() -> bool:
    """Whether structural work may be left for later, while a thread makes what it needs."""
    return _may_wait


def wait_for(work: Awaited) -> None:
    """Do the structural work again when this is ready."""
    _awaited.append(work)


def awaited() -> list[Awaited]:
    """What threads still make."""
    return [work for work in _awaited if work.is_running()]


def drop(work: Awaited) -> None:
    """Nobody waits for this any more."""
    if work in _awaited:
        _awaited.remove(work)


def tell_waiting(function: Callable[[], None]) -> None:
    """Called while something is awaited, every POLL seconds."""
    global _tell_waiting
    _tell_waiting = function


# ---------------------------------------------------------------- panels
def redraw_panels_soon() -> None:
    """What panels say has changed. Never while a render job runs: where an engine ends within the drawing of a panel,
    Blender 3.4 and 4.3 forbid Python to write for good."""
    if bpy.app.background or not in_main_thread():
        return
    if not bpy.app.timers.is_registered(_redraw_panels):
        bpy.app.timers.register(_redraw_panels, first_interval=0.1)


def _redraw_panels() -> float | None:
    if _render_running or bpy.app.is_job_running("RENDER"):
        return 0.5
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("PROPERTIES", "VIEW_3D"):  # the sidebar has panels too
                area.tag_redraw()
    return None


# ---------------------------------------------------------------- tags
def tag_soon(names: set[str]) -> None:
    """Let objects be evaluated once more: from where nothing may be tagged."""
    _due.update(names)
    if _due and in_main_thread() and not bpy.app.background:
        _restart(0.0)


def look_for_threads() -> None:
    """From now on what the threads of jobs leave to be done is done when they have ended: they may start no timer, and
    Blender calls nothing of ours in the main thread then."""
    if not bpy.app.background:
        _restart(LOOK)


def _restart(seconds: float) -> None:
    """The one timer that always runs."""
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    bpy.app.timers.register(_look, first_interval=seconds, persistent=True)


def _look() -> float:
    # A tag reaches the depsgraph of a job as well, in the midst of its evaluation. The thread of a job holds the lock
    # while it solves: without anything to do nobody waits for it.
    if job_runs() or not (_due or _wanted):
        return LOOK
    with LOCK:
        if job_runs():
            return LOOK
        while _due:
            name = _due.pop()
            if name in bpy.data.objects:
                bpy.data.objects[name].update_tag()
        if _wanted and not bpy.app.timers.is_registered(_on_timer):
            request()  # a job's thread could start no timer
    return LOOK


def stop() -> None:
    """For unregister()."""
    for function in (_on_timer, _look, _redraw_panels, hurry):
        if bpy.app.timers.is_registered(function):
            bpy.app.timers.unregister(function)
    _awaited.clear()
    set_workers()
