# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls functions at the same time. Never imports bpy.

It pays where most of their time is spent in the library or in NumPy, because these release Python's lock.
"""
from __future__ import annotations

import os
import threading
from collections import deque
from typing import Callable, Sequence


def call_at_once(calls: Sequence[Callable[[], None]]) -> None:
    """Call functions on as many threads as there are processors, this one among them, and return when all have ended.
    A single function is called without another thread. They must not raise, and must not change what another one reads.

    The library's own threads are not divided among them: more threads than processors cost little, and where one
    function takes longer than the others, it uses the processors that they leave.
    """
    waiting = deque(calls)
    threads = [threading.Thread(target=_call_some, args=(waiting,), name="Rumple solves")
               for _ in range(min(len(calls), _processors()) - 1)]
    started = [thread for thread in threads if _has_started(thread)]
    try:
        _call_some(waiting)
    finally:
        for thread in started:
            thread.join()


def _processors() -> int:
    """The number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _has_started(thread: threading.Thread) -> bool:
    try:
        thread.start()
    except RuntimeError:  # the system has no more threads: those that run call all
        return False
    return True


def _call_some(waiting: deque[Callable[[], None]]) -> None:
    while True:
        try:
            call = waiting.popleft()
        except IndexError:
            return
        call()
