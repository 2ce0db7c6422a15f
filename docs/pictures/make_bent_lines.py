# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo's trousers in a squat, folds along any line and only along straight ones: bent_lines.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_bent_lines.py
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
import demo_scene  # noqa: E402
import rumple  # noqa: E402
from contact_sheet import compose, studio  # noqa: E402
from rumple.core.cloth import base_cloth  # noqa: E402
from rumple.core.systems.all_systems import SYSTEMS  # noqa: E402

FRAMES = range(40, 51)
FROM, MIDDLE = Vector((-0.8, -1.0, 0.15)).normalized(), Vector((0.0, 0.05, 0.44))


def look(path: Path) -> None:
    """The knees, from the side."""
    scene = bpy.context.scene
    studio(scene)
    scene.render.resolution_x, scene.render.resolution_y = 430, 560
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(camera)
    camera.data.lens, scene.camera = 80.0, camera
    camera.location, camera.rotation_euler = MIDDLE + 2.2 * FROM, (-FROM).to_track_quat("-Z", "Y").to_euler()
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        for method in ("MESH", "FIELD", "PATHS"):
            for label, least_bend in (("any line", 0.0), ("straight lines", base_cloth.LEAST_BEND)):
                base_cloth.LEAST_BEND = least_bend
                demo_scene.build_demo_scene()
                trousers = bpy.context.view_layer.objects.active = bpy.data.objects["Trousers"]
                trousers.rumple.field.output = "GEOMETRY"
                assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}
                for frame in FRAMES:
                    bpy.context.scene.frame_set(frame)
                tiles.append((f"{SYSTEMS[method].label}, {label}", Path(folder) / f"{len(tiles)}.png"))
                look(tiles[-1][1])
        compose(tiles, 2, Path(folder) / "sheet.png")
        from PIL import Image
        Image.open(Path(folder) / "sheet.png").save(HERE / "bent_lines.jpg", quality=88, optimize=True)


if __name__ == "__main__":
    main()
