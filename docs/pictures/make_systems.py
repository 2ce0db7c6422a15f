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
import rumple  # noqa: E402
from contact_sheet import compose  # noqa: E402
from rumple.core.systems.all_systems import SYSTEMS  # noqa: E402

FIRST, FRAME = 9, 59


def look(path: Path, lens: float = 72.0, size: tuple[int, int] = (560, 560)) -> None:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 48, False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *size, 100
    trousers = bpy.data.objects["trousers"].evaluated_get(bpy.context.evaluated_depsgraph_get())
    middle = sum((trousers.matrix_world @ Vector(corner) for corner in trousers.bound_box), Vector()) / 8.0
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(camera)
    place, target = middle + Vector((1.3, -2.2, 0.5)), middle + Vector((0.0, 0.0, 0.1))
    camera.location, camera.rotation_euler = place, (target - place).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens, scene.camera = lens, camera
    scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.25, 0.27, 0.3, 1.0)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        for method in (None, *SYSTEMS):
            bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / "S2_squat_trousers.blend"))
            for garment in ("trousers", "sweater") if method else ():
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
