# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Field and Wrinkle Paths without a base cloth and on one, on two clips of ../shared/data:
cloth_field_paths.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_field_paths.py
"""
from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE)]
from make_cloth import S1, S2, Scene, Tile, compose, middles, open_scene, play, rumple, scheduler  # noqa: E402

SHOWN = (replace(S1, frames=(61,)), replace(S2, frames=(51,)))
COLUMNS = (("FIELD", "OFF", "Wrinkle Field"), ("FIELD", "HANG", "Wrinkle Field on a base cloth"),
           ("PATHS", "OFF", "Wrinkle Paths"), ("PATHS", "HANG", "Wrinkle Paths on a base cloth"))
WIDTH = 1600  # pixels


def picture(scene: Scene, method: str, base_cloth: str, label: str, folder: Path) -> Tile:
    """A scene in one of the systems, which is added with one click."""
    at = middles(scene)
    open_scene(scene, None)
    for name in scene.garments:
        garment = bpy.context.view_layer.objects.active = bpy.data.objects[name]
        garment.rumple.field.output = "GEOMETRY"
        if base_cloth == "OFF":  # else the click chooses it, and settings that suit it
            getattr(garment.rumple, method.lower()).base_cloth = base_cloth
        assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}, garment.rumple.message
        assert getattr(garment.rumple, method.lower()).base_cloth == base_cloth
    scheduler.sync_all()
    return play(scene, at, lambda frame: label, folder)[0]


def main() -> None:
    from PIL import Image
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        tiles = [picture(scene, *column, Path(folder)) for column in COLUMNS for scene in SHOWN]
        compose(tiles, len(SHOWN), Path(folder) / "sheet.png")
        sheet = Image.open(Path(folder) / "sheet.png")
        sheet.thumbnail((WIDTH, WIDTH))
        sheet.save(HERE / "cloth_field_paths.jpg", quality=88, optimize=True)


if __name__ == "__main__":
    main()
