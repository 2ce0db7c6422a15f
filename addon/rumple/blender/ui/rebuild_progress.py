# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows in a window that threads build fine meshes, and handles Esc."""
from __future__ import annotations

import bpy

from .. import scheduler, ui_base
from ..objects import evaluator, modifier, runtimes
from ..translation import said
from .operators import remove

AFTER = 0.4  # seconds: nothing is shown for shorter builds

_shown_in = -1  # number of the file in which it is shown


class WM_OT_rumple_rebuild_wait(ui_base.ModalWork, bpy.types.Operator):
    """Say in the status bar that folds are being made. Esc leaves all as it was"""

    bl_idname = "wm.rumple_rebuild_wait"
    bl_label = "Stop Making Folds"
    bl_options = {"INTERNAL", "UNDO"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        global _shown_in
        _shown_in = scheduler.file_number()
        running = self.begin_modal(context, 9999, 0.1)
        self._say(context)
        return running

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        builds = scheduler.running_builds()
        if event.type == "ESC" and event.value == "PRESS" and builds and not scheduler.job_runs():
            self._end(context)
            for build in builds:
                self._cancel(build)
            return {"FINISHED", "PASS_THROUGH"}  # Esc must also reach a dragged slider
        if not builds:
            self._end(context)
            return {"CANCELLED", "PASS_THROUGH"}
        if event.type == "TIMER":
            self._say(context)
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Called when another file is opened, or the window is closed."""
        self._end(context)

    def _cancel(self, build: scheduler.Build) -> None:
        obj = bpy.data.objects.get(build.name)
        runtime = None if obj is None else runtimes.known(obj)
        scheduler.remove_build(build)
        if runtime is None or runtime.build.running is not build or modifier.find(obj) is None:
            return
        if runtime.build.just_added:
            remove(obj)
            note = f"{obj.name}: Esc stopped it, so no wrinkles were added"
        else:
            note = evaluator.cancel(obj, runtime)
        self.report({"INFO"}, said(note))

    def _say(self, context: bpy.types.Context) -> None:
        builds = scheduler.running_builds()
        if not builds:
            return
        seconds = max(build.seconds for build in builds)
        context.window_manager.progress_update(int(seconds))
        names = ", ".join(build.name for build in builds)
        self.show_status(context, said(f"Making the folds of {names}: {seconds:.0f} s. Esc stops it"))

    def _end(self, context: bpy.types.Context) -> None:
        global _shown_in
        _shown_in = -1
        self.end_modal(context)


def _tell() -> None:
    """Called by the timer of the structural work."""
    windows = bpy.context.window_manager.windows
    is_long = any(build.seconds >= AFTER for build in scheduler.running_builds())
    if not is_long or _shown_in == scheduler.file_number() or not len(windows):
        return
    with bpy.context.temp_override(window=windows[0]):
        bpy.ops.wm.rumple_rebuild_wait("INVOKE_DEFAULT")


_register, _unregister = bpy.utils.register_classes_factory((WM_OT_rumple_rebuild_wait,))


def register() -> None:
    global _shown_in
    _shown_in = -1
    _register()
    scheduler.set_progress_callback(_tell)


def unregister() -> None:
    scheduler.set_progress_callback(lambda: None)
    _unregister()
