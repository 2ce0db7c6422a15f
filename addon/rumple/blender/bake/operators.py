# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of the bake: bpy.ops.object.rumple_bake(), rumple_bake_free(), rumple_bake_shape_keys()."""
from __future__ import annotations

import time

import bpy

from .. import ui_base
from ..frame import baking
from ..objects import clip_place, clip_range, modifier, units
from ..translation import said
from . import clip, duration, shape_keys
from .playback import BakeError, Playback

PARTS = 1000  # steps of the displayed progress
UNSAVED = ": this folder goes when Blender quits. Save the file and bake again"
WAIT_SECONDS = 2.0  # between two attempts to move a clip to its place
STEP_SECONDS = 0.05  # solve for this long between two redraws, so that the window responds


class OBJECT_OT_rumple_bake(ui_base.OnWrinkled, ui_base.ModalWork, bpy.types.Operator):
    """Play the clip through and store it in a file beside the blend file. Renders then need neither solve nor add-on"""

    bl_idname = "object.rumple_bake"
    bl_label = "Bake"

    every: bpy.props.BoolProperty(name="All Objects", options={"SKIP_SAVE"},
                                  description="Bake every object of the scene that has wrinkles, each with its own "
                                              "range; what is worn over others comes after them")

    def execute(self, context: bpy.types.Context) -> set[str]:
        self._line_up(context)
        self._next(context)
        while self._running is not None:
            self._step_until(context, float("inf"))
        return self._end()

    def _line_up(self, context: bpy.types.Context) -> None:
        """List the names of the objects to bake."""
        self._baked = 0
        if not self.every:
            self._waiting = [context.object.name]
            return
        self._waiting = [obj.name for obj in duration.bake_all(context.scene)]

    def _next(self, context: bpy.types.Context) -> None:
        """Begin the next object that can be baked. If there is none, all are done."""
        self._running: clip.ClipBake | None = None
        self._again_at = 0.0  # time.perf_counter() of the next attempt, while a clip waits to be moved to its place
        while self._waiting and self._running is None:
            name = self._waiting.pop(0)
            if name in bpy.data.objects:
                self._began = time.perf_counter()
                self._running = self._begin(context, bpy.data.objects[name])

    def _step_until(self, context: bpy.types.Context, until: float) -> None:
        """Solve samples until this time or until the object is done. Then the next object begins."""
        try:
            while time.perf_counter() < until:
                if not self._running.step():
                    self._finish(self._running)
                    self._next(context)
                    return
        except BakeError as error:
            if isinstance(error, clip.NotInPlace) and until != float("inf"):
                self._wait(context, error)
                return
            self._give_up(self._running, error)
            self._next(context)

    def _wait(self, context: bpy.types.Context, error: clip.NotInPlace) -> None:
        """Wait while another program has the file open, because the bake may have taken hours. Esc gives it up."""
        text = said(f"The baked clip waits until it can be put in place, Esc gives it up: {error}")
        if self._again_at == 0.0:
            self.report({"WARNING"}, text)
        self._again_at = time.perf_counter() + WAIT_SECONDS
        self.show_status(context, text)

    def _end(self) -> set[str]:
        if self.every and self._baked:
            self.report({"INFO"}, said(f"Baked {self._baked} objects"))
        return {"FINISHED"} if self._baked else {"CANCELLED"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if bpy.app.background:
            return self.execute(context)
        if baking.is_running():  # by a bake in another window: each would stop the other's garments
            self.report({"WARNING"}, said("Another bake is under way: wait for it, or press Esc in its window"))
            return {"CANCELLED"}
        self._line_up(context)
        self._next(context)
        if self._running is None:
            return {"CANCELLED"}
        return self.begin_modal(context, PARTS, 0.01)

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC":
            self.end_modal(context)
            self._give_up(self._running, BakeError(f"Bake cancelled: {self._running.name} is as it was before"), "INFO")
            return self._end()
        if event.type != "TIMER" or time.perf_counter() < self._again_at:
            return {"RUNNING_MODAL"}
        self._step_until(context, time.perf_counter() + STEP_SECONDS)
        if self._running is None:
            self.end_modal(context)
            return self._end()
        if self._again_at == 0.0:
            self._show_progress(context)
        return {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Called if another file is opened or the window is closed."""
        self.end_modal(context)
        if self._running is not None:
            self._running.cancel()

    def _show_progress(self, context: bpy.types.Context) -> None:
        done, count = self._running.done, self._running.playback.count
        context.window_manager.progress_update(done * PARTS // max(count, 1))
        left = duration.left(time.perf_counter() - self._began, done, count)
        text = said(f"Baking wrinkles: {done} of {count} samples, about {left} left. Esc cancels" if left else
                    f"Baking wrinkles: {done} of {count} samples. Esc cancels")
        self.show_status(context, f"{self._running.name}: {text}" if self.every else text)

    def _begin(self, context: bpy.types.Context, obj: bpy.types.Object) -> clip.ClipBake | None:
        try:
            return clip.ClipBake(context, obj)
        except BakeError as error:
            self.report({"ERROR"}, said(str(error)))
            return None

    def _give_up(self, bake: clip.ClipBake, error: Exception, kind: str = "ERROR") -> None:
        bake.cancel()
        self.report({kind}, said(str(error)))

    def _finish(self, bake: clip.ClipBake) -> None:
        """Finish the bake of one object. Raises BakeError."""
        written = bake.finish()
        self._baked += 1
        clip_range.keep(bake.obj, bake.playback.scene, bake.playback.start, bake.playback.end)
        note = bake.note + (UNSAVED if clip_place.is_temporary(written) else "")
        self.report({"WARNING"} if note else {"INFO"},
                    said(f"Baked {bake.writer.manifest.sample_count} samples to {written}{note}"))


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
        return ui_base.may_run(cls, "" if modifier.is_baked(modifier.find(context.object)) else "Nothing is baked")

    def execute(self, context: bpy.types.Context) -> set[str]:
        note = clip.free(context.object, self.delete_file)
        if note:
            self.report({"WARNING"}, said(note))
        return {"FINISHED"}


class OBJECT_OT_rumple_bake_shape_keys(ui_base.OnWrinkled, bpy.types.Operator):
    """Make a new mesh object with a shape key for each frame, for exporters. FBX: switch off NLA Strips, All Actions"""

    bl_idname = "object.rumple_bake_shape_keys"
    bl_label = "Bake to Shape Keys"

    start: bpy.props.IntProperty(name="Start", description="First frame; unset: as for the bake", options={"SKIP_SAVE"})
    end: bpy.props.IntProperty(name="End", description="Last frame; unset: as for the bake", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        start, end = units.bake_range(obj, context.scene)
        start = self.start if self.properties.is_property_set("start") else start
        end = self.end if self.properties.is_property_set("end") else end
        playback = None
        try:
            playback = Playback(context, obj, start, end, 1)
            shapes = [result.positions.copy() for wanted, result, _ in playback.samples_in_order() if wanted]
        except BakeError as error:
            return ui_base.refuse(self, error)
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
