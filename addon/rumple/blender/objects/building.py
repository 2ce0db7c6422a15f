# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds wrinkles in a thread, so that the window stays usable. The engine's build only reads arrays, never Blender."""
from __future__ import annotations

import threading
import time
import weakref
from typing import Any, Callable

from ...core.frame.engine import Wrinkles
from ...native import kernels

PATIENCE = 0.2  # seconds to wait on the spot for a short build


class Building:
    """A running build for one object. wanted: the inputs of the build. If no thread can be started, it is built on the
    spot."""

    def __init__(self, name: str, wanted: Any, build: Callable[[], Wrinkles]) -> None:
        self.name, self.wanted = name, wanted
        self._build = build
        self._made: Wrinkles | None = None
        self._error: Exception | None = None
        self._began = time.monotonic()
        self._stop = kernels.Stop.new()
        _all.add(self)
        self._thread: threading.Thread | None = threading.Thread(target=self._run, name=f"Rumple builds {name}")
        try:
            self._thread.start()
        except RuntimeError:  # the system has no more threads
            self._thread = None
            self._run()

    def _run(self) -> None:
        try:
            with self._stop.watched():
                self._made = self._build()
        except Exception as error:  # result() raises it again
            self._error = error

    @property
    def seconds(self) -> float:
        """Time since the start."""
        return time.monotonic() - self._began

    def is_running(self, patience: float = 0.0) -> bool:
        """Whether it is still running after at most `patience` seconds."""
        if self._thread is None:
            return False
        self._thread.join(patience)
        return self._thread.is_alive()

    def drop(self) -> None:
        """Discard the build: its thread ends soon, without a result."""
        self._stop.ask()

    def result(self) -> Wrinkles:
        """Wait for the end. Raises the exceptions of the build."""
        if self._thread is not None:
            self._thread.join()
        if self._error is not None:
            raise self._error
        assert self._made is not None
        return self._made


_all: weakref.WeakSet[Building] = weakref.WeakSet()


def drop_all() -> None:
    """Call this before Blender quits, because Blender waits for threads."""
    for building in list(_all):
        building.drop()
