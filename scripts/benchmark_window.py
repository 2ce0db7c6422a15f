# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmarks of a Blender with a window share: a sheet, times, redraws and playback."""
from __future__ import annotations

import contextlib
import os
import sys
import time
import traceback
from typing import Callable, Iterator

import bpy
import gpu
import numpy as np

REPEATS, TRIES = 10, 5
FRAMES = 12


def sheet(along: int, across: int) -> tuple:
    """A quad grid of a metre: what build_surface takes, and uv."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, along), np.linspace(0.0, 1.0, across))
    rest = np.stack((x.ravel(), y.ravel(), 0.0 * x.ravel()), 1).astype(np.float32)
    first = (np.arange(across - 1)[:, None] * along + np.arange(along - 1)).ravel()
    quads = np.stack((first, first + 1, first + along + 1, first + along), 1).astype(np.int32)
    corner = 4 * np.arange(len(quads), dtype=np.int32)[:, None]
    triangles = np.concatenate((corner + (0, 1, 2), corner + (0, 2, 3)), 1).reshape(-1, 3).astype(np.int32)
    surface = (rest, np.arange(0, quads.size + 1, 4, dtype=np.int32), quads.ravel(), triangles)
    return surface, np.ascontiguousarray(rest[quads.ravel(), :2])


def milliseconds(step: Callable[[], None], finish: Callable[[], None] = lambda: None) -> float:
    """The least of some tries of the mean of some calls."""
    step()
    finish()
    times = []
    for _ in range(TRIES):
        began = time.perf_counter()
        for _ in range(REPEATS):
            step()
        finish()
        times.append((time.perf_counter() - began) / REPEATS)
    return 1e3 * min(times)


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


def run(steps: Iterator[float]) -> None:
    """Runs the steps once the window is there, with the pauses in seconds that they ask for, and ends Blender."""
    def advance() -> float:
        try:
            return next(steps)
        except StopIteration:
            pass
        except Exception:
            traceback.print_exc()
        sys.stdout.flush()
        os._exit(0)

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(advance, first_interval=1.0)
