# SPDX-License-Identifier: GPL-3.0-or-later
"""What the makers of window pictures share: they run in Blender, in a window, one step a redraw."""
from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "blender_tests"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from support import window_case  # noqa: E402


def picture_of(area: bpy.types.Area) -> np.ndarray:
    """What the screen shows of an area, (height, width, 3) uint8, the top row first."""
    pixels = window_case.WindowCase().pixels()
    top = len(pixels) - area.y - area.height
    return pixels[top:top + area.height, area.x:area.x + area.width]


def save_jpeg(pixels: np.ndarray, path: Path) -> None:
    height, width, _ = pixels.shape
    image = bpy.data.images.new("Picture", width, height)
    image.pixels.foreach_set(np.dstack([pixels[::-1], np.full((height, width), 255)]).astype(np.float32).ravel() / 255)
    image.filepath_raw, image.file_format = str(path), "JPEG"
    image.save()


def save_png(pixels: np.ndarray, path: Path) -> None:
    """With a palette: a third as large, and the packages carry the guide's pictures. Not the one of median cut, which
    loses the hues of small icons."""
    from PIL import Image
    palette, plain = Image.Quantize.MAXCOVERAGE, Image.Dither.NONE
    Image.fromarray(pixels).quantize(256, palette, dither=plain).save(path, optimize=True)


def play(steps: Iterator[float]) -> None:
    """Register the add-on, and take a step whenever the seconds that the one before asked for are over."""
    rumple.register()
    bpy.context.preferences.view.show_splash = False

    def advance() -> float | None:
        try:
            return next(steps)
        except StopIteration:
            os._exit(0)

    bpy.app.timers.register(advance, first_interval=2.0)
