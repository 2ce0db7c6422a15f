# SPDX-License-Identifier: GPL-3.0-or-later
"""Saves images with unchanged values, in a format that is not the artist's."""
from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

import bpy


@contextmanager
def raw_scene(kind: str, depth: str) -> Iterator[bpy.types.Scene]:
    """A scene for image.save_render(). Its settings define the format, so the artist's scene keeps its own.
    kind: PNG or OPEN_EXR. depth: bits of a channel."""
    scene = bpy.data.scenes.new("Rumple Save")
    try:
        scene.view_settings.view_transform = "Raw"
        settings = scene.render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = kind, "RGB", depth
        settings.exr_codec = "ZIP"
        yield scene
    finally:
        bpy.data.scenes.remove(scene)
