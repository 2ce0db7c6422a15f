# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the panels for the user guide: panel.png and viewport.jpg beside this file.

    scripts/demo                                   # makes out/demo/wrinkled.blend
    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1200x1500x24 -fbdir $d" blender --factory-startup out/demo/wrinkled.blend \
        --window-geometry 0 0 1200 1500 --python docs/pictures/make_panels.py
"""
from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy
import numpy as np
from PIL import Image

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402


def screen() -> Image.Image:
    """What the X server shows, from its frame buffer (an XWD file)."""
    data = Path(os.environ["RUMPLE_FRAMEBUFFER"]).read_bytes()
    head = np.frombuffer(data[:100], ">u4")
    width, height, stride = int(head[4]), int(head[5]), int(head[12])
    start = int(head[0]) + int(head[19]) * 12
    rows = np.frombuffer(data, np.uint8, stride * height, start).reshape(height, stride)
    return Image.fromarray(np.ascontiguousarray(rows[:, :4 * width].reshape(height, width, 4)[:, :, 2::-1]))


def area_picture(area: bpy.types.Area, name: str) -> None:
    picture = screen()
    top = picture.size[1] - area.y - area.height
    picture = picture.crop((area.x, top, area.x + area.width, top + area.height))
    if name.endswith(".png"):
        picture = picture.convert("P", palette=Image.ADAPTIVE)
    picture.save(HERE / name, optimize=True, quality=88)


def steps():
    """One step a redraw."""
    window = bpy.context.window_manager.windows[0]
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    bpy.context.scene.frame_set(48)
    space = area.spaces.active
    space.shading.type = "SOLID"
    space.region_3d.view_perspective = "CAMERA"
    space.overlay.show_overlays = False
    yield 1.0
    area_picture(area, "viewport.jpg")
    area.type = "PROPERTIES"
    yield 0.5
    area.spaces.active.context = "MODIFIER"
    yield 1.5
    area_picture(area, "panel.png")


def main() -> None:
    rumple.register()
    garment = bpy.data.objects["Shirt"]
    bpy.context.view_layer.objects.active = garment
    garment.select_set(True)
    running = steps()

    def advance() -> float | None:
        try:
            return next(running)
        except StopIteration:
            os._exit(0)

    bpy.app.timers.register(advance, first_interval=2.0)


main()
