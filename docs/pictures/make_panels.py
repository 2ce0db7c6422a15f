# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the panel with everything open, panel_<version>.png, of the other systems' and of the viewport (3.4).

    scripts/demo                                   # makes out/demo/wrinkled.blend
    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1000x2200x24 -fbdir $d" blender --factory-startup out/demo/wrinkled.blend \
        --window-geometry 0 0 1000 2200 --python docs/pictures/make_panels.py
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Iterator

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from windowed import picture_of, play, save_jpeg, window_case  # noqa: E402
from rumple.blender.ui import panels  # noqa: E402

FRAME = 52
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
        save_jpeg(picture[len(picture) // 4:-len(picture) // 4], HERE / "viewport.jpg")
    area.type = "PROPERTIES"
    yield 0.5
    area.spaces.active.context = "MODIFIER"
    yield 2.0
    (HERE / f"panel_{VERSION}.png").write_bytes(window_case.png(without_ground(picture_of(area))))
    for method in ("FIELD", "PATHS") if VERSION == "3.4" else ():
        another(method)
        for _ in range(3):  # other sub-panels take their places one redraw later
            area.tag_redraw()
            yield 0.7
        (HERE / f"panel_{method.lower()}.png").write_bytes(window_case.png(without_ground(picture_of(area))))


def another(method: str) -> None:
    """Wrinkles of another system on the same garment."""
    window, garment = bpy.context.window_manager.windows[0], bpy.data.objects["Shirt"]
    with bpy.context.temp_override(window=window, object=garment, active_object=garment):
        bpy.ops.object.rumple_remove()
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
