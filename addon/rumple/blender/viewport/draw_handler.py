# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that Blender calls after it has drawn a 3D viewport."""
from __future__ import annotations

from typing import Any, Callable

import bpy
from bpy.app.handlers import persistent

from ..objects import messages


class DrawHandler:
    """A function that Blender calls after it has drawn a 3D viewport.

    It is not used in background mode: there is no viewport, and the gpu module crashes 3.4 there.
    """

    def __init__(self, what: str, draw: Callable[[], None], clear: Callable[[], None] | None = None) -> None:
        """what: the drawing, for messages on the console. clear: frees the data of draw(); called before another file
        is loaded, and when the handler is removed."""
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
        """The function that Blender calls. It never raises, because Blender would print the exception at every
        redraw."""
        with messages.console_errors(self._what):
            self._draw()

    def add(self) -> None:
        """Add the handler, unless it is already added or Blender runs in background mode."""
        if self._handle is None and not bpy.app.background:
            self._handle = bpy.types.SpaceView3D.draw_handler_add(self.draw, (), "WINDOW", "POST_VIEW")
            bpy.app.handlers.load_pre.append(self._on_load)

    def remove(self) -> None:
        """Free the data, and remove the handler if it was added."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            bpy.app.handlers.load_pre.remove(self._on_load)
            self._handle = None
        if self._clear is not None:
            self._clear()
