# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay of the Wrinkle Paths on a jump of ../shared/data, and its curves as lines: paths_overlay.jpg.

    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1400x1000x24 -fbdir $d" blender --factory-startup \
        ../shared/data/S2_squat_trousers.blend --window-geometry 0 0 1400 1000 --python docs/pictures/make_overlay.py
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Iterator

import bpy
import numpy as np
from mathutils import Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from windowed import picture_of, play, save_jpeg  # noqa: E402

FIRST, FRAMES = 9, (48, 59)  # going down, and the deepest crouch


def view(area: bpy.types.Area) -> None:
    """A clean viewport that looks at the trousers of this frame."""
    space = area.spaces.active
    space.shading.type, space.show_gizmo, space.show_region_toolbar = "SOLID", False, False
    for name in ("floor", "axis_x", "axis_y", "cursor", "text", "extras", "outline_selected", "object_origins",
                 "relationship_lines"):
        setattr(space.overlay, f"show_{name}", False)
    region = space.region_3d
    region.view_perspective = "PERSP"
    region.view_rotation = Vector((-1.3, 2.2, -0.5)).to_track_quat("-Z", "Y")
    trousers = bpy.data.objects["trousers"].evaluated_get(bpy.context.evaluated_depsgraph_get())
    corners = [trousers.matrix_world @ Vector(corner) for corner in trousers.bound_box]
    region.view_location, region.view_distance = sum(corners, Vector()) / 8.0 + Vector((0.0, 0.0, 0.2)), 1.6


def steps() -> Iterator[float]:
    """One step a redraw."""
    window = bpy.context.window_manager.windows[0]
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    garments = [bpy.data.objects[name] for name in ("trousers", "sweater")]
    for obj in bpy.data.objects:
        if obj.type == "ARMATURE":
            obj.hide_set(True)
        obj.select_set(False)
    for garment in garments:
        with bpy.context.temp_override(window=window, object=garment, active_object=garment):
            bpy.ops.object.rumple_add(method="PATHS")
            bpy.ops.object.rumple_curves_add()
        garment.rumple.paths.show_overlay = True
    window.cursor_warp(2, 2)
    halves = []
    for frame, shown in zip(FRAMES, (True, False)):
        for earlier in range(FIRST, frame + 1):
            bpy.context.scene.frame_set(earlier)
        for garment in garments:
            garment.rumple.paths.show_overlay = shown
        view(area)
        area.tag_redraw()
        yield 2.0
        picture = picture_of(area)
        middle = picture.shape[1] // 2
        halves.append(picture[60:, middle - 330:middle + 330])
    save_jpeg(np.concatenate(halves, axis=1), HERE / "paths_overlay.jpg")
    print("messages:", [garment.rumple.message for garment in garments], flush=True)


play(steps())
