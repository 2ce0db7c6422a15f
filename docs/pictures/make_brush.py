# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture of the brush for the user guide, brush.jpg: strokes on a walking shirt (frame 60), made by simulated events.

    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1400x1000x24 -fbdir $d" blender --factory-startup \
        ../shared/data/S1_walk_shirt.blend --enable-event-simulate --window-geometry 0 0 1400 1000 \
        --python docs/pictures/make_brush.py
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Iterator

import bpy
from mathutils import Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from windowed import picture_of, play, save_jpeg  # noqa: E402

# Of the 3D viewport, from its lower left corner, in shares of its size.
STROKES = (((0.36, 0.30), (0.46, 0.66)), ((0.42, 0.28), (0.50, 0.64)), ((0.58, 0.30), (0.55, 0.66)),
           ((0.64, 0.30), (0.60, 0.60)))


def steps() -> Iterator[float]:
    """One step a redraw."""
    window = bpy.context.window_manager.windows[0]
    shirt = bpy.data.objects["shirt"]
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    region = next(region for region in area.regions if region.type == "WINDOW")
    bpy.context.scene.frame_set(60)
    space = area.spaces.active
    space.region_3d.view_perspective = "PERSP"
    bpy.data.objects["Rig"].hide_set(True)
    space.overlay.show_outline_selected = False
    space.overlay.show_floor = space.overlay.show_axis_x = space.overlay.show_axis_y = False
    bpy.context.view_layer.objects.active = shirt
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.object.select_all(action="DESELECT")
        shirt.select_set(True)
        bpy.ops.object.rumple_add(method="FIELD")
        shirt.rumple.field.output = "GEOMETRY"
        bpy.ops.object.rumple_brush()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    bpy.context.scene.rumple_brush.radius = 45
    yield 1.5

    def event(kind: str, value: str, place: tuple[float, float]) -> None:
        window.event_simulate(kind, value, x=int(region.x + place[0] * region.width),
                              y=int(region.y + place[1] * region.height))

    for start, end in STROKES:
        event("MOUSEMOVE", "NOTHING", start)
        yield 0.2
        event("LEFTMOUSE", "PRESS", start)
        yield 0.1
        for step in range(1, 13):
            event("MOUSEMOVE", "NOTHING", tuple(Vector(start).lerp(Vector(end), step / 12)))
            yield 0.1
        event("LEFTMOUSE", "RELEASE", end)
        yield 0.5
    event("MOUSEMOVE", "NOTHING", (0.62, 0.62))
    yield 1.5
    save_jpeg(picture_of(area), HERE / "brush.jpg")
    print("message:", shirt.rumple.message or "none", flush=True)


play(steps())
