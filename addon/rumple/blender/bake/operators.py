# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the bake: bpy.ops.object.rumple_bake(), rumple_bake_free(), rumple_bake_shape_keys()."""
from __future__ import annotations

import time

import bpy

from .. import ui_base
from ..objects import modifier
from ..translation import said
from . import clip, shape_keys
from .playback import BakeError, Playback

STEP_SECONDS = 0.05  # the window stays alive: solve for so long between two redraws


class OBJECT_OT_rumple_bake(ui_base.OnWrinkled, bpy.types.Operator):
    """Play the clip through and store it in a file beside the blend file. Renders then need neither solve nor add-on"""

    bl_idname = "object.rumple_bake"
    bl_label = "Bake"

    def execute(self, context: bpy.types.Context) -> set[str]:
        bake = self._begin(context)
        if bake is None:
            return {"CANCELLED"}
        try:
            while bake.step():
                pass
        except BakeError as error:
            return self._give_up(bake, error)
        return self._finish(bake)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        self._running = self._begin(context)
        if self._running is None:
            return {"CANCELLED"}
        manager = context.window_manager
        manager.progress_begin(0, self._running.playback.count)
        self._timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            self._end_modal(context)
            return self._give_up(self._running, BakeError("Bake cancelled: nothing was changed"), "INFO")
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        until = time.perf_counter() + STEP_SECONDS
        try:
            while time.perf_counter() < until:
                if not self._running.step():
                    self._end_modal(context)
                    return self._finish(self._running)
        except BakeError as error:
            self._end_modal(context)
            return self._give_up(self._running, error)
        self._show_progress(context)
        return {"RUNNING_MODAL"}

    def _show_progress(self, context: bpy.types.Context) -> None:
        done, count = self._running.done, self._running.playback.count
        context.window_manager.progress_update(done)
        if context.workspace is not None:
            context.workspace.status_text_set(said(f"Baking wrinkles: {done} of {count} samples. Esc cancels"))

    def _end_modal(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def _begin(self, context: bpy.types.Context) -> clip.ClipBake | None:
        try:
            return clip.ClipBake(context, context.object)
        except BakeError as error:
            self.report({"ERROR"}, said(str(error)))
            return None

    def _give_up(self, bake: clip.ClipBake, error: Exception, kind: str = "ERROR") -> set[str]:
        bake.cancel()
        self.report({kind}, said(str(error)))
        return {"CANCELLED"}

    def _finish(self, bake: clip.ClipBake) -> set[str]:
        try:
            written = bake.finish()
        except BakeError as error:
            return self._give_up(bake, error)
        self.report({"WARNING"} if bake.note else {"INFO"},
                    said(f"Baked {bake.writer.manifest.sample_count} samples to {written}{bake.note}"))
        return {"FINISHED"}


class OBJECT_OT_rumple_bake_free(ui_base.OnWrinkled, bpy.types.Operator):
    """Stop showing the baked clip: the wrinkles are live again. The file stays unless told otherwise"""

    bl_idname = "object.rumple_bake_free"
    bl_label = "Free Bake"

    delete_file: bpy.props.BoolProperty(name="Delete File",
                                        description="Delete the clip too. Undo does not bring it back")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        baked = modifier.is_baked(modifier.find(context.object))
        if not baked:
            cls.poll_message_set(said("Nothing is baked"))
        return baked

    def execute(self, context: bpy.types.Context) -> set[str]:
        note = clip.free(context.object, self.delete_file)
        if note:
            self.report({"WARNING"}, said(note))
        return {"FINISHED"}


class OBJECT_OT_rumple_bake_shape_keys(ui_base.OnWrinkled, bpy.types.Operator):
    """Make a new mesh object with a shape key for every frame, for exporters and other programs"""

    bl_idname = "object.rumple_bake_shape_keys"
    bl_label = "Bake to Shape Keys"

    start: bpy.props.IntProperty(name="Start", description="First frame; unset: as for the bake", options={"SKIP_SAVE"})
    end: bpy.props.IntProperty(name="End", description="Last frame; unset: as for the bake", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        start = self.start if self.properties.is_property_set("start") else obj.rumple.bake_start
        end = self.end if self.properties.is_property_set("end") else obj.rumple.bake_end
        playback = None
        try:
            playback = Playback(context, obj, start, end, 1)
            shapes = [result.positions.copy() for wanted, result, _ in playback.samples_in_order() if wanted]
        except BakeError as error:
            self.report({"ERROR"}, said(str(error)))
            return {"CANCELLED"}
        finally:
            if playback is not None:
                playback.end_playback(restore_bake=True)
        copy = shape_keys.shape_key_object(context, obj, shapes, start)
        obj.hide_render = True
        obj.hide_set(True)
        obj.select_set(False)
        copy.select_set(True)
        context.view_layer.objects.active = copy
        self.report({"INFO"}, said(f"{copy.name}: {len(shapes)} shape keys. {obj.name} is hidden"))
        return {"FINISHED"}


CLASSES = (OBJECT_OT_rumple_bake, OBJECT_OT_rumple_bake_free, OBJECT_OT_rumple_bake_shape_keys)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
