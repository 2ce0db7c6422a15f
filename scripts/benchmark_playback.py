# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame of playback costs in a Solid viewport, with and without the GPU preview of a system.

    RUMPLE_NATIVE=build/release/python xvfb-run -a -s "-screen 0 1280x960x24" blender --factory-startup \
        ../shared/data/S1_walk_shirt.blend --python scripts/benchmark_playback.py -- PATHS HANG shirt trousers

System, base cloth (OFF: no body either), garments.

Milliseconds, medians over frames: `update` is everything but drawing (rig, solve, shown mesh), `draw` a redraw of the
window until the graphics card has finished.
"""
from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Iterator

import bpy
import gpu

HERE = Path(__file__).resolve()
sys.path[:0] = [str(HERE.parents[1] / "addon"), str(HERE.parent), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from benchmark_window import look, play, run  # noqa: E402
from rumple.blender.objects import modifier, runtimes  # noqa: E402

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


rumple.register()
run(steps())
