# SPDX-License-Identifier: GPL-3.0-or-later
"""The clip of an object: bakes it, shows it instead of the live wrinkles, and frees it again.

A baked clip needs neither this add-on nor a handler. A render farm shows it like any other cache.
"""
from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

import bpy

from ...core.base.wording import UserError
from ...core.files import clip_file, clip_folder
from ...core.files.clip_lock import Held, Lock
from ...core.files.clip_manifest import ClipFault, Manifest
from ...core.mesh.frame_result import Attribute, FrameResult
from .. import compat, scheduler
from ..frame import clip_status, path_curves
from ..objects import clip_place, messages, modifier, output_mesh, runtimes, units
from ..objects.clip_place import stored_path
from .playback import BakeError, Playback

SUFFIX = ".clip"


class NotInPlace(BakeError):
    """Everything is solved, but the clip cannot be moved to its place, perhaps only for a moment. finish() may be
    called again."""


def new_clip_path(obj: bpy.types.Object) -> Path:
    """The path for a new clip of an object. For an unsaved blend file it is in a folder that Blender deletes. If
    another object plays a clip at this path (after a rename or a duplication), a number is added."""
    place, own = clip_place.of(obj) or clip_place.until_saved(obj), clip_status.clip_path(obj)
    taken = [clip_status.clip_path(other) for other in _others_baked(obj)]
    paths = [place, *(place.with_name(f"{place.stem}-{number}{place.suffix}") for number in range(2, len(taken) + 2))]
    free = [path for path in paths if path not in taken]
    return own if own is not None and own in free else free[0]


def _others_baked(obj: bpy.types.Object) -> list[bpy.types.Object]:
    return [other for other, nodes_mod in modifier.wrinkled_objects() if other != obj and modifier.is_baked(nodes_mod)]


def _file_name() -> str:
    return Path(bpy.data.filepath).stem


def attach(obj: bpy.types.Object, manifest: Manifest, clip: Path) -> None:
    """Show the clip through a new cache object, because a former one may also belong to a duplicate."""
    nodes_mod = modifier.find(obj)
    cache_object = make_cache_object(obj, modifier.output_object(nodes_mod).data)
    modifier.add_mesh_cache(cache_object, manifest, stored_path(clip))
    modifier.set_cache_object(nodes_mod, cache_object)
    modifier.set_baked(nodes_mod, True)
    modifier.play_clip(nodes_mod, True)
    runtimes.of(obj).stale = True


def make_cache_object(obj: bpy.types.Object, shown: bpy.types.Mesh) -> bpy.types.Object:
    """A hidden object with the points of a clip at rest. They are shown if the clip cannot be read."""
    attributes = modifier.system(modifier.find(obj)).wrinkles.ATTRIBUTES
    rest = FrameResult.at_rest(compat.positions(shown), len(shown.loops), attributes)
    points = clip_file.points_of(rest, attributes)
    mesh = bpy.data.meshes.new(obj.name + SUFFIX)
    mesh.vertices.add(len(points))
    compat.set_positions(mesh, points)
    mesh.update()
    cache_object = bpy.data.objects.new(mesh.name, mesh)
    cache_object[output_mesh.KEY] = True
    return cache_object


def free(obj: bpy.types.Object, delete_file: bool) -> str:
    """Make the wrinkles live again. Returns a message about the file; empty if everything was done."""
    nodes_mod = modifier.find(obj)
    clip = clip_status.clip_path(obj)
    modifier.set_cache_object(nodes_mod, None)
    modifier.set_baked(nodes_mod, False)
    modifier.play_clip(nodes_mod, True)
    for child in path_curves.of(obj):
        path_curves.free(child)
    note = _delete(obj, clip) if delete_file and clip is not None else ""
    runtime = runtimes.of(obj)
    runtime.stale = True
    runtime.invalidate_output()
    messages.set_frame_error(runtime, "")
    scheduler.sync_all()
    return note


def _delete(obj: bpy.types.Object, clip: Path) -> str:
    """Delete the file of a freed clip, unless another object or file plays it. Returns why it was not deleted, or an
    empty text."""
    players = [other.name for other in _others_baked(obj) if clip_status.clip_path(other) == clip]
    about = clip_status.manifest(clip)
    if players:
        return f"{obj.name}: {clip.name} is kept, {players[0]} plays it too"
    if about is not None and about.file not in ("", _file_name()):
        return f"{obj.name}: {clip.name} is kept, it is the bake of the file {about.file}"
    try:
        clip_file.delete(clip)
        path_curves.clip_path(clip).unlink(missing_ok=True)
    except OSError as error:
        return f"{obj.name}: the clip is not deleted: {clip_folder.in_words(error, clip.parent)}"
    return ""


