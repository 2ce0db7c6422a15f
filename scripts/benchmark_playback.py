# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame of playback costs in a Solid viewport, with and without the GPU preview of a system.

    RUMPLE_NATIVE=build/release/python xvfb-run -a -s "-screen 0 1280x960x24" blender --factory-startup \
        ../shared/data/S1_walk_shirt.blend --python scripts/benchmark_playback.py -- PATHS HANG shirt trousers

System, base cloth (OFF: no body either), garments.

Milliseconds, medians over frames: `update` is everything but drawing (rig, solve, shown mesh), `draw` a redraw of the
window until the graphics card has finished.
"""
from __future__ import annotations

import contextlib
import os
import sys
import time
import traceback
from pathlib import Path
from typing import Iterator

import bpy
import gpu
import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / "addon"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from rumple.blender.objects import modifier, runtimes  # noqa: E402

FRAMES = 12
METHOD, BASE_CLOTH, *GARMENTS = sys.argv[sys.argv.index("--") + 1:]


def wrinkled() -> list[bpy.types.Object]:
    """The garments with wrinkles; the others on the stage are hidden, bodies stay."""
    found = [bpy.data.objects[name] for name in GARMENTS]
    for obj in found:
        bpy.context.view_layer.objects.active = obj
        window = bpy.context.window_manager.windows[0]
        with bpy.context.temp_override(window=window, object=obj, active_object=obj, selected_objects=[obj]):
            bpy.ops.object.rumple_add(method=METHOD)
    for obj in found:
        getattr(obj.rumple, METHOD.lower()).base_cloth = BASE_CLOTH
        if BASE_CLOTH == "OFF":
            obj.rumple.body = obj.rumple.body_collection = None
    return found


def look(objects: list[bpy.types.Object]) -> bpy.types.Area:
    """All of them in the biggest area, in Solid shading."""
    window = bpy.context.window_manager.windows[0]
    area = max(window.screen.areas, key=lambda a: a.width * a.height)
    area.type = "VIEW_3D"
    area.spaces.active.shading.type = "SOLID"
    for other in bpy.context.view_layer.objects:
        other.select_set(other in objects)
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    return area


def redraw() -> None:
    """Until the graphics card has finished."""
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]), contextlib.redirect_stdout(None):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    gpu.state.active_framebuffer_get().read_color(0, 0, 1, 1, 4, 0, "FLOAT")


def play() -> tuple[float, float]:
    """(update, draw) of a frame."""
    update, draw = [], []
    first = bpy.context.scene.frame_start
    for frame in range(first, first + FRAMES):
        began = time.perf_counter()
        bpy.context.scene.frame_set(frame)
        set_ = time.perf_counter()
        redraw()
        update.append(set_ - began)
        draw.append(time.perf_counter() - set_)
    return 1e3 * float(np.median(update[2:])), 1e3 * float(np.median(draw[2:]))


def steps() -> Iterator[float]:
    garments = wrinkled()
    area = look(garments)
    print(f"{bpy.data.filepath}: {', '.join(GARMENTS)}; Blender {bpy.app.version_string}, "
          f"{gpu.platform.renderer_get()}, {area.width} x {area.height} pixels")
    for name, wrinkles, preview in (("no wrinkles", False, False), ("fine mesh", True, False), ("preview", True, True)):
        for obj in garments:
            modifier.find(obj).show_viewport = wrinkles
            getattr(obj.rumple, METHOD.lower()).gpu_preview = preview
        area.tag_redraw()
        yield 3.0
        for turn in ("solved", "stored"):
            update, draw = play()
            drawn = sum(runtimes.of(obj).inputs.for_preview for obj in garments if wrinkles)
            print(f"{name:12} {turn:7} update {update:7.1f}  draw {draw:7.1f}  left to the graphics card: {drawn}")


def main() -> None:
    rumple.register()
    running = steps()

    def advance() -> float:
        try:
            return next(running)
        except StopIteration:
            pass
        except Exception:
            traceback.print_exc()
        sys.stdout.flush()
        os._exit(0)

    bpy.app.timers.register(advance, first_interval=1.0)


bpy.context.preferences.view.show_splash = False
main()
