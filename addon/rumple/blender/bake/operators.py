# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking: the played-through clip into a PC2 file that Blender's own Mesh Cache shows, or into shape keys.

A baked clip needs neither this add-on nor a handler: a render farm shows it as any other cache.
"""
from __future__ import annotations

import time
from pathlib import Path
from typing import Iterator

import bpy
import numpy as np

from ...core import engine
from ...core import clip_file
from .. import compat, scheduler, ui_base
from ..frame import clip_status, path_curves, rebuild
from ..objects import messages, modifier, output_mesh, runtimes
from ..viewport import preview

FOLDER = "//rumple"
SUFFIX = ".clip"
STEP_SECONDS = 0.05  # the window stays alive: solve for so long between two redraws


class BakeError(RuntimeError):
    """Why a bake cannot be made or go on, in words."""


class Playback:
    """Plays an object through a range of frames and hands out what was solved."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, start: int, end: int, samples: int) -> None:
        if end < start:
            raise BakeError(f"The last frame ({end}) is before the first ({start})")
        self.scene, self.obj = context.scene, obj
        self.start, self.end, self.samples = start, end, samples
        self.now = self.scene.frame_current, self.scene.frame_subframe
        self.pre_roll = list(range(min(self.scene.frame_start, start), start))
        self.analyzes = obj.rumple.bake_whole_clip and clip_status.sees_ahead(obj, context.scene)
        self.count = len(self.pre_roll) + (end - start) * samples + 1
        if self.analyzes:
            self.count += len(self.pre_roll) + end - start + 1
        ours = modifier.find(obj)
        self.passes = 2 if modifier.depends_on_wrinkled(obj) else 1  # the other one is solved in the first pass
        self.was_baked = modifier.is_baked(ours)
        if self.was_baked:
            modifier.set_baked(ours, False)
            runtimes.of(obj).stale = True
        scheduler.sync_all()

    def samples_in_order(self) -> Iterator[tuple[bool, engine.Picture | None, np.ndarray | None]]:
        """(wanted, picture, coarse positions) of every sample. Not wanted: those of the pre-roll, and without a picture
        the frames of a first pass that only looks at the clip."""
        if self.analyzes:
            for _ in self._analyze():
                yield False, None, None
        for frame in self.pre_roll:
            yield False, *self._solve(frame, 0.0)
        for sample in range((self.end - self.start) * self.samples + 1):
            whole, part = divmod(sample, self.samples)
            yield True, *self._solve(self.start + whole, part / self.samples)

    def _analyze(self) -> Iterator[None]:
        """Read the pose of every whole frame; the solver then knows the clip. Memory: 12 bytes a vertex and frame."""
        entry, clip = runtimes.of(self.obj), {}
        entry.analyzing = True
        for frame in (*self.pre_roll, *range(self.start, self.end + 1)):
            self._visit(frame, 0.0)
            if entry.analyzed is None or entry.analyzed.frame != frame:
                raise BakeError(f"{self.obj.name}: nothing is seen at frame {frame}: is the modifier off?")
            clip[float(frame)] = entry.analyzed.positions
            yield
        entry.analyzing = False
        try:
            entry.evaluator.look_at_clip(clip, entry.analyzed.settings, frame_rate=entry.analyzed.frame_rate)
        except engine.Refused as error:
            raise BakeError(str(error)) from error
        entry.invalidate_output()  # what is shown was solved as live

    def _visit(self, frame: int, subframe: float) -> runtimes.Runtime:
        with preview.paused():
            for _ in range(self.passes):
                self.scene.frame_set(frame, subframe=subframe)
        entry = runtimes.of(self.obj)
        if entry.refusal or entry.message:
            raise BakeError(f"frame {frame + subframe:g}: {entry.refusal or entry.message}")
        return entry

    def _solve(self, frame: int, subframe: float) -> tuple[engine.Picture, np.ndarray]:
        entry = self._visit(frame, subframe)
        if entry.picture is None or entry.inputs is None or abs(entry.inputs.frame - frame - subframe) > 1e-3:
            raise BakeError(f"{self.obj.name}: nothing is solved at frame {frame + subframe:g}: is the modifier off?")
        return entry.picture, entry.inputs.positions

    def note(self) -> str:
        """What is odd about what was solved, for the report; empty when nothing is."""
        fine = runtimes.of(self.obj).evaluator
        strayed = sorted(fine.strayed) if fine is not None else []
        return (f". {len(strayed)} frames were not as they had been looked at (first: {strayed[0]:g}): they were "
                "solved as in playback") if strayed else ""

    def end_playback(self, restore_bake: bool) -> None:
        entry = runtimes.of(self.obj)
        if self.analyzes and entry.evaluator is not None:
            entry.analyzing, entry.analyzed = False, None
            entry.evaluator.look_at_clip({}, None)
            entry.invalidate_output()
        if restore_bake and self.was_baked:
            modifier.set_baked(modifier.find(self.obj), True)
        self.scene.frame_set(self.now[0], subframe=self.now[1])


