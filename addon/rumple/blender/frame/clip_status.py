# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks whether the baked clip of an object exists and is up to date, with messages for panel and console."""
from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import bpy

from ...core.files import clip_file
from ...core.files.clip_manifest import ClipFault, Manifest
from ...core.settings.system_settings import SystemSettings
from .. import compat, scheduler
from ..objects import (bodies, clip_place, evaluator, held_by_others, incoming_mesh, mesh_reader, messages, modifier,
                       posed_coarse, point_caches, properties, runtimes, stack_notes, units)
from ..objects.runtimes import Runtime
from . import path_curves


def clip_path(obj: bpy.types.Object) -> Path | None:
    """The absolute path of the clip, from the Mesh Cache modifier of a baked object's cache object."""
    cache_object = modifier.cache_object(modifier.find(obj))
    cache = modifier.mesh_cache(cache_object) if cache_object is not None else None
    if cache is None or not cache.filepath:
        return None
    return Path(bpy.path.abspath(cache.filepath, library=cache_object.library))


def sees_ahead(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether a bake of it can analyse the whole clip first. It cannot over a body, because the solved shape is not
    known in advance."""
    return properties.settings_of(obj, scene).sees_ahead and not bodies.of(obj)


def is_independent(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether each frame is solved independently of the frames before it, and of the frames of other wrinkled
    objects."""
    return properties.settings_of(obj, scene).stateless and stands_alone(obj)


def stands_alone(obj: bpy.types.Object) -> bool:
    """Whether its frames depend on no other state from frame to frame: no simulation is in front of its wrinkles, and
    other wrinkled objects show their clips."""
    others = [other for other in (*bodies.of(obj), modifier.depends_on_wrinkled(obj)) if other is not None]
    wrinkles = [modifier.find(other) for other in others]
    if is_simulated_in_front(obj):
        return False
    return all(modifier.plays_clip(nodes_mod) for nodes_mod in wrinkles if nodes_mod is not None)


def is_simulated_in_front(obj: bpy.types.Object) -> bool:
    """Whether a simulation with its own state is in front of its wrinkles."""
    return any(m.type in ("CLOTH", "SOFT_BODY") or modifier.is_simulation_nodes(m) for m in modifier.in_front(obj))


def inputs_fingerprint(obj: bpy.types.Object, scene: bpy.types.Scene) -> str:
    """Hash of all inputs of a clip except the animation (meshes, settings, frame rate, paint, bodies and their
    wrinkles), and its first frame. scene: the scene in which it is played."""
    given = _content_of_bodies(obj) + _frame_rate(obj, scene) + _wrinkles_under(obj)
    return f"{_fingerprint(obj, scene, given, None)}@{units.first_frame(obj, scene)}"


def is_baked_from(inputs: str, obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether a clip's fingerprint matches the current inputs. A clip with an earlier first frame also matches, because
    artists move Start to render a part again."""
    fingerprint, _, begun = inputs.partition("@")
    first = units.first_frame(obj, scene)
    if not begun:  # from an older Rumple, with the names of the bodies
        names = "".join(body.name_full for body in bodies.of(obj))
        return fingerprint == _fingerprint(obj, scene, names.encode(), first)
    if not begun.lstrip("-").isdecimal() or int(begun) > first:
        return False
    now, rate = _content_of_bodies(obj), _frame_rate(obj, scene)
    # from an older Rumple: without the wrinkles of the bodies, and from one before it, without the frame rate
    known = (now + rate + _wrinkles_under(obj), now + rate, now)
    return any(fingerprint == _fingerprint(obj, scene, each, None) for each in known)


def _frame_rate(obj: bpy.types.Object, scene: bpy.types.Scene) -> bytes:
    """The frame rate, if the frames depend on it."""
    reads_time = properties.still_settings(obj, units.scene_of(obj)).reads_time
    return repr(units.frame_rate(scene)).encode() if reads_time else b""


def _fingerprint(obj: bpy.types.Object, scene: bpy.types.Scene, given: bytes, first: int | None) -> str:
    """given: what else it was baked from."""
    digest = hashlib.sha1(evaluator.sources(obj).shape.encode())
    settings = properties.still_settings(obj, units.scene_of(obj))
    digest.update(repr(settings if first is None else (settings, first)).encode())
    if sees_ahead(obj, scene):
        digest.update(b"whole" if obj.rumple.bake_whole_clip else b"live")
    _add_paint(digest, obj, settings)
    digest.update(given)
    return digest.hexdigest()


def _add_paint(digest: Any, obj: bpy.types.Object, settings: SystemSettings) -> None:
    for key, weights in sorted(mesh_reader.paint(obj, settings).items()):
        digest.update(key.encode() + weights.tobytes())


def _content_of_bodies(obj: bpy.types.Object) -> bytes:
    """Hash of the bodies' rest meshes. Names are not used, because they change when a character is linked, overridden
    or duplicated."""
    return b"".join(sorted(map(_content, bodies.of(obj))))


def _wrinkles_under(obj: bpy.types.Object) -> bytes:
    """Hash of the settings and the paint of all wrinkled objects that a garment is worn over."""
    found = []
    for under in bodies.all_under(obj):
        if modifier.find(under) is not None:
            settings = properties.still_settings(under, units.scene_of(under))
            digest = hashlib.sha1(repr(settings).encode())
            _add_paint(digest, under, settings)
            found.append(digest.digest())
    return b"".join(sorted(found))


def _content(body: bpy.types.Object) -> bytes:
    if body.type == "MESH":
        return _content_of_mesh(incoming_mesh.of(body))
    try:
        return _content_of_mesh(body.to_mesh())
    finally:
        body.to_mesh_clear()


def _content_of_mesh(mesh: bpy.types.Mesh | None) -> bytes:
    digest = hashlib.sha1()
    if mesh is not None:
        for array in (mesh_reader.basis_positions(mesh), compat.corner_vertices(mesh),
                      compat.indices(mesh.polygons, "loop_total")):
            digest.update(array.tobytes())
    return digest.digest()


# ---------------------------------------------------------------- the file
class _Seen:
    """The cached state of a clip. It is valid until the clip or its manifest changes."""

    def __init__(self, clip: Path, signature: tuple) -> None:
        self.signature = signature
        self.manifest: Manifest | None = None
        self.fault = ""
        self.unread = False  # it exists but could not be read: try again
        self.whole: dict[int, bool] = {}  # by sample
        try:
            self.manifest = clip_file.read_manifest(clip)
        except ClipFault as error:
            self.fault, self.unread = str(error), isinstance(error.__cause__, OSError)

    def is_whole(self, clip: Path, sample: int) -> bool:
        if sample not in self.whole:
            try:
                self.whole[sample] = clip_file.sample_is_whole(clip, self.manifest, sample)
            except OSError:  # e.g. a network drive: try again at the next frame
                return False
        return self.whole[sample]


_seen: dict[Path, _Seen] = {}


def forget_all() -> None:
    """Forget the clips of the former file."""
    _seen.clear()


def _look(clip: Path) -> _Seen:
    signature = tuple(_signature(path) for path in (clip, clip_file.manifest_path(clip)))
    if clip not in _seen or _seen[clip].signature != signature or _seen[clip].unread:
        _seen[clip] = _Seen(clip, signature)
    return _seen[clip]


def _signature(path: Path) -> tuple[int, int] | None:
    try:
        now = path.stat()
    except (OSError, ValueError):
        return None
    return now.st_mtime_ns, now.st_size


def manifest(clip: Path) -> Manifest | None:
    """The manifest of a clip; None if there is none, or it cannot be read."""
    return _look(clip).manifest


def cannot_play(obj: bpy.types.Object, output_object: bpy.types.Object, frame: float | None = None) -> str:
    """Why the clip of a baked object cannot be shown (at a frame, if it is given); empty if it can."""
    clip = clip_path(obj)
    if clip is None:
        return f"{obj.name}: the baked clip is not named any more: bake again, or free the bake"
    seen = _look(clip)
    if seen.signature[0] is None:
        return f"{obj.name}: the baked clip {clip} is missing{_INSTEAD}"
    if seen.fault:
        return f"{obj.name}: the baked clip {clip.name} cannot be shown: {seen.fault}{_INSTEAD}"
    about = seen.manifest
    if about is None:
        return ""  # check() reports this
    arriving = len(incoming_mesh.of(obj).vertices)
    if about.coarse_vertices != arriving:
        return (f"{obj.name}: its mesh has {arriving} vertices, {about.coarse_vertices} were baked, so live folds are "
                "shown: bake again, or free the bake")
    if about.vertices != len(output_object.data.vertices):
        return f"{obj.name}: the baked clip {clip.name} is of another fine mesh{_INSTEAD}"
    files = [clip]
    if about.curves and any(modifier.mesh_cache(child) is not None for child in path_curves.of(obj)):
        files.append(path_curves.clip_path(clip))
        curves = _look(files[-1]).manifest
        if curves is None or clip_file.checksum(curves) != about.curves:
            return f"{obj.name}: the path curves {files[-1].name} are not those of the baked clip{_INSTEAD}"
    # A shutter may open half a frame earlier, and close half a frame later.
    if frame is not None and not about.start - 0.5 <= frame <= about.end + 0.5:
        return (f"{obj.name}: frame {frame:g} is outside the bake ({about.start} to {about.end}), so live folds are "
                "shown there")
    for file in files if frame is not None else ():
        for sample in about.samples_around(frame):
            if not _look(file).is_whole(file, sample):
                return (f"{obj.name}: frame {about.start + sample / about.samples:g} of the baked clip {file.name} is "
                        f"damaged{_INSTEAD}")
    return ""


_INSTEAD = ", so live folds are shown. Bring the file back, bake again, or free the bake"


def check(obj: bpy.types.Object, output_object: bpy.types.Object) -> str:
    """An error message about the clip of a baked object, or an empty text. The pose is not compared."""
    text = cannot_play(obj, output_object)
    if text:
        return text
    clip = clip_path(obj)
    about = manifest(clip) if clip is not None else None
    if clip is None or about is None:
        return f"{obj.name}: the baked clip {clip.name if clip else ''} has no manifest, so nobody knows what it was " \
               "baked from: bake again"
    if clip_place.is_temporary(clip) and bpy.data.filepath:
        return f"{obj.name}: the clip was baked before the file was saved, and goes when Blender quits: bake again"
    if not any(is_baked_from(about.inputs, obj, scene) for scene in obj.users_scene or (units.scene_of(obj),)):
        return f"{obj.name}: meshes, settings, frame rate, paint or bodies changed since the bake: bake again to see it"
    return ""


def on_save() -> None:
    """Called after the file was saved. A clip that was baked before is in a folder that Blender deletes, and nothing
    that follows would let it be checked before that."""
    for obj, nodes_mod in modifier.wrinkled_objects():
        clip = clip_path(obj) if modifier.is_baked(nodes_mod) else None
        if clip is not None and clip_place.is_temporary(clip):
            runtimes.of(obj).stale = True
            scheduler.request()


# ---------------------------------------------------------------- frames
def compare_pose(obj: bpy.types.Object, runtime: Runtime, depsgraph: bpy.types.Depsgraph, frame: float) -> str:
    """The note on this frame of a baked object: its animation may have changed, or the clip may not have this frame."""
    clip = clip_path(obj)
    about = manifest(clip) if clip is not None else None
    if about is None or runtime.bake_note:
        return runtime.bake_note
    sample = about.sample_of(frame)
    if sample is None:
        return ""
    positions = posed_coarse.positions(obj, about.coarse_vertices, depsgraph)
    if positions is not None and about.pose_differs(sample, positions):
        return f"{obj.name}: the pose of frame {frame:g} is not the baked one: bake again"
    return ""


def late_in_renders(obj: bpy.types.Object) -> str:
    """A warning about an unbaked object that follows another wrinkled one; empty for others.

    Blender calls handlers once per frame. Both objects are solved there, when the follower's coarse mesh does not yet
    have the other's new folds. In the window another update follows (_tag_dependents), in a bake another pass.
    """
    other = modifier.depends_on_wrinkled(obj)
    if other is None:
        return ""
    return f"{obj.name}: it follows {other.name}, wrinkled too: renders show its folds one frame late. Bake it"


def _not_made_yet(obj: bpy.types.Object) -> str:
    """A warning about changes that have not been rebuilt yet."""
    runtime = runtimes.known(obj)
    if runtime is None or not runtime.stale:
        return ""
    return f"{obj.name}: it was changed, and its folds are not made anew yet: the former ones are shown, or none"


def check_before_render() -> None:
    """Print warnings about missing, outdated or late folds, and lost caches, before a long render."""
    for obj, nodes_mod in modifier.wrinkled_objects():
        with messages.console_errors(obj.name):
            output_obj = modifier.output_object(nodes_mod)
            if output_obj is None:
                continue
            jumps = stack_notes.skipped_frames(obj) + stack_notes.resumed(obj)
            text = check(obj, output_obj) if modifier.is_baked(nodes_mod) else \
                _not_made_yet(obj) or late_in_renders(obj) or next(iter(jumps), "")
            for sentence in [text] * bool(text) + held_by_others.notes(obj) + point_caches.notes(obj):
                print(f"Rumple: before rendering: {sentence}")
