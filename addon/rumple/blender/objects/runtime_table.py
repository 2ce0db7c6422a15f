# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of objects from frame to frame, outside the file: one table for wrinkles, one for Wrinkle Maps.

Nothing here is stored in ID properties: handlers run in a render thread too, where writing them is forbidden.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Generic, Iterable, TypeVar

import bpy

from .. import compat
from .messages import Messages


@dataclass
class RuntimeBase(Messages):
    """One object."""

    stale: bool = True  # something may have changed: check before the next structural step
    output_key: int = 0  # the mesh that was written last

    def invalidate_output(self) -> None:
        """What was written may be something else now: write again, whatever it is."""
        self.output_key = 0

    def invalidate(self) -> None:
        """Everything in the file may be another version of itself."""
        self.stale = True
        self.invalidate_output()

    def end(self) -> None:
        """Nobody asks for it any more."""


AnyEntry = TypeVar("AnyEntry", bound=RuntimeBase)


class RuntimeTable(Generic[AnyEntry]):
    """An entry for each original (not evaluated) object."""

    def __init__(self, new: Callable[[], AnyEntry]) -> None:
        self._new = new
        self._entries: dict[int, AnyEntry] = {}

    def of(self, obj: bpy.types.Object) -> AnyEntry:
        """The entry of an object, made where there is none."""
        key = compat.session_key(obj)
        entry = self._entries.get(key)  # a render's thread may ask as well
        return self._entries.setdefault(key, self._new()) if entry is None else entry

    def known(self, obj: bpy.types.Object) -> AnyEntry | None:
        """The entry of an object, or None."""
        return self._entries.get(compat.session_key(obj))

    def message(self, obj: bpy.types.Object) -> str:
        """What is wrong with an object, in words; empty when nothing is."""
        runtime = self.known(obj)
        return "" if runtime is None else runtime.refusal or runtime.message

    def forget(self, obj: bpy.types.Object) -> None:
        entry = self._entries.pop(compat.session_key(obj), None)
        if entry is not None:
            entry.end()

    def forget_all(self) -> None:
        for entry in self._entries.values():
            entry.end()
        self._entries.clear()

    def forget_all_but(self, objects: Iterable[bpy.types.Object]) -> None:
        """Deleted objects leave nothing behind; their address may be taken over by others."""
        keep = {compat.session_key(obj) for obj in objects}
        for key in [key for key in self._entries if key not in keep]:
            self._entries.pop(key).end()

    def invalidate_outputs(self) -> None:
        """After a render, which wrote its last frame."""
        for runtime in self._entries.values():
            runtime.invalidate_output()

    def invalidate_all(self) -> None:
        """After undo and redo. Stored frames stay."""
        for runtime in self._entries.values():
            runtime.invalidate()
