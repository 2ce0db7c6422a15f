# SPDX-License-Identifier: GPL-3.0-or-later
"""The clip of an object: baking it, showing it in place of the live wrinkles, and going back to these.

A baked clip needs neither this add-on nor a handler: a render farm shows it as any other cache.
"""
from __future__ import annotations

from pathlib import Path

import bpy

from ...core import clip_file, engine
from .. import compat, scheduler
from ..frame import clip_status, path_curves
from ..objects import messages, modifier, output_mesh, runtimes
from .playback import BakeError, Playback

FOLDER = "//rumple"
SUFFIX = ".clip"


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
    nodes_mod = modifier.find(obj)
    cache_object = make_cache_object(obj, modifier.output_object(nodes_mod).data)
    modifier.add_mesh_cache(cache_object, manifest, stored_path(clip))
    modifier.set_cache_object(nodes_mod, cache_object)
    modifier.set_baked(nodes_mod, True)
    runtimes.of(obj).stale = True


def make_cache_object(obj: bpy.types.Object, shown: bpy.types.Mesh) -> bpy.types.Object:
    """A hidden object with the points of a clip, at rest: that is what shows where the clip cannot be read."""
    attributes = modifier.system(modifier.find(obj)).wrinkles.ATTRIBUTES
    rest = engine.FrameResult.at_rest(compat.positions(shown), len(shown.loops), attributes)
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
    nodes_mod = modifier.find(obj)
    clip = clip_status.clip_path(obj)
    modifier.set_cache_object(nodes_mod, None)
    modifier.set_baked(nodes_mod, False)
    for child in path_curves.of(obj):
        path_curves.free(child)
    if delete_file and clip is not None:
        clip_file.delete(clip)
        path_curves.clip_path(clip).unlink(missing_ok=True)
    runtime = runtimes.of(obj)
    runtime.stale = True
    runtime.invalidate_output()
    messages.set_frame_error(runtime, "")
    scheduler.sync_all()


# ---------------------------------------------------------------- baking
class ClipBake:
    """One running bake: step() until it says that nothing is left."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        about = obj.rumple
        path = new_clip_path(obj)
        self.obj, self.done = obj, 0
        self.playback = Playback(context, obj, about.bake_start, about.bake_end, about.bake_samples)
        fine = runtimes.of(obj).evaluator
        if fine is None:
            self.playback.end_playback(restore_bake=True)
            raise BakeError(runtimes.message(obj) or f"{obj.name}: there is nothing to bake")
        manifest = clip_file.Manifest(
            object=obj.name, vertices=fine.vertex_count,
            points=clip_file.point_count(fine.vertex_count, len(fine.corner_vertex), fine.ATTRIBUTES),
            coarse_vertices=fine.coarse_count, start=about.bake_start, end=about.bake_end,
            samples=about.bake_samples, inputs=clip_status.inputs_fingerprint(obj, context.scene))
        self.writer = clip_file.ClipWriter(path, manifest, fine.ATTRIBUTES)
        self.curves = path_curves.Recorder(obj)
        self.samples = self.playback.samples_in_order()

    def step(self) -> bool:
        """Solve and write one sample. False after the last."""
        try:
            wanted, result, coarse = next(self.samples)
        except StopIteration:
            return False
        if wanted:
            self.writer.add(result, coarse)
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
