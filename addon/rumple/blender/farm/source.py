# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of everything that a clip is baked from. A clip, or a part of it, is only reused if all of it is equal."""
from __future__ import annotations

import glob
import hashlib
import re
from pathlib import Path
from typing import Iterator

import bpy

from ...core.files import attached_files, clip_file
from ...core.files.clip_manifest import ClipFault
from ...native import kernels
from ..frame import clip_status
from ..nodes import modifier_inputs
from ..objects import clip_place, modifier
from . import plan

_UNREADABLE = b"none"


def of_files() -> str:
    """Digest of the contents of the saved blend file and its linked files, and of the sizes and times of caches. Paths
    do not count, because drives and slashes differ between systems. It also counts whether scripts were run, because
    without its drivers the rig has another pose."""
    libraries = sorted(of_file(Path(bpy.path.abspath(library.filepath))) for library in bpy.data.libraries)
    parts = [of_file(Path(bpy.data.filepath)), *libraries, *sorted(map(_size_and_time, set(caches())))]
    if bpy.app.autoexec_fail:
        parts.append(b"without scripts")
    return hashlib.blake2b(b"".join(parts), digest_size=16).hexdigest()


def of_file(file: Path) -> bytes:
    """Digest of a file's content. A file that attach() saved, and that was not saved since, counts as the file that the
    clips were baked from."""
    found = content(file)
    return found if found == _UNREADABLE else attached_files.counts_as(clip_folders(), found)


def clip_folders() -> list[Path]:
    """The folders for clips of the open file."""
    places = (clip_place.of(obj) for obj, _ in modifier.wrinkled_objects())
    return sorted({place.parent for place in places if place is not None})


def _size_and_time(cache: Path) -> bytes:
    try:
        now = cache.stat()
    except OSError:
        return _UNREADABLE
    return repr((cache.name, now.st_size, now.st_mtime_ns)).encode("utf-8", "surrogatepass")


def of_garment(obj: bpy.types.Object, files: str) -> str:
    """Digest for one garment. files: of_files(). The clips of the objects under it count too."""
    digest = hashlib.blake2b(files.encode(), digest_size=16)
    for name in plan.needs(obj):
        digest.update(clip_digest(bpy.data.objects[name]))
    return digest.hexdigest()


def clip_digest(obj: bpy.types.Object) -> bytes:
    """Digest of the clip that an object shows; a constant if it is not baked."""
    clip = clip_status.clip_path(obj) if modifier.plays_clip(modifier.find(obj)) else None
    if clip is None:
        return b"live"
    try:
        manifest = clip_file.read_manifest(clip)
    except ClipFault:
        return b"live"
    return b"" if manifest is None else clip_file.checksum(manifest).to_bytes(4, "little")


def made_by() -> str:
    """Versions of Rumple and Blender: results of equal versions have equal bits."""
    return f"Rumple {kernels.__version__}, Blender {bpy.app.version_string}"


def caches() -> Iterator[Path]:
    """Files that animate or move a mesh, without the clips of wrinkles."""
    for cache in bpy.data.cache_files:
        yield Path(bpy.path.abspath(cache.filepath, library=cache.library))
    for image in _images_that_move():
        yield from _files_of(image)
    for obj in bpy.data.objects:
        for modifier_ in obj.modifiers:
            if modifier_.type == "MESH_CACHE" and modifier_.filepath and modifier_.name != modifier.CACHE_NAME:
                yield Path(bpy.path.abspath(modifier_.filepath, library=obj.library))
            points = getattr(modifier_, "point_cache", None)
            if points is not None:
                yield from _point_files(points, obj.library)


def _images_that_move() -> Iterator[bpy.types.Image]:
    """Images that can move a mesh: in textures of modifiers and force fields, in geometry nodes and in inputs of their
    modifiers."""
    users = bpy.data.user_map(key_types={"IMAGE", "TEXTURE"})
    given = {value for obj in bpy.data.objects for modifier_ in obj.modifiers if modifier_.type == "NODES"
             for value in modifier_inputs.values(modifier_) if isinstance(value, bpy.types.Image)}
    for image in bpy.data.images:
        if image in given or any(
                isinstance(user, bpy.types.GeometryNodeTree)
                or isinstance(user, bpy.types.Texture)
                and any(not isinstance(other, bpy.types.Brush) for other in users.get(user, ()))
                for user in users.get(image, ())):
            yield image


def _files_of(image: bpy.types.Image) -> Iterator[Path]:
    """All files of an image: of a sequence, or all tiles."""
    if image.packed_file is not None or not image.filepath or image.source in ("GENERATED", "VIEWER"):
        return
    path = Path(bpy.path.abspath(image.filepath, library=image.library))
    stem = glob.escape(path.stem)
    if image.source == "SEQUENCE":
        stem = re.sub(r"\d+(?=\D*$)", "*", stem)
    elif image.source == "TILED":
        stem = re.sub("<UDIM>|<UVTILE>", "*", stem)
    yield from sorted(path.parent.glob(stem + glob.escape(path.suffix))) or [path]


def _point_files(points: bpy.types.PointCache, library: bpy.types.Library | None) -> Iterator[Path]:
    """The cache files of a simulation, in a chosen folder or in that of the blend file. Caches that are not baked do
    not count, because playback writes them."""
    if points.use_external and points.filepath:
        folder = Path(bpy.path.abspath(points.filepath, library=library))
    elif points.use_external or points.use_disk_cache and points.is_baked:
        file = Path(bpy.path.abspath(library.filepath if library is not None else bpy.data.filepath))
        folder = file.parent / f"blendcache_{file.stem}"
    else:
        return
    yield from sorted(folder.glob("*.bphys")) or [folder]


def content(file: Path) -> bytes:
    """Digest of a file's bytes; _UNREADABLE if it cannot be read."""
    digest = hashlib.blake2b(digest_size=16)
    try:
        with open(file, "rb") as opened:
            while block := opened.read(1 << 20):
                digest.update(block)
    except OSError:
        return _UNREADABLE
    return digest.digest()