# ---------------------------------------------------------------- baking
class ClipBake:
    """One running bake. Call step() until it returns False, then finish(); or cancel() at any time.

    They raise only BakeError, whatever happens to the object or the disk meanwhile. cancel() restores the state before
    the bake.
    """

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        path = self._place(obj)
        self.obj, self.name, self.done, self.note = obj, obj.name, 0, ""
        self.writer: clip_file.ClipWriter | None = None
        self._is_sealed = False
        self.lock = self._take_lock(path)
        try:
            self._start(context, path)
        except BaseException:
            self._release()
            raise

    def _place(self, obj: bpy.types.Object) -> Path:
        return new_clip_path(obj)

    def _take_lock(self, path: Path) -> Lock | None:
        """Take the lock of the clip until the end of the bake. None: the caller already has it. Raises BakeError."""
        with self._faults():
            return Lock(path)

    def _release(self) -> None:
        if self.lock is not None:
            self.lock.release()

    def _start(self, context: bpy.types.Context, path: Path) -> None:
        obj = self.obj
        self.curves = path_curves.Recorder(obj, path)
        with self._faults():
            self.playback = self._make_playback(context)
        try:
            with self._faults():
                self._begin(context, path)
        except BakeError:
            self.cancel()
            raise
        self.samples = self.playback.samples_in_order()

    def _make_playback(self, context: bpy.types.Context) -> Playback:
        return Playback(context, self.obj, *units.bake_range(self.obj, context.scene), self.obj.rumple.bake_samples)

    def _begin(self, context: bpy.types.Context, path: Path) -> None:
        obj, about = self.obj, self.obj.rumple
        evaluator = runtimes.of(obj).evaluator
        if evaluator is None:
            raise BakeError(runtimes.message(obj) or f"{obj.name}: there is nothing to bake: add wrinkles first")
        manifest = Manifest(
            object=obj.name, vertices=evaluator.vertex_count,
            points=clip_file.point_count(evaluator.vertex_count, len(evaluator.corner_vertex), evaluator.ATTRIBUTES),
            coarse_vertices=evaluator.coarse_count, start=self.playback.start, end=self.playback.end,
            samples=about.bake_samples, inputs=clip_status.inputs_fingerprint(obj, context.scene), file=_file_name())
        self.writer = self._make_writer(path, manifest, evaluator.ATTRIBUTES)

    def _make_writer(self, path: Path, manifest: Manifest,
                     attributes: tuple[Attribute, ...]) -> clip_file.ClipWriter:
        return clip_file.ClipWriter(path, manifest, attributes)

    @contextmanager
    def _faults(self) -> Iterator[None]:
        try:
            yield
        except (BakeError, StopIteration):
            raise
        except ClipFault as error:
            raise BakeError(f"{self.name}: {error}") from error
        except UserError as error:  # the panel also shows it
            raise BakeError(str(error)) from error
        except Exception as error:  # another script or window deleted the object, loaded a file or edited the mesh
            raise BakeError(f"{self.name}: it, or its file, was changed while it was baked ({type(error).__name__}: "
                            f"{error}): bake again") from error

    def step(self) -> bool:
        """Solve and write one sample. Returns False after the last one."""
        with self._faults():
            if self.lock is not None:
                self.lock.touch()
            wanted, result, coarse = next(self.samples, (None, None, None))
            if wanted is None:
                return False
            if wanted:
                self.writer.add(result, coarse)
                self.curves.add()
        self.done += 1
        return True

    def finish(self) -> Path:
        """Move the clip to its place and show it. Raises NotInPlace if this can be tried again."""
        with self._faults():
            about = self.writer.manifest
            if not self._is_sealed:
                about.curves = self.curves.seal(about)
                self.writer.seal()
                self._is_sealed = True
            modifier.find(self.obj).name  # raises if the modifier is gone, while the bake can still be cancelled
            self._put_in_place()
            self.curves.play(stored_path)
            attach(self.obj, about, self.writer.clip)
            self.note = self.playback.note()
            self.playback.end_playback(restore_bake=False)
            scheduler.sync_all()
        self._release()
        return self.writer.clip

    def _put_in_place(self) -> None:
        """Move the clips of garment and curves to their places: both or none."""
        try:
            if self.lock is not None:
                self.lock.check()
            with self.curves.in_place():
                self.writer.commit()
        except Held:
            raise
        except ClipFault as error:
            raise NotInPlace(f"{self.name}: {error}") from error

    def cancel(self) -> None:
        """Cancel the bake. Never raises."""
        if self.writer is not None:
            self.writer.discard()
        self.curves.discard()
        self._release()
        with messages.console_errors(self.name):
            self.playback.end_playback(restore_bake=True)