# ---------------------------------------------------------------- the clip
def new_clip_path(obj: bpy.types.Object) -> Path:
    """Where the clip of an object belongs. Raises BakeError."""
    folder = obj.rumple.bake_folder or FOLDER
    if folder.startswith("//") and not bpy.data.filepath:
        raise BakeError("Save the file first: the bake is stored beside it")
    return Path(bpy.path.abspath(folder)) / f"{bpy.path.clean_name(obj.name)}.pc2"


def stored_path(path: Path) -> str:
    """How the file is written into the blend file: relative where possible, with forward slashes on any system."""
    text = str(path)
    if bpy.data.filepath:
        try:
            text = bpy.path.relpath(text)
        except ValueError:
            pass  # another drive on Windows
    return text.replace("\\", "/")


def attach(obj: bpy.types.Object, manifest: clip_file.Manifest, clip: Path) -> None:
    """Show the clip, through a new cache object: a former one may belong to a duplicate too."""
    ours = modifier.find(obj)
    cache_object = make_cache_object(obj, modifier.output_object(ours).data)
    modifier.add_mesh_cache(cache_object, manifest, stored_path(clip))
    modifier.set_cache_object(ours, cache_object)
    modifier.set_baked(ours, True)
    runtimes.of(obj).stale = True


def make_cache_object(obj: bpy.types.Object, shown: bpy.types.Mesh) -> bpy.types.Object:
    """A hidden object with the points of a clip, at rest: that is what shows where the clip cannot be read."""
    attributes = modifier.system(modifier.find(obj)).wrinkles.ATTRIBUTES
    rest = engine.Picture.at_rest(compat.positions(shown), len(shown.loops), attributes)
    points = clip_file.points_of(rest, attributes)
    mesh = bpy.data.meshes.new(obj.name + SUFFIX)
    mesh.vertices.add(len(points))
    compat.set_positions(mesh, points)
    mesh.update()
    cache_object = bpy.data.objects.new(mesh.name, mesh)
    cache_object[output_mesh.KEY] = True
    return cache_object


def free(obj: bpy.types.Object, delete_file: bool) -> None:
    """Make the wrinkles live again."""
    ours = modifier.find(obj)
    clip = clip_status.clip_path(obj)
    modifier.set_cache_object(ours, None)
    modifier.set_baked(ours, False)
    for child in path_curves.of(obj):
        path_curves.free(child)
    if delete_file and clip is not None:
        clip_file.delete(clip)
        path_curves.clip_path(clip).unlink(missing_ok=True)
    entry = runtimes.of(obj)
    entry.stale = True
    entry.invalidate_output()
    messages.set_frame_error(entry, "")
    scheduler.sync_all()


