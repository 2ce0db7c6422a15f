# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets one thread stop a call of another thread: native/include/rumple/base.h."""
from __future__ import annotations

import contextlib
from typing import Iterator

from . import c
from .handle import Handle
from .library import lib


class Stop(Handle):
    """A request to stop. One thread makes it, another thread watches for it."""

    __slots__ = ()
    POINTER, FREE = c.StopPointer, "rumple_stop_free"

    @classmethod
    def new(cls) -> "Stop":
        return cls.made(lib.rumple_stop_build)

    def ask(self) -> None:
        """Ask to stop: builds in the watching thread then raise library.Stopped. It works from any thread, and cannot
        be undone."""
        lib.rumple_stop_ask(self)

    @contextlib.contextmanager
    def watched(self) -> Iterator[None]:
        """A context in which this thread watches it."""
        lib.rumple_stop_watch(self)
        try:
            yield
        finally:
            lib.rumple_stop_watch(None)
