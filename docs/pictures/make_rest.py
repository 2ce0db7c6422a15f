# SPDX-License-Identifier: GPL-3.0-or-later
"""A jump of ../shared/data, measured against its rest pose and against what lasts: s2_rest.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_rest.py [-- MESH|FIELD]
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
from rumple.blender import scheduler  # noqa: E402
from rumple.blender.objects import properties  # noqa: E402

BEGIN, SHOWN = 9, (57, 105)  # the arms half down; landed from the jump, and standing again
GARMENTS = ("trousers", "sweater")
COLUMNS = (("Rest Pose", {}),
           ("Adaptive, from the rest pose", {"rest_shape": "ADAPTIVE"}),
           ("Adaptive, from the first frame", {"rest_shape": "ADAPTIVE", "reference": "FIRST_FRAME"}))


def prepare(method: str, values: dict[str, str]) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / "S2_squat_trousers.blend"))
    scene = bpy.context.scene
    scene.frame_start = BEGIN
    for name in GARMENTS:
        obj = bpy.context.view_layer.objects.active = bpy.data.objects[name]
        assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}
        if method == "FIELD":
            obj.rumple.field.output = "GEOMETRY"
        for setting, value in values.items():
            setattr(properties.group_of(obj), setting, value)
    scheduler.sync_all()
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 48, False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 420, 560, 100
    scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.25, 0.27, 0.3, 1.0)


def look(path: Path) -> None:
    scene = bpy.context.scene
    depsgraph = bpy.context.evaluated_depsgraph_get()
    corners = [obj.matrix_world @ Vector(corner) for obj in (bpy.data.objects[n].evaluated_get(depsgraph)
                                                             for n in GARMENTS) for corner in obj.bound_box]
    middle = Vector((min(c[i] for c in corners) + max(c[i] for c in corners)) / 2.0 for i in range(3))
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(camera)
    place = middle + Vector((1.5, -2.6, 0.5))
    camera.location, camera.rotation_euler = place, (middle - place).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens, scene.camera = 56.0, camera
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main() -> None:
    method = sys.argv[sys.argv.index("--") + 1] if "--" in sys.argv else "MESH"
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        tiles = []
        for label, values in COLUMNS:
            prepare(method, values)
            for frame in range(BEGIN, max(SHOWN) + 1):
                bpy.context.scene.frame_set(frame)
                if frame in SHOWN:
                    tiles.append((f"{label}" if frame == SHOWN[0] else "", Path(folder) / f"{len(tiles)}.png"))
                    look(tiles[-1][1])
        compose(tiles, len(SHOWN), Path(folder) / "sheet.png")
        from PIL import Image
        name = "s2_rest.jpg" if method == "MESH" else f"s2_rest_{method.lower()}.jpg"
        Image.open(Path(folder) / "sheet.png").save(HERE / name, quality=88, optimize=True)


main()
