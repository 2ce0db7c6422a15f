# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of the panel Paint at the default width, panel_paint.png (Blender 3.4).

    scripts/demo                                   # makes out/demo/wrinkled.blend
    scripts/examples                               # the header has their button, as in the packages
    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1920x1080x24 -fbdir $d" blender --factory-startup out/demo/wrinkled.blend \
        --window-geometry 0 0 1920 1080 --python docs/pictures/make_paint_panel.py
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Iterator

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from windowed import picture_of, play, save_png  # noqa: E402
from rumple.blender.ui.paint_panel import DATA_PT_rumple_paint  # noqa: E402

WIDTH = 333  # of the editor, with Blender's own layout on a screen of 1920 x 1080


def steps() -> Iterator[float]:
    """One step a redraw."""
    window, garment = bpy.context.window_manager.windows[0], bpy.data.objects["Shirt"]
    area = next(area for area in window.screen.areas if area.type == "PROPERTIES")
    area.spaces.active.context = "MODIFIER"
    yield 1.0
    with bpy.context.temp_override(window=window, object=garment, active_object=garment):
        bpy.ops.object.rumple_paint_from_border(group="folds", distance=0.1)
        bpy.ops.object.rumple_paint_from_border(group="smooth", distance=0.03)
    window.cursor_warp(2, 2)
    for frame in range(1, 4):
        bpy.context.scene.frame_set(frame)
        area.tag_redraw()
        yield 1.5
    picture = picture_of(area)
    assert picture.shape[1] == WIDTH, picture.shape
    save_png(picture, HERE / "panel_paint.png")


def main() -> None:
    DATA_PT_rumple_paint.bl_options = set()
    garment = bpy.data.objects["Shirt"]
    bpy.context.view_layer.objects.active = garment
    garment.select_set(True)
    for modifier in garment.modifiers:
        modifier.show_expanded = False
    play(steps())


main()
