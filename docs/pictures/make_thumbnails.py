# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the fabrics, addon/rumple/thumbnails/*.png: the bent sleeve of the gallery with every preset.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_thumbnails.py
"""
from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import bpy
from mathutils import Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import gallery_light  # noqa: E402
import gallery_scenes  # noqa: E402
import rumple  # noqa: E402
from PIL import Image  # noqa: E402
from rumple.blender.ui import thumbnails  # noqa: E402
from rumple.core.systems import SYSTEMS  # noqa: E402

FRAME, FIRST = 28, 10  # played from there
SIZE, SAMPLES = 112, 48
COLOURS = 96  # of a picture: it stays small
VIEW, DISTANCE, LENS = Vector((1.0, -0.75, 0.12)).normalized(), 1.15, 85.0
TARGET = (0.0, 0.0, 0.03)  # metres beside the elbow


def show(method: str, preset: str) -> None:
    """The sleeve in that fabric, in its pose."""
    bpy.ops.wm.read_homefile(use_empty=True)
    shirt = gallery_scenes.build_elbow()
    assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}, shirt.rumple.message
    assert bpy.ops.object.rumple_preset(preset=preset) == {"FINISHED"}, shirt.rumple.message
    gallery_light.light(bpy.context.scene)
    gallery_light.dye(shirt, preset)
    for frame in range(FIRST, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    assert not shirt.rumple.message, shirt.rumple.message


def render(path: Path) -> None:
    scene = bpy.context.scene
    skeleton, camera = bpy.data.objects["Skeleton"], scene.camera
    place = skeleton.matrix_world @ skeleton.pose.bones["elbow.L"].head + Vector(TARGET)
    camera.location, camera.data.lens = place + DISTANCE * VIEW, LENS
    camera.rotation_euler = (-VIEW).to_track_quat("-Z", "Y").to_euler()
    scene.cycles.samples = SAMPLES
    scene.render.resolution_x = scene.render.resolution_y = 2 * SIZE
    scene.render.resolution_percentage = 100
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main() -> None:
    rumple.register()
    thumbnails.FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for method, system in SYSTEMS.items():
            for preset in system.presets:
                show(method, preset)
                render(Path(folder) / "large.png")
                small = Image.open(Path(folder) / "large.png").convert("RGB").resize((SIZE, SIZE), Image.LANCZOS)
                small.quantize(COLOURS).save(thumbnails.path(method, preset), optimize=True)


if __name__ == "__main__":
    main()
