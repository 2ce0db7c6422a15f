# SPDX-License-Identifier: GPL-3.0-or-later
"""Schedules structural work. Data-blocks are created and removed only outside of handlers.

In a window a timer does this work. Background mode has no timers, so the next handler does it on the spot, unless a
render runs. While an operator changes the modifier stack, nothing is done. handlers.py registers the workers, which do
the work.
"""
from __future__ import annotations

import math
import threading
import time
from contextlib import contextmanager
from typing import Callable, Iterable, Iterator, Protocol

import bpy

# Handlers run in the render job's thread while the window's thread draws. Only one thread may work at a time. A handler
# must wait for the lock, because skipping would lose a frame.
LOCK = threading.RLock()
_WORK_DONE = threading.Condition(LOCK)
POLL = 0.05  # seconds between two checks of building threads
LOOK = 0.5  # seconds between two checks for work left by job threads
JOB = 1.0  # seconds after the last frame of an export until its job counts as finished
DELAY = 0.25  # seconds without another change before a dragged slider or a brush stroke is rebuilt


class Build(Protocol):
    """A running thread that builds something for the object with this name."""

    name: str

    @property
    def seconds(self) -> float: ...

    def is_running(self) -> bool: ...


_render_running = False
_job_seen = -math.inf  # time of the last handler call in the thread of a job that is not a render
_wanted = False
_suspended = False
_files = 0  # number of opened files
_due: set[tuple[str, str | None]] = set()  # objects to tag: name and library, because undo keeps them
_workers: tuple[Callable[[], None], ...] = ()
_regular_check: Callable[[], None] = lambda: None
_thread_builds_allowed = False  # long work may be left to threads
_builds: list[Build] = []  # running threads
_report_progress: Callable[[], None] = lambda: None
_is_mouse_held: Callable[[], bool] = lambda: False  # whether the mouse button is down
_waits_for_mouse = False  # whether the requested work comes from a value or mesh that may still be dragged


def set_workers(*workers: Callable[[], None]) -> None:
    """Set the functions that sync_all() calls, in this order."""
    global _workers
    _workers = workers


def set_regular_check(function: Callable[[], None]) -> None:
    """Set the function that is called every LOOK seconds in a window while no job runs."""
    global _regular_check
    _regular_check = function


def note_file() -> None:
    """Called when another file was opened: references to data of the former file are no longer valid."""
    global _files
    _files += 1


def file_number() -> int:
    """A number that changes with every opened file."""
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
    """Whether this is the main thread. Jobs (F12, Alembic, Cycles' Bake) evaluate the file in their own threads, and
    call the handlers there."""
    return threading.current_thread() is threading.main_thread()


def note_thread() -> None:
    """Called by every handler of a frame. While the job of an export runs, no data-block may be created or removed.
    Blender does not report its end, so requested work waits until one second after its last frame."""
    global _job_seen
    if not in_main_thread():
        _job_seen = time.monotonic()
    elif _wanted and not bpy.app.timers.is_registered(_on_timer):
        request()  # the job's thread could not start a timer


def allowed_now() -> bool:
    """Whether structural work can be done now. In background mode there are no timers, so it is done on the spot unless
    a render runs."""
    return bpy.app.background and not _render_running


@contextmanager
def suspended() -> Iterator[None]:
    """Suspend all work while an operator changes the stack, because 3.4 evaluates the object and calls the handlers
    during the change."""
    global _suspended
    former, _suspended = _suspended, True
    try:
        yield
    finally:
        _suspended = former


def is_suspended() -> bool:
    return _suspended


