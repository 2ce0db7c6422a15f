# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkles that are built in a thread while the window goes on: the engine's build reads arrays only, never Blender."""
from __future__ import annotations

import threading
import time
import weakref
from typing import Any, Callable

from ...core.engine import Wrinkles
from ...native import kernels

PATIENCE = 0.2  # seconds: what takes no longer is waited for on the spot


class Building:
    """What is under way for one object. wanted: what it is made of. Where no thread can be started it is built on the
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
        except RuntimeError:  # the system has none left
            self._thread = None
            self._run()

    def _run(self) -> None:
        try:
            with self._stop.watched():
                self._made = self._build()
        except Exception as error:  # raised again where it is asked for
            self._error = error

    @property
    def seconds(self) -> float:
        """Since it began."""
        return time.monotonic() - self._began

    def is_running(self, patience: float = 0.0) -> bool:
        """After so many seconds at most."""
        if self._thread is None:
            return False
        self._thread.join(patience)
        return self._thread.is_alive()

    def drop(self) -> None:
        """Nobody wants it any more: its thread ends soon, and has no result."""
        self._stop.ask()

    def result(self) -> Wrinkles:
        """Waits for its end. Raises what the build raised."""
        if self._thread is not None:
            self._thread.join()
        if self._error is not None:
            raise self._error
        assert self._made is not None
        return self._made


_all: weakref.WeakSet[Building] = weakref.WeakSet()


def drop_all() -> None:
    """Before Blender quits: it waits for threads."""
    for building in list(_all):
        building.drop()
