# SPDX-License-Identifier: GPL-3.0-or-later
"""The cloths of the Wrinkle Paths on a jump of ../shared/data: paths_presets.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_paths.py
"""
from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from make_sisters import FIRST, FRAME, ROOT, compose, look, rumple  # noqa: E402
from rumple.core.presets import PATHS_PRESETS  # noqa: E402

GARMENTS = ("trousers", "sweater")


def jump(preset: str) -> None:
    """The clip up to the deepest crouch, in that cloth."""
    bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / "S2_squat_trousers.blend"))
    for garment in GARMENTS:
        bpy.context.view_layer.objects.active = bpy.data.objects[garment]
        assert bpy.ops.object.rumple_add(method="PATHS") == {"FINISHED"}
        assert bpy.ops.object.rumple_preset(preset=preset) == {"FINISHED"}
    for frame in range(FIRST, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    assert not any(bpy.data.objects[garment].rumple.message for garment in GARMENTS)


def presets(folder: Path) -> None:
    tiles = []
    for key, preset in PATHS_PRESETS.items():
        jump(key)
        tiles.append((f"{preset.label}: {preset.tip.splitlines()[0]}", folder / f"{key}.png"))
        look(tiles[-1][1], lens=95.0)
    compose([tiles[i] for i in (0, 2, 1, 3)], 2, folder / "sheet.png")  # it fills columns
    from PIL import Image
    Image.open(folder / "sheet.png").save(HERE / "paths_presets.jpg", quality=88, optimize=True)


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        presets(Path(folder))


main()