def may_process(depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether handlers may solve and write the objects of a depsgraph."""
    if _render_running and depsgraph.mode == "VIEWPORT":
        return False  # otherwise: a wrong frame in 3.4, a crash in 4.3
    return not _suspended


def may_prepare_frame() -> bool:
    """Whether data may be written before a frame is evaluated. Not while a window renders or exports, because the
    depsgraph of the frame is then unknown."""
    return not _suspended and (bpy.app.background or (in_main_thread() and not _render_running))


# ---------------------------------------------------------------- structural work
def request(delay: float = 0.0) -> None:
    """Do the structural work soon. Several requests are combined, after the last one. A delayed request also waits
    until the mouse is released."""
    global _wanted, _waits_for_mouse
    _wanted, _waits_for_mouse = True, delay > 0.0
    if bpy.app.background or _render_running or not in_main_thread():
        return  # in background, and after a job, the next handler does it; after a render, its end
    timers = bpy.app.timers
    if timers.is_registered(_on_timer):  # not our own flag, because loading a file removes timers
        if delay == 0.0:
            return
        timers.unregister(_on_timer)
    timers.register(_on_timer, first_interval=delay)


def job_runs() -> bool:
    """Whether a render or an export evaluates the file. Then nothing may be created, removed or tagged."""
    return _render_running or time.monotonic() < _job_seen + JOB


def _on_timer() -> float | None:
    with LOCK:  # a render job that starts now waits for the end of this work
        if job_runs():
            return 0.5
        # Only between builds: until Python 3.12, an operator that is called in an override of the context, as this test
        # does, breaks Python's memory if another thread uses Python at that moment.
        if not running_builds():
            if _waits_for_mouse and _is_mouse_held():
                return POLL
            with thread_builds_allowed():
                sync_all()
        if not _builds:
            return None
    _report_progress()
    return POLL


def run_pending_now() -> None:
    """Do the requested work now. Called when the mouse is released."""
    if bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.unregister(_on_timer)
        bpy.app.timers.register(_on_timer, first_interval=0.0)


def set_mouse_held_test(function: Callable[[], bool]) -> None:
    """Set the function that is called before a rebuild that depends on a dragged value or mesh. If the mouse is down,
    the rebuild is tried again every POLL seconds."""
    global _is_mouse_held
    _is_mouse_held = function


@contextmanager
def thread_builds_allowed() -> Iterator[None]:
    """Inside this context long work may be left to threads. The caller must let the timer do the rest."""
    global _thread_builds_allowed
    former, _thread_builds_allowed = _thread_builds_allowed, not bpy.app.background
    try:
        yield
    finally:
        _thread_builds_allowed = former


def sync_all() -> None:
    """Do all structural work now. Do not call it in handlers while a render or a window draws."""
    global _wanted
    _wanted = False
    _builds.clear()
    with LOCK:
        for worker in _workers:
            worker()
        _WORK_DONE.notify_all()


def work_is_due() -> bool:
    """Whether the timer has work to do. It waits for the end of running work."""
    with LOCK:
        return _wanted or bool(_builds)


def wait_for_work(seconds: float) -> None:
    """Wait, in the thread of a job, until the timers of the window have done the requested work, for at most this time.
    The thread sleeps, because it must not use Python while the timers call operators: see _on_timer()."""
    with LOCK:
        _WORK_DONE.wait_for(lambda: not work_is_due(), seconds)


def may_build_in_thread() -> bool:
    """Whether structural work may be postponed while a thread builds its input."""
    return _thread_builds_allowed


def add_build(build: Build) -> None:
    """Do the structural work again when this thread has finished."""
    _builds.append(build)


def running_builds() -> list[Build]:
    """The threads that are still running."""
    return [build for build in _builds if build.is_running()]


def remove_build(build: Build) -> None:
    """Do not wait for this thread any more."""
    with LOCK:
        if build in _builds:
            _builds.remove(build)
        _WORK_DONE.notify_all()


def set_progress_callback(function: Callable[[], None]) -> None:
    """Set the function that is called every POLL seconds while threads are running."""
    global _report_progress
    _report_progress = function


# ---------------------------------------------------------------- panels
def redraw_panels_soon() -> None:
    """Redraw panels, because their text has changed. Never while a render job runs: if an engine ends while a panel is
    drawn, Blender 3.4 and 4.3 never allow Python to write again."""
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
def tag_soon(objects: Iterable[bpy.types.Object]) -> None:
    """Tag objects soon, so that they are evaluated again. It can be called where tagging is not allowed."""
    _due.update((obj.name, obj.library and obj.library.filepath) for obj in objects)
    if _due and in_main_thread() and not bpy.app.background:
        _restart(0.0)


def look_for_threads() -> None:
    """Start the timer for work left by job threads. They cannot start a timer, and Blender calls no handler in the main
    thread when they end."""
    if not bpy.app.background:
        _restart(LOOK)


def _restart(seconds: float) -> None:
    """Restart the timer that always runs."""
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    bpy.app.timers.register(_look, first_interval=seconds, persistent=True)


def _look() -> float:
    # A tag also reaches the depsgraph of a job during its evaluation, so nothing is tagged while a job runs. The thread
    # of a job holds the lock while it solves, so the lock is taken only if there is work to do.
    if job_runs():
        return LOOK
    _regular_check()
    if not (_due or _wanted):
        return LOOK
    with LOCK:
        if job_runs():
            return LOOK
        while _due:
            obj = bpy.data.objects.get(_due.pop())
            if obj is not None:
                obj.update_tag()
        if _wanted and not bpy.app.timers.is_registered(_on_timer):
            request()  # the job's thread could not start a timer
    return LOOK


def stop() -> None:
    """Called by unregister()."""
    for function in (_on_timer, _look, _redraw_panels, run_pending_now):
        if bpy.app.timers.is_registered(function):
            bpy.app.timers.unregister(function)
    _builds.clear()
    set_workers()
    set_regular_check(lambda: None)
