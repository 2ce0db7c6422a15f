# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the presets for the user guide: presets.jpg beside this file.

    scripts/demo                                   # makes out/demo/wrinkled.blend
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup out/demo/wrinkled.blend \
        --python-exit-code 1 --python docs/pictures/make_presets.py
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
from contact_sheet import compose, studio  # noqa: E402
from rumple.core.presets import MESH_PRESETS  # noqa: E402

FRAME = 52


def render(path: Path) -> None:
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def play(preset: str) -> None:
    """Play through to the frame with this preset; the density stays."""
    assert bpy.ops.object.rumple_preset(preset=preset) == {"FINISHED"}
    for frame in range(1, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    assert bpy.context.object.rumple.message == ""


def main() -> None:
    rumple.register()
    bpy.context.view_layer.objects.active = bpy.data.objects["Shirt"]
    scene = bpy.context.scene
    studio(scene)
    scene.camera.data.lens *= 1.55
    scene.camera.data.shift_y -= 0.08
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        for key, preset in MESH_PRESETS.items():
            play(key)
            tiles.append((f"{preset.label}: {preset.tip}", Path(folder) / f"{key}.png"))
            render(tiles[-1][1])
        compose(tiles, 2, Path(folder) / "presets.png")
        from PIL import Image
        Image.open(Path(folder) / "presets.png").save(HERE / "presets.jpg", quality=88, optimize=True)


main()
