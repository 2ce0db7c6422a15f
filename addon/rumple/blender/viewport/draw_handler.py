# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that Blender calls when it has drawn a 3D viewport."""
from __future__ import annotations

from typing import Any, Callable

import bpy
from bpy.app.handlers import persistent

from ..objects import messages


class DrawHandler:
    """A function that Blender calls when it has drawn a 3D viewport.

    None in background mode: there is no viewport, and the gpu module crashes 3.4 there.
    """

    def __init__(self, what: str, draw: Callable[[], None], clear: Callable[[], None] | None = None) -> None:
        """what: it draws, for the console. clear: drops what draw() keeps; called before another file is loaded, and
        when the handler is removed."""
        self._what, self._draw, self._clear = what, draw, clear
        self._handle: Any = None

        @persistent
        def on_load(*_arguments: object) -> None:
            if clear is not None:
                clear()
        self._on_load = on_load

    @property
    def added(self) -> bool:
        """Whether Blender calls it."""
        return self._handle is not None

    def draw(self) -> None:
        """What Blender calls. Never raises, or Blender would print it at every redraw."""
        with messages.console_errors(self._what):
            self._draw()

    def add(self) -> None:
        """Nothing where it is there already, or in background mode."""
        if self._handle is None and not bpy.app.background:
            self._handle = bpy.types.SpaceView3D.draw_handler_add(self.draw, (), "WINDOW", "POST_VIEW")
            bpy.app.handlers.load_pre.append(self._on_load)

    def remove(self) -> None:
        """Drops what is kept, and the handler where there is one."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            bpy.app.handlers.load_pre.remove(self._on_load)
            self._handle = None
        if self._clear is not None:
            self._clear()
