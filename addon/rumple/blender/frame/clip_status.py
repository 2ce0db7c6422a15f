# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the baked clip of an object is there and still right, in a sentence for panel and console."""
from __future__ import annotations

import functools
import hashlib
from pathlib import Path

import bpy

from ...core import clip_file
from ..objects import bodies, coarse_copy, evaluator, mesh_reader, messages, modifier, properties, units
from ..objects.runtimes import Runtime


def clip_path(obj: bpy.types.Object) -> Path | None:
    """The file that the Mesh Cache of a baked object's cache object reads, absolute."""
    cache_object = modifier.cache_object(modifier.find(obj))
    cache = modifier.mesh_cache(cache_object) if cache_object is not None else None
    if cache is None or not cache.filepath:
        return None
    return Path(bpy.path.abspath(cache.filepath, library=cache_object.library))


def sees_ahead(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether a bake of it may look at the whole clip first: over a body what is solved is not known before."""
    return properties.settings_of(obj, scene).sees_ahead and not bodies.of(obj)


def inputs_fingerprint(obj: bpy.types.Object, scene: bpy.types.Scene) -> str:
    """Hash of everything that makes a clip but the animation: meshes, settings, paint, names of bodies, first frame."""
    digest = hashlib.sha1(evaluator.sources(obj).shape.encode())
    settings = properties.settings_of(obj, scene)
    digest.update(repr((settings, scene.frame_start)).encode())
    if sees_ahead(obj, scene):
        digest.update(b"whole" if obj.rumple.bake_whole_clip else b"live")
    for key, weights in sorted(mesh_reader.paint(obj, settings).items()):
        digest.update(key.encode() + weights.tobytes())
    for body in bodies.of(obj):
        digest.update(body.name_full.encode())
    return digest.hexdigest()


@functools.lru_cache(maxsize=64)
def _manifest(clip: Path, _modified: int) -> clip_file.Manifest | None:
    return clip_file.read_manifest(clip)


def manifest(clip: Path) -> clip_file.Manifest | None:
    """The manifest of a clip, read again when the file changed."""
    try:
        modified = clip_file.manifest_path(clip).stat().st_mtime_ns
    except OSError:
        return None
    return _manifest(clip, modified)


def check(obj: bpy.types.Object, output_object: bpy.types.Object) -> str:
    """What is wrong with the clip of a baked object; empty when nothing is. The pose is not looked at."""
    clip = clip_path(obj)
    if clip is None or not clip.is_file():
        return f"{obj.name}: the baked clip {clip or ''} is missing: bake again, or free the bake"
    about = manifest(clip)
    if about is None:
        return f"{obj.name}: the manifest beside {clip.name} is missing: nobody knows what it was baked from"
    if not clip_file.is_whole(clip, about) or about.vertices != len(output_object.data.vertices):
        return f"{obj.name}: the baked clip {clip.name} does not fit the fine mesh: bake again"
    if about.inputs != inputs_fingerprint(obj, units.scene_of(obj)):
        return f"{obj.name}: meshes, settings, paint or bodies changed since the bake: bake again to see it"
    return ""


def compare_pose(obj: bpy.types.Object, runtime: Runtime, depsgraph: bpy.types.Depsgraph, frame: float) -> str:
    """The note on this frame of a baked object: its animation may have changed, or the clip may not have it."""
    clip = clip_path(obj)
    about = manifest(clip) if clip is not None else None
    if about is None or runtime.bake_note:
        return runtime.bake_note
    sample = about.sample_of(frame)
    if sample is None:
        outside = not about.start <= frame <= about.end
        return f"{obj.name}: frame {frame:g} is outside the bake ({about.start} to {about.end})" if outside else ""
    try:
        positions = coarse_copy.posed_positions(obj, about.coarse_vertices, depsgraph)
    except mesh_reader.Reordered:  # the clip needs none of them
        return ""
    if positions is not None and about.pose_differs(sample, positions):
        return f"{obj.name}: the pose of frame {frame:g} is not the baked one: bake again"
    return ""


def late_in_renders(obj: bpy.types.Object) -> str:
    """What an unbaked object that follows another wrinkled one has to know; empty for others.

    Blender calls handlers once a frame: both are solved there, when the follower's coarse mesh does not have the
    other's new folds yet. In the window another update follows (_tag_dependents), in a bake another pass.
    """
    other = modifier.depends_on_wrinkled(obj)
    if other is None:
        return ""
    return f"{obj.name}: it follows {other.name}, wrinkled too: renders show its folds one frame late. Bake it"


def check_before_render() -> None:
    """Say on the console what is missing, stale or late, before hours are spent on it."""
    for obj, nodes_mod in modifier.wrinkled_objects():
        with messages.console_errors(obj.name):
            output_obj = modifier.output_object(nodes_mod)
            text = "" if output_obj is None else check(obj, output_obj) if modifier.is_baked(nodes_mod) else \
                late_in_renders(obj)
            if text:
                print(f"Rumple: before rendering: {text}")
