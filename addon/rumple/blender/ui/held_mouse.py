# SPDX-License-Identifier: GPL-3.0-or-later
"""Detects whether the left mouse button is down, so that a dragged slider is rebuilt when it is released.

Blender tells only operators. An invoked operator gets the last press or release of its window, even if the mouse has
moved since. If this was a press, the operator stays in front of the dragged element, passes every event on, and gets
the release.
"""
from __future__ import annotations

import bpy

from .. import scheduler

APPLIED = 0.05  # seconds after a release in which Blender still sets the dragged value

_down_in = -1  # number of the file in which the button is down


class WM_OT_rumple_held_mouse(bpy.types.Operator):
    """Wait until the mouse is let go"""

    bl_idname = "wm.rumple_held_mouse"
    bl_label = "Wait for the Mouse"
    bl_options = {"INTERNAL"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        global _down_in
        if (event.type, event.value) != ("LEFTMOUSE", "PRESS"):
            return {"CANCELLED"}
        _down_in = scheduler.file_number()
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, _context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        # After another press, the release was missed.
        if (event.type, event.value) == ("LEFTMOUSE", "RELEASE") or event.value == "PRESS":
            _let_go()
            return {"FINISHED", "PASS_THROUGH"}
        return {"PASS_THROUGH"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """Called when another file is opened, or the window is closed."""
        _let_go()


def _let_go() -> None:
    global _down_in
    _down_in = -1
    if not bpy.app.timers.is_registered(scheduler.run_pending_now):
        bpy.app.timers.register(scheduler.run_pending_now, first_interval=APPLIED)


def _is_down() -> bool:
    """Called by the timer of the structural work."""
    if _down_in == scheduler.file_number():
        return True
    for window in bpy.context.window_manager.windows:
        with bpy.context.temp_override(window=window):
            if bpy.ops.wm.rumple_held_mouse("INVOKE_DEFAULT") == {"RUNNING_MODAL"}:
                return True
    return False


_register, _unregister = bpy.utils.register_classes_factory((WM_OT_rumple_held_mouse,))


def register() -> None:
    global _down_in
    _down_in = -1
    _register()
    scheduler.set_mouse_held_test(_is_down)


def unregister() -> None:
    scheduler.set_mouse_held_test(lambda: False)
    _unregister()
