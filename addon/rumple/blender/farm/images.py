# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes textures of numbers with Blender, and reads them back to verify them."""
from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from ...core.files.clip_manifest import ClipFault
from ..objects import saved_images

SUFFIXES = {"PNG": ".png", "OPEN_EXR": ".exr"}  # 16 bits; 32-bit floats, ZIP without loss


def write(path: Path, picture: np.ndarray, kind: str) -> None:
    """Write a texture. picture: (height, width, 3) float32, the upper row first; for PNG, multiples of 1/65535 in 0..1.
    kind: a key of SUFFIXES. Raises ClipFault. Memory: 48 bytes per texel."""
    height, width = picture.shape[:2]
    values = np.ones((height, width, 4), np.float32)
    values[..., :3] = picture[::-1]
    image = bpy.data.images.new("Rumple Texture", width, height, alpha=False, float_buffer=True)
    try:
        image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set(values.ravel())
        with saved_images.raw_scene(kind, "16" if kind == "PNG" else "32") as scene:
            try:
                image.save_render(str(path), scene=scene)
            except RuntimeError as error:
                raise _not_written(path) from error
    finally:
        bpy.data.images.remove(image)
    if not _holds(path, values):
        raise _not_written(path)


def _holds(path: Path, values: np.ndarray) -> bool:
    """Whether the file has all values. Blender does not report a full disk."""
    try:
        image = bpy.data.images.load(str(path))
    except RuntimeError:
        return False
    try:
        image.colorspace_settings.name = "Non-Color"
        if tuple(image.size) != (values.shape[1], values.shape[0]):
            return False
        read = np.empty(values.size, np.float32)
        image.pixels.foreach_get(read)
        return np.allclose(read, values.ravel(), rtol=0.0, atol=1e-6)
    finally:
        bpy.data.images.remove(image)


def _not_written(path: Path) -> ClipFault:
    return ClipFault(f"the texture {path.name} cannot be written whole to {path.parent.parent}: make room, or choose "
                     "another folder")
