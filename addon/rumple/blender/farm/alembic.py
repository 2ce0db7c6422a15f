# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports the baked garment as Alembic with Blender's exporter. Debian's Blender is built without it."""
from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

import bpy

from ...core.files import clip_folder
from ...core.files.clip_manifest import ClipFault, Manifest
from ..bake.playback import BakeError
from . import shown

_MAGIC = b"Ogawa\xff"  # start of a complete file: the exporter writes 0x00 after the name until it has finished


def publish(context: bpy.types.Context, obj: bpy.types.Object, manifest: Manifest, folder: Path) -> shown.Exported:
    """Export the shown clip. manifest: of this clip. Raises BakeError and ClipFault."""
    if not bpy.app.alembic.supported:
        raise BakeError(f"{obj.name}: this Blender was built without Alembic: publish USD, or let a Blender of "
                        "blender.org publish")
    path = folder / f"{shown.stem(obj, manifest)}.abc"
    vertices = 0
    for frame in shown.frames(context, obj, manifest):  # all frames are checked before anything is written
        vertices = len(frame.points)
    count = manifest.end - manifest.start + 1
    clip_folder.make(folder, count * manifest.samples * vertices * 12)
    temporary = clip_folder.temporary(path)
    exported = temporary / "a.abc"  # short, because the folder's name is long, and Windows allows 260 letters in total
    try:
        temporary.mkdir()
        with _selected(context, obj):
            _export(exported, manifest)
        clip_folder.put(exported, path)
    except OSError as error:
        raise ClipFault(clip_folder.in_words(error, folder)) from error
    finally:
        clip_folder.discard(temporary)
    return shown.Exported(path, count, vertices, path.stat().st_size)


def _export(path: Path, manifest: Manifest) -> None:
    """Run the exporter. The samples between frames are those of the bake, for motion blur. Raises ClipFault."""
    try:
        bpy.ops.wm.alembic_export(filepath=str(path), start=manifest.start, end=manifest.end,
                                  xsamples=manifest.samples, gsamples=manifest.samples, sh_open=0.0, sh_close=1.0,
                                  selected=True, uvs=True, normals=True, flatten=False, evaluation_mode="VIEWPORT",
                                  as_background_job=False)
    except RuntimeError as error:
        raise ClipFault(f"Blender's Alembic exporter failed: {str(error).strip()}") from error
    head = _head(path)
    if head != _MAGIC:
        raise ClipFault("the Alembic file was not written as a whole: make room, or choose another folder")


def _head(path: Path) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read(len(_MAGIC))
    except FileNotFoundError:
        return b""


@contextmanager
def _selected(context: bpy.types.Context, obj: bpy.types.Object) -> Iterator[None]:
    """A context in which only this object is selected."""
    layer = context.view_layer
    before = [other for other in layer.objects if other.select_get(view_layer=layer)]
    try:
        for other in before:
            other.select_set(False, view_layer=layer)
        obj.select_set(True, view_layer=layer)
        yield
    finally:
        obj.select_set(False, view_layer=layer)
        for other in before:
            other.select_set(True, view_layer=layer)
