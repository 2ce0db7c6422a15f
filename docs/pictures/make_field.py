# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the Wrinkle Field for the docs: field_square.jpg and, with ../shared/data, s1_field.jpg.

    scripts/build
    RUMPLE_NATIVE=build/release/python xvfb-run -a blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_field.py
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
DATA = ROOT.parent / "shared" / "data" / "S1_walk_shirt.blend"
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from contact_sheet import compose  # noqa: E402

CELLS, SPLIT = 8, 12  # figure 15: 128 triangles, and every twelfth of the first 120 in three: 148
FRAME = 60


def engine(name: str) -> None:
    scene = bpy.context.scene
    known = bpy.types.RenderSettings.bl_rna.properties["engine"].enum_items.keys()
    new_name = "BLENDER_EEVEE_NEXT" if "BLENDER_EEVEE_NEXT" in known else "BLENDER_EEVEE"
    scene.render.engine = new_name if name == "EEVEE" else name
    scene.cycles.samples, scene.cycles.use_denoising = 48, False
    scene.view_settings.view_transform = "Standard"


def light(sky: float) -> None:
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (sky, 1.05 * sky, 1.12 * sky, 1.0)


def camera_at(place: Vector, target: Vector, lens: float) -> None:
    scene = bpy.context.scene
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler = place, (target - place).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens, scene.camera = lens, camera


def render(path: Path) -> Path:
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


# ---------------------------------------------------------------- figure 15
def square() -> bpy.types.Object:
    """The irregular square: 91 points, 148 triangles, side 1 m."""
    random = np.random.RandomState(1)
    grid = [(i, j) for j in range(CELLS + 1) for i in range(CELLS + 1)]
    shaken = [(i + random.uniform(-0.3, 0.3) * (0 < i < CELLS), j + random.uniform(-0.3, 0.3) * (0 < j < CELLS), 0.0)
              for i, j in grid]
    points = [np.array(p) / CELLS for p in shaken]
    triangles = []
    for v, (i, j) in enumerate(grid):
        if i < CELLS and j < CELLS:
            a, b, c, d = v, v + 1, v + CELLS + 2, v + CELLS + 1
            triangles += [(a, b, c), (a, c, d)] if random.rand() < 0.5 else [(a, b, d), (b, c, d)]
    for which in range(0, 10 * SPLIT, SPLIT):
        a, b, c = triangles[which]
        points.append((points[a] + points[b] + points[c]) / 3.0)
        middle = len(points) - 1
        triangles[which] = (a, b, middle)
        triangles += [(b, c, middle), (c, a, middle)]
    mesh = bpy.data.meshes.new("Square")
    mesh.from_pydata([p.tolist() for p in points], [], triangles)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(triangles), bool))
    obj = bpy.data.objects.new("Square", mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.shape_key_add(name="Basis")
    for point in obj.shape_key_add(name="Contracted").data:
        point.co.x = 0.5
    obj.data.shape_keys.key_blocks["Contracted"].slider_min = -1.0
    return obj


def wave(width: float, **settings: object) -> None:
    """The square contracted to this share of its width, waving."""
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = square()
    bpy.context.view_layer.update()
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    obj.data.shape_keys.key_blocks["Contracted"].value = 1.0 - width
    field = obj.rumple.field
    field.wavelength = 0.125
    for name, value in settings.items():
        setattr(field, name, value)
    assert bpy.ops.object.rumple_add(method="FIELD") == {"FINISHED"}
    bpy.context.scene.frame_set(1)
    assert obj.rumple.message == "", obj.rumple.message
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.3, (0.3, 0.95, 0.0)
    bpy.context.scene.collection.objects.link(sun)
    light(0.12)
    camera_at(Vector((0.5, -0.75, 1.55)), Vector((0.5, 0.47, 0.0)), 58.0)
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 420, 340


def make_square(folder: Path) -> None:
    tiles = []
    for label, width, settings in (
            ("98 %", 0.98, {}), ("75 %", 0.75, {}), ("50 %", 0.5, {}),
            ("50 %, random phases", 0.5, dict(start="RANDOM", start_rounds=0)),
            ("50 %, relaxed as printed", 0.5, dict(start="RANDOM", start_rounds=1000)),
            ("50 %, accordion pleats as geometry", 0.5, dict(profile="ACCORDION", output="GEOMETRY", detail=16))):
        wave(width, **settings)
        engine("CYCLES")
        tiles.append((label, render(folder / f"square{len(tiles)}.png")))
    # compose() fills columns: pair the tiles so that rows read from left to right.
    save([tiles[i] for i in (0, 3, 1, 4, 2, 5)], folder, "field_square.jpg")


# ---------------------------------------------------------------- the walking shirt
def make_s1(folder: Path) -> None:
    tiles = []
    for label, name, waving in (("Unwrinkled, Cycles", "CYCLES", False), ("Wrinkle Field, Cycles", "CYCLES", True),
                                ("Unwrinkled, EEVEE", "EEVEE", False), ("Wrinkle Field, EEVEE", "EEVEE", True)):
        bpy.ops.wm.open_mainfile(filepath=str(DATA))
        scene = bpy.context.scene
        for garment in ("shirt", "trousers") if waving else ():
            bpy.context.view_layer.objects.active = bpy.data.objects[garment]
            assert bpy.ops.object.rumple_add(method="FIELD") == {"FINISHED"}
        for frame in range(1, FRAME + 1):
            scene.frame_set(frame)
        shirt = bpy.data.objects["shirt"].evaluated_get(bpy.context.evaluated_depsgraph_get())
        middle = sum((shirt.matrix_world @ Vector(corner) for corner in shirt.bound_box), Vector()) / 8.0
        camera_at(middle + Vector((-0.9, -2.4, 0.2)), middle + Vector((0.0, 0.0, -0.2)), 85.0)
        light(0.25)
        engine(name)
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 560, 640, 100
        tiles.append((label, render(folder / f"s1{len(tiles)}.png")))
    save([tiles[i] for i in (0, 2, 1, 3)], folder, "s1_field.jpg")


def save(tiles: list[tuple[str, Path]], folder: Path, name: str) -> None:
    from PIL import Image
    compose(tiles, 2, folder / "sheet.png")
    Image.open(folder / "sheet.png").save(HERE / name, quality=88, optimize=True)


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        make_square(Path(folder))
        if DATA.exists():
            make_s1(Path(folder))


main()
