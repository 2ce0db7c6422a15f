# SPDX-License-Identifier: GPL-3.0-or-later
"""s1_preview.jpg beside this file: the walking shirt and trousers in a Solid viewport, without and with the preview.
With `-- PATHS` at the end: s1_folds_preview.jpg, folds as a fine mesh and drawn by the preview.

    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1400x1300x24 -fbdir $d" blender --factory-startup \
        ../shared/data/S1_walk_shirt.blend --window-geometry 0 0 1400 1300 --python docs/pictures/make_preview.py
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Iterator

import bpy
import numpy as np
from mathutils import Quaternion, Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from windowed import picture_of, play, save_jpeg  # noqa: E402

FRAME = 60
METHOD = "PATHS" if sys.argv[-1] == "PATHS" else "FIELD"
PICTURE = {"FIELD": "s1_preview.jpg", "PATHS": "s1_folds_preview.jpg"}[METHOD]
GARMENTS = [obj for obj in bpy.data.objects if obj.type == "MESH" and obj.name.lower() in ("shirt", "trousers")]


def middle_of(area: bpy.types.Area) -> np.ndarray:
    pixels = picture_of(area)
    return pixels[60:-10, area.width // 4:3 * area.width // 4]


def look(area: bpy.types.Area) -> None:
    space = area.spaces.active
    space.shading.type, space.overlay.show_overlays, space.show_gizmo = "SOLID", True, False
    for name in ("show_floor", "show_axis_x", "show_axis_y", "show_cursor", "show_text", "show_object_origins",
                 "show_outline_selected", "show_bones", "show_relationship_lines", "show_extras"):
        setattr(space.overlay, name, False)
    points = [obj.matrix_world @ Vector(corner) for obj in GARMENTS for corner in obj.bound_box]
    view = space.region_3d
    view.view_perspective = "PERSP"
    view.view_rotation = Quaternion((0.0, 0.0, 1.0), 0.5) @ Quaternion((1.0, 0.0, 0.0), 1.45)
    view.view_location = sum(points, Vector()) / len(points) + Vector((0.0, 0.0, 0.25))
    view.view_distance = 1.35


def steps() -> Iterator[float]:
    """One step a redraw."""
    window = bpy.context.window_manager.windows[0]
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    area.type = "VIEW_3D"
    yield 0.5
    for obj in GARMENTS:
        getattr(obj.rumple, METHOD.lower()).gpu_preview = True
        with bpy.context.temp_override(window=window, area=area, object=obj, active_object=obj, selected_objects=[obj]):
            bpy.context.view_layer.objects.active = obj
            bpy.ops.object.rumple_add(method=METHOD)
    for frame in range(1, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    look(area)
    window.cursor_warp(2, 2)
    pictures = []
    for on in (False, True):
        for obj in GARMENTS:
            getattr(obj.rumple, METHOD.lower()).gpu_preview = on
        area.tag_redraw()
        yield 3.0
        pictures.append(middle_of(area))
    save_jpeg(np.concatenate(pictures, 1), HERE / PICTURE)


play(steps())
