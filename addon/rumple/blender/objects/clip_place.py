# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the files of an object belong: its baked clip, and its stored frames. How a blend file names a file."""
from __future__ import annotations

import os
from pathlib import Path

import bpy

from ...core import clip_folder
from .. import compat

FOLDER = "//rumple"


def until_saved(obj: bpy.types.Object) -> Path:
    """Of the clip of a file that was never saved: Blender's own temporary folder."""
    return Path(bpy.app.tempdir) / "rumple" / clip_folder.clip_name("unsaved", obj.name, "")


def is_temporary(clip: Path) -> bool:
    """Whether it goes when Blender quits."""
    return Path(_whole(bpy.app.tempdir)) in Path(_whole(clip)).parents


def _whole(path: str | Path) -> str:
    return os.path.normcase(os.path.abspath(path))  # not resolve(): it fails on some drives of Windows


def of(obj: bpy.types.Object) -> Path | None:
    """Of the clip. None where it belongs beside the blend file, and that was never saved."""
    folder = compat.blend_path(obj.rumple.bake_folder or FOLDER)
    beside = folder.startswith("//")
    if beside and not bpy.data.filepath:
        return None
    place = "" if beside else str(Path(bpy.data.filepath).parent)  # files of one name in two folders share this one
    return Path(bpy.path.abspath(folder)) / clip_folder.clip_name(Path(bpy.data.filepath).stem, obj.name, place)


def stored_path(path: Path) -> str:
    """How the file is written into the blend file: relative where possible, with forward slashes on any system. A share
    of Windows keeps its two backslashes: what begins with two slashes is beside the blend file, for Blender."""
    text = str(path)
    if bpy.data.filepath:
        try:
            text = bpy.path.relpath(text)
        except ValueError:
            pass  # another drive on Windows
    return text if text.startswith("\\\\") else text.replace("\\", "/")
