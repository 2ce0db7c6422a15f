# SPDX-License-Identifier: GPL-3.0-or-later
"""The paths of an object's files (its baked clip and its stored frames), and how a blend file stores a path."""
from __future__ import annotations

import os
from pathlib import Path

import bpy

from ...core.files import clip_folder

FOLDER = "//rumple"


def blend_path(folder: str) -> str:
    """A folder as an artist types it. A path that is neither absolute nor begins with // is also relative to the blend
    file. ~ is the home folder."""
    folder = os.path.expanduser(folder if os.name == "nt" else folder.replace("\\", "/"))
    return folder if folder.startswith("//") or os.path.isabs(folder) else "//" + folder


def until_saved(obj: bpy.types.Object) -> Path:
    """The path of the clip before the file is saved: in Blender's own temporary folder."""
    return Path(bpy.app.tempdir) / "rumple" / clip_folder.clip_name("unsaved", obj.name, "")


def is_temporary(clip: Path) -> bool:
    """Whether the clip is in the temporary folder, which Blender deletes when it quits."""
    return Path(_whole(bpy.app.tempdir)) in Path(_whole(clip)).parents


def _whole(path: str | Path) -> str:
    return os.path.normcase(os.path.abspath(path))  # not resolve(), because it fails on some Windows drives


def of(obj: bpy.types.Object) -> Path | None:
    """The path of the clip. None if it should be beside the blend file, but this file was never saved."""
    folder = blend_path(obj.rumple.bake_folder or FOLDER)
    beside = folder.startswith("//")
    if beside and not bpy.data.filepath:
        return None
    place = "" if beside else str(Path(bpy.data.filepath).parent)  # files of one name may share this folder
    return Path(bpy.path.abspath(folder)) / clip_folder.clip_name(Path(bpy.data.filepath).stem, obj.name, place)


def stored_path(path: Path) -> str:
    """The form of a path in the blend file: relative if possible, with forward slashes on any system. A Windows share
    keeps its two backslashes, because Blender reads two slashes at the start as the blend file's folder."""
    text = str(path)
    if bpy.data.filepath:
        try:
            text = bpy.path.relpath(text)
        except ValueError:
            pass  # another Windows drive
    return text if text.startswith("\\\\") else text.replace("\\", "/")
