# SPDX-License-Identifier: GPL-3.0-or-later
"""s1_preview.jpg beside this file: the walking shirt and trousers in a Solid viewport, without and with the preview.
With `-- PATHS` at the end: s1_folds_preview.jpg, folds as a fine mesh and drawn by the preview.

    d=$(mktemp -d); RUMPLE_NATIVE=build/release/python RUMPLE_FRAMEBUFFER=$d/Xvfb_screen0 \
        xvfb-run -a -s "-screen 0 1400x1300x24 -fbdir $d" blender --factory-startup \
        ../shared/data/S1_walk_shirt.blend --window-geometry 0 0 1400 1300 --python docs/pictures/make_preview.py
"""
from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Quaternion, Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "blender_tests"), str(ROOT / "blender_tests/window"),
                os.environ["RUMPLE_NATIVE"]]
import case  # noqa: E402
import rumple  # noqa: E402

FRAME = 60
METHOD = "PATHS" if sys.argv[-1] == "PATHS" else "FIELD"
PICTURE = {"FIELD": "s1_preview.jpg", "PATHS": "s1_folds_preview.jpg"}[METHOD]
GARMENTS = [obj for obj in bpy.data.objects if obj.type == "MESH" and obj.name.lower() in ("shirt", "trousers")]


def picture_of(area: bpy.types.Area) -> np.ndarray:
    """The middle of an area, (height, width, 3) uint8, the top row first."""
    pixels = case.WindowCase().pixels()
    top = len(pixels) - area.y - area.height
    return pixels[top + 60:top + area.height - 10, area.x + area.width // 4:area.x + 3 * area.width // 4]


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


def steps():
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
        pictures.append(picture_of(area))
    both = np.concatenate(pictures, 1)
    image = bpy.data.images.new("Picture", both.shape[1], both.shape[0])
    image.pixels.foreach_set(np.dstack([both[::-1], np.full(both.shape[:2], 255)]).astype(np.float32).ravel() / 255)
    image.filepath_raw, image.file_format = str(HERE / PICTURE), "JPEG"
    image.save()


def main() -> None:
    rumple.register()
    bpy.context.preferences.view.show_splash = False
    running = steps()

    def advance() -> float | None:
        try:
            return next(running)
        except StopIteration:
            os._exit(0)

    bpy.app.timers.register(advance, first_interval=2.0)


main()