class _Bake:
    """One running bake: step() until it says that nothing is left."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        about = obj.rumple
        clip = new_clip_path(obj)
        self.obj, self.done = obj, 0
        self.playback = Playback(context, obj, about.bake_start, about.bake_end, about.bake_samples)
        fine = runtimes.of(obj).evaluator
        if fine is None:
            self.playback.end_playback(restore_bake=True)
            raise BakeError(runtimes.message(obj) or f"{obj.name}: there is nothing to bake")
        manifest = clip_file.Manifest(
            object=obj.name, vertices=fine.vertex_count,
            points=clip_file.point_count(fine.vertex_count, len(fine.corner_vertex), fine.ATTRIBUTES),
            coarse_vertices=len(obj.data.vertices), start=about.bake_start, end=about.bake_end,
            samples=about.bake_samples, inputs=clip_status.inputs_fingerprint(obj, context.scene))
        self.writer = clip_file.ClipWriter(clip, manifest, fine.ATTRIBUTES)
        self.curves = path_curves.Recorder(obj)
        self.samples = self.playback.samples_in_order()

    def step(self) -> bool:
        """Solve and write one sample. False after the last."""
        try:
            wanted, picture, coarse = next(self.samples)
        except StopIteration:
            return False
        if wanted:
            self.writer.add(picture, coarse)
            self.curves.add()
        self.done += 1
        return True

    def finish(self) -> Path:
        self.writer.finish()
        self.curves.finish(self.writer.manifest, self.writer.clip, stored_path)
        attach(self.obj, self.writer.manifest, self.writer.clip)
        self.note = self.playback.note()
        self.playback.end_playback(restore_bake=False)
        scheduler.sync_all()
        return self.writer.clip

    def cancel(self) -> None:
        self.writer.discard()
        self.playback.end_playback(restore_bake=True)


# ---------------------------------------------------------------- operators
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
        except (BakeError, OSError) as error:
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
        except (BakeError, OSError) as error:
            self._end_modal(context)
            return self._give_up(self._running, error)
        self._show_progress(context)
        return {"RUNNING_MODAL"}

    def _show_progress(self, context: bpy.types.Context) -> None:
        done, count = self._running.done, self._running.playback.count
        context.window_manager.progress_update(done)
        if context.workspace is not None:
            context.workspace.status_text_set(f"Baking wrinkles: {done} of {count} samples. Esc cancels")

    def _end_modal(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def _begin(self, context: bpy.types.Context) -> _Bake | None:
        try:
            return _Bake(context, context.object)
        except (BakeError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return None

    def _give_up(self, bake: _Bake, error: Exception, kind: str = "ERROR") -> set[str]:
        bake.cancel()
        self.report({kind}, str(error))
        return {"CANCELLED"}

    def _finish(self, bake: _Bake) -> set[str]:
        try:
            clip = bake.finish()
        except OSError as error:
            return self._give_up(bake, error)
        self.report({"WARNING"} if bake.note else {"INFO"},
                    f"Baked {bake.writer.manifest.sample_count} samples to {clip}{bake.note}")
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
            cls.poll_message_set("Nothing is baked")
        return baked

    def execute(self, context: bpy.types.Context) -> set[str]:
        free(context.object, self.delete_file)
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
            shapes = [picture.positions.copy() for wanted, picture, _ in playback.samples_in_order() if wanted]
        except BakeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            if playback is not None:
                playback.end_playback(restore_bake=True)
        copy = shape_key_object(context, obj, shapes, start)
        self.report({"INFO"}, f"{copy.name}: {len(shapes)} shape keys")
        return {"FINISHED"}


def shape_key_object(context: bpy.types.Context, obj: bpy.types.Object, shapes: list[np.ndarray],
                     start: int) -> bpy.types.Object:
    """A copy of obj whose mesh is the fine one, moved by absolute shape keys; later modifiers stay."""
    mesh = modifier.output_object(modifier.find(obj)).data.copy()
    copy = obj.copy()
    mesh.name = copy.name = f"{obj.name} shape keys"
    last = list(copy.modifiers).index(modifier.find(copy))
    for name in [m.name for m in copy.modifiers][:last + 1]:
        copy.modifiers.remove(copy.modifiers[name])
    copy.data = mesh
    copy.rumple.method = "NONE"
    rebuild.drop_internal_attributes(copy)
    for collection in obj.users_collection or (context.scene.collection,):
        collection.objects.link(copy)
    copy.shape_key_add(name="Rest")
    keys = mesh.shape_keys
    keys.use_relative = False
    for number, shape in enumerate(shapes):
        key = copy.shape_key_add(name=f"Frame {start + number}", from_mix=False)
        key.data.foreach_set("co", np.ascontiguousarray(shape, np.float32).ravel())
    _key_evaluation_time(keys, start)
    return copy


def _key_evaluation_time(keys: bpy.types.Key, start: int) -> None:
    """One key of evaluation time for every frame: each shows its own shape exactly."""
    for number, block in enumerate(keys.key_blocks[1:]):
        block.interpolation = "KEY_LINEAR"
        keys.eval_time = block.frame
        keys.keyframe_insert("eval_time", frame=start + number)
    for curve in compat.action_curves(keys.animation_data.action):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


CLASSES = (OBJECT_OT_rumple_bake, OBJECT_OT_rumple_bake_free, OBJECT_OT_rumple_bake_shape_keys)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
