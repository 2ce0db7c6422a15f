# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the panel with everything open, panel_<version>.png, of the other systems' and of the viewport (3.4).

    scripts/demo                                   # makes out/demo/wrinkled.blend
    scripts/examples                               # the header has their button, as in the packages
    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 620x3000x24 -fbdir $d" blender --factory-startup out/demo/wrinkled.blend \
        --window-geometry 0 0 620 3000 --python docs/pictures/make_panels.py
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Iterator

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from windowed import picture_of, play, save_jpeg, save_png  # noqa: E402
from rumple.blender.ui import panels  # noqa: E402

FRAME = 52
EDGE = 42  # pixels from the left, where parts of the panel have nothing but their ground
RISE = range(10, 40)  # how much lighter, of 765, the name of a part is than the part above it
GROUND = 29  # of the pixels below a column
VERSION = "{}.{}".format(*bpy.app.version)


def viewport(area: bpy.types.Area) -> None:
    space = area.spaces.active
    space.shading.type = "SOLID"
    space.region_3d.view_perspective = "CAMERA"
    space.overlay.show_overlays = False


def without_ground(pixels: np.ndarray) -> np.ndarray:
    """Without the empty rows below the last panel."""
    used = np.flatnonzero(np.ptp(pixels[:, 40:-20], axis=1).max(axis=1) > 8)
    return pixels[:used[-1] + 12]


def in_two(pixels: np.ndarray) -> np.ndarray:
    """Two columns beside one another, cut above a part of the panel: one column is taller than a page."""
    rises = np.diff(pixels[:, EDGE].astype(int).sum(axis=1))
    tops = np.flatnonzero((rises >= RISE.start) & (rises < RISE.stop)) + 1
    cut = tops[np.abs(tops - len(pixels) // 2).argmin()]
    columns = pixels[:cut], pixels[cut:]
    height = max(map(len, columns))
    return np.hstack([np.pad(column, ((0, height - len(column)), (0, 0), (0, 0)), constant_values=GROUND)
                      for column in columns])


def photograph(area: bpy.types.Area, name: str) -> None:
    save_png(in_two(without_ground(picture_of(area))), HERE / f"panel_{name}.png")


def steps() -> Iterator[float]:
    """One step a redraw."""
    area = max(bpy.context.window_manager.windows[0].screen.areas, key=lambda a: a.width * a.height)
    for frame in range(1, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    viewport(area)
    bpy.context.window_manager.windows[0].cursor_warp(2, 2)
    yield 1.5
    if VERSION == "3.4":
        picture = picture_of(area)
        middle, half = len(picture) // 2, int(0.9 * picture.shape[1])
        save_jpeg(picture[middle - half:middle + half], HERE / "viewport.jpg")
    area.type = "PROPERTIES"
    yield 0.5
    area.spaces.active.context = "MODIFIER"
    yield 2.0
    photograph(area, VERSION)
    for method in ("FIELD", "PATHS") if VERSION == "3.4" else ():
        another(method)
        for _ in range(3):  # other sub-panels take their places one redraw later
            area.tag_redraw()
            yield 0.7
        photograph(area, method.lower())


def another(method: str) -> None:
    """Wrinkles of another system on the same garment."""
    window, garment = bpy.context.window_manager.windows[0], bpy.data.objects["Shirt"]
    with bpy.context.temp_override(window=window, object=garment, active_object=garment):
        bpy.ops.object.rumple_remove()
        garment.rumple.field.property_unset("output")  # the demo's studio draws no materials
        bpy.ops.object.rumple_add(method=method)
    for modifier in garment.modifiers:
        modifier.show_expanded = False
    for frame in range(FRAME - 20, FRAME + 1):
        bpy.context.scene.frame_set(frame)


def main() -> None:
    for cls in panels.CLASSES:
        if "DEFAULT_CLOSED" in getattr(cls, "bl_options", ()):
            cls.bl_options = cls.bl_options - {"DEFAULT_CLOSED"}
    garment = bpy.data.objects["Shirt"]
    bpy.context.view_layer.objects.active = garment
    garment.select_set(True)
    for modifier in garment.modifiers:
        modifier.show_expanded = False
    play(steps())


main()
