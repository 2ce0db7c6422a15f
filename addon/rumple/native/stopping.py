# SPDX-License-Identifier: GPL-3.0-or-later
"""How one thread ends what another one makes: native/include/rumple/base.h."""
from __future__ import annotations

import contextlib
from typing import Iterator

from . import c
from .handle import Handle
from .library import lib


class Stop(Handle):
    """Asked by one thread, watched by another."""

    __slots__ = ()
    POINTER, FREE = c.StopPointer, "rumple_stop_free"

    @classmethod
    def new(cls) -> "Stop":
        return cls.made(lib.rumple_stop_build)

    def ask(self) -> None:
        """Models that are made by who watches it raise library.Stopped. From any thread; it cannot be taken back."""
        lib.rumple_stop_ask(self)

    @contextlib.contextmanager
    def watched(self) -> Iterator[None]:
        """By this thread."""
        lib.rumple_stop_watch(self)
        try:
            yield
        finally:
            lib.rumple_stop_watch(None)
