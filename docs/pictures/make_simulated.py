# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulated garments of ../shared/data before and after one click: s3_skirt.jpg and s5_flag.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python xvfb-run -a blender --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_simulated.py
"""
from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from contact_sheet import compose, frame_camera, studio  # noqa: E402

SCENES = (("S3_skirt_sim", "skirt", (40, 59, 70, 85, 100), "s3_skirt"),
          ("S5_flag", "flag", (20, 40, 60, 80, 95), "s5_flag"))


def tiles_of(name: str, frames: tuple[int, ...], folder: Path) -> list[tuple[str, Path]]:
    """Pairs of pictures, before and after, frame by frame."""
    scene, garment = bpy.context.scene, bpy.data.objects[name]
    studio(scene)
    frame_camera(garment, range(frames[0], frames[-1] + 1))
    pictures = {}
    for word in ("before", "after"):
        if word == "after":
            bpy.context.view_layer.objects.active = garment
            with bpy.context.temp_override(object=garment):    # a script has none before the first redraw
                assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}, garment.rumple.message
        for frame in range(scene.frame_start, frames[-1] + 1) if word == "after" else frames:
            scene.frame_set(frame)
            if frame in frames:
                pictures[frame, word] = folder / f"{name}_{word}_{frame}.png"
                scene.render.filepath = str(pictures[frame, word])
                bpy.ops.render.render(write_still=True)
    return [(f"frame {frame}, {word}", pictures[frame, word]) for frame in frames for word in ("before", "after")]


def main() -> None:
    from PIL import Image
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        for file, name, frames, out in SCENES:
            bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / f"{file}.blend"))
            compose(tiles_of(name, frames, Path(folder)), 2, Path(folder) / "sheet.png")
            sheet = Image.open(Path(folder) / "sheet.png")
            sheet.thumbnail((1600, 1600))
            sheet.save(HERE / f"{out}.jpg", quality=88, optimize=True)
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):  # without one Blender 3.4 crashes
        bpy.ops.wm.quit_blender()


if __name__ == "__main__":
    bpy.app.timers.register(main)    # Blender 3.4 crashes where a script quits before the first redraw
