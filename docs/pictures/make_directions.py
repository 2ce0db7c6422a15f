# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides of the kind Direction: the demo's shirt with the folds that motion makes, and with folds along a curve that is
laid across it, in three systems: directions.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_directions.py
"""
from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import demo_scene  # noqa: E402
import rumple  # noqa: E402
from contact_sheet import compose, studio  # noqa: E402
from rumple.blender import scheduler  # noqa: E402
from rumple.blender.objects import runtimes  # noqa: E402
from rumple.core.systems.all_systems import SYSTEMS  # noqa: E402

FRAMES = range(28, 37)
FROM, MIDDLE = Vector((0.25, -1.0, 0.1)).normalized(), Vector((0.0, 0.0, 1.22))
REACH = 0.3  # metres
ENDS = np.array([[0.13, 1.02], [-0.02, 1.2], [-0.12, 1.4]])  # x, z on the front of the shirt at rest


def lay_curve(shirt: bpy.types.Object) -> None:
    """From a hip to the other shoulder."""
    data = bpy.data.curves.new("Direction", "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.0015
    spline = data.splines.new("POLY")
    rest = np.array([vertex.co for vertex in shirt.data.vertices])
    front = rest[rest[:, 1] < 0.0]
    places = np.stack([np.interp(np.linspace(0, 2, 9), (0, 1, 2), ENDS[:, k]) for k in (0, 1)], axis=1)
    spline.points.add(len(places) - 1)
    for point, place in zip(spline.points, places):
        point.co = (*front[np.linalg.norm(front[:, [0, 2]] - place, axis=1).argmin()], 1.0)
    curve = bpy.data.objects.new("Direction", data)
    bpy.context.scene.collection.objects.link(curve)
    bpy.context.view_layer.update()
    curve.select_set(True)
    shirt.select_set(True)
    assert bpy.ops.object.rumple_guide_add() == {"FINISHED"}
    curve.rumple_guide.kind, curve.rumple_guide.reach = "DIRECTION", REACH
    curve.hide_render = True


def look(path: Path) -> None:
    scene = bpy.context.scene
    studio(scene)
    scene.render.resolution_x, scene.render.resolution_y = 380, 420
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(camera)
    camera.data.lens, scene.camera = 80.0, camera
    camera.location, camera.rotation_euler = MIDDLE + 1.9 * FROM, (-FROM).to_track_quat("-Z", "Y").to_euler()
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        for method in ("MESH", "FIELD", "PATHS"):
            for guided in (False, True):
                demo_scene.build_demo_scene()
                shirt = bpy.context.view_layer.objects.active = bpy.data.objects["Shirt"]
                shirt.rumple.field.output = "GEOMETRY"
                assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}
                if guided:
                    lay_curve(shirt)
                scheduler.sync_all()
                for frame in FRAMES:
                    bpy.context.scene.frame_set(frame)
                assert not shirt.rumple.message, shirt.rumple.message
                print("| ", runtimes.of(shirt).evaluator.status(runtimes.of(shirt).result), flush=True)
                label = "folds along the curve" if guided else "as motion makes them"
                tiles.append((f"{SYSTEMS[method].label}, {label}", Path(folder) / f"{len(tiles)}.png"))
                look(tiles[-1][1])
        compose(tiles, 2, Path(folder) / "sheet.png")
        from PIL import Image
        Image.open(Path(folder) / "sheet.png").save(HERE / "directions.jpg", quality=86, optimize=True)


if __name__ == "__main__":
    main()
