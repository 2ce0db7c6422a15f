# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of objects from frame to frame, which is not stored in the file: one table for wrinkles, one for Wrinkle
Maps.

It is not stored in ID properties, because handlers also run in a render thread, which must not write these.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Generic, Iterable, TypeVar

import bpy

from .. import compat
from .messages import Messages


@dataclass
class RuntimeBase(Messages):
    """The state of one object."""

    stale: bool = True  # something may have changed: check before the next structural step
    output_key: int = 0  # session key of the mesh that was written last

    def invalidate_output(self) -> None:
        """The output mesh may have changed: write it again in any case."""
        self.output_key = 0

    def invalidate(self) -> None:
        """All data of the file may have changed."""
        self.stale = True
        self.invalidate_output()

    def end(self) -> None:
        """Called when the entry is removed."""


AnyEntry = TypeVar("AnyEntry", bound=RuntimeBase)


class RuntimeTable(Generic[AnyEntry]):
    """One entry for each original (not evaluated) object."""

    def __init__(self, new: Callable[[], AnyEntry]) -> None:
        self._new = new
        self._entries: dict[int, AnyEntry] = {}

    def of(self, obj: bpy.types.Object) -> AnyEntry:
        """The entry of an object, created if there is none."""
        key = compat.session_key(obj)
        entry = self._entries.get(key)  # a render's thread may call this too
        return self._entries.setdefault(key, self._new()) if entry is None else entry

    def known(self, obj: bpy.types.Object) -> AnyEntry | None:
        """The entry of an object, or None."""
        return self._entries.get(compat.session_key(obj))

    def message(self, obj: bpy.types.Object) -> str:
        """The error message about an object, or the warning about its paths, or an empty text."""
        runtime = self.known(obj)
        return "" if runtime is None else runtime.refusal or runtime.message or runtime.no_room

    def forget(self, obj: bpy.types.Object) -> None:
        entry = self._entries.pop(compat.session_key(obj), None)
        if entry is not None:
            entry.end()

    def forget_all(self) -> None:
        for entry in self._entries.values():
            entry.end()
        self._entries.clear()

    def forget_all_but(self, objects: Iterable[bpy.types.Object]) -> None:
        """Forget deleted objects, because others may get their addresses."""
        keep = {compat.session_key(obj) for obj in objects}
        for key in [key for key in self._entries if key not in keep]:
            self._entries.pop(key).end()

    def invalidate_outputs(self) -> None:
        """Called after a render, which wrote its last frame."""
        for runtime in self._entries.values():
            runtime.invalidate_output()

    def invalidate_all(self) -> None:
        """Called after undo and redo. Stored frames stay."""
        for runtime in self._entries.values():
            runtime.invalidate()
