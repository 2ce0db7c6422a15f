# SPDX-License-Identifier: GPL-3.0-or-later
"""The systems side by side on a jump of ../shared/data: s2_systems.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_systems.py
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
import rumple  # noqa: E402
from contact_sheet import compose  # noqa: E402
from rumple.core.systems.all_systems import SYSTEMS  # noqa: E402

FIRST, FRAME = 9, 45
TOWARDS, DISTANCE, LENS = Vector((-0.42, -0.9, 0.08)), 2.5, 62.0  # from the middle of the figure to the camera
SIZE = 560, 640
GARMENTS = "trousers", "sweater"


def look(path: Path) -> None:
    scene, depsgraph = bpy.context.scene, bpy.context.evaluated_depsgraph_get()
    gallery_light.light(scene)
    for name in GARMENTS:
        gallery_light.as_cloth(bpy.data.objects[name])
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE, 100
    body = bpy.data.objects["Body"].evaluated_get(depsgraph)
    middle = sum((body.matrix_world @ Vector(corner) for corner in body.bound_box), Vector()) / 8.0
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(camera)
    camera.location = middle + DISTANCE * TOWARDS + Vector((0.0, 0.0, 0.14))
    camera.rotation_euler = TOWARDS.to_track_quat("Z", "Y").to_euler()
    camera.data.lens, scene.camera = LENS, camera
    gallery_light.render(path)


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        for method in (None, *SYSTEMS):
            bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / "S2_squat_trousers.blend"))
            for garment in GARMENTS if method else ():
                bpy.context.view_layer.objects.active = bpy.data.objects[garment]
                assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}
            for frame in range(FIRST, FRAME + 1):
                bpy.context.scene.frame_set(frame)
            tiles.append((SYSTEMS[method].label if method else "Bare", Path(folder) / f"{len(tiles)}.png"))
            look(tiles[-1][1])
        compose([tiles[i] for i in (0, 2, 1, 3)], 2, Path(folder) / "sheet.png")  # it fills columns
        from PIL import Image
        Image.open(Path(folder) / "sheet.png").save(HERE / "s2_systems.jpg", quality=88, optimize=True)


if __name__ == "__main__":
    main()
