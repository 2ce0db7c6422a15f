# SPDX-License-Identifier: GPL-3.0-or-later
"""A flag and the lesson's skirt in Wind and Turbulence: force_fields.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_force_fields.py
"""
from __future__ import annotations

import math
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import bpy
from mathutils import Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import demo_scene  # noqa: E402
import gallery_light  # noqa: E402
import lesson_scenes  # noqa: E402
import rumple  # noqa: E402
from contact_sheet import compose  # noqa: E402

FRAMES = (12, 24, 36, 48, 60)
TILE = (360, 330)


def add_field(kind: str, turned: tuple[float, float, float] = (0.0, 0.0, 0.0), **settings: Any) -> bpy.types.Object:
    bpy.ops.object.effector_add(type=kind, rotation=turned)
    effector = bpy.context.object
    for name, value in settings.items():
        setattr(effector.field, name, value)
    return effector


def blow(wind: float, turbulence: float, size: float) -> None:
    """Along x, and gusts that go along with it."""
    add_field("WIND", (0.0, math.pi / 2, 0.0), strength=wind)
    gusts = add_field("TURBULENCE", strength=turbulence, size=size)
    for frame in FRAMES[0], FRAMES[-1]:
        gusts.location.x = wind * frame / 24.0
        gusts.keyframe_insert("location", index=0, frame=frame)
    curve = gusts.animation_data.action.fcurves[0]
    curve.extrapolation = "LINEAR"
    for point in curve.keyframe_points:
        point.interpolation = "LINEAR"


def swing(obj: bpy.types.Object, room: float, mass: float) -> None:
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}
    settings = obj.rumple.mesh
    settings.base_cloth, settings.layers, settings.room, settings.mass = "SWING", "CLOTH", room, mass


def build_flag() -> Vector:
    """On a pole, pinned there. Returns what the camera looks at."""
    demo_scene.clear_scene()
    bpy.ops.mesh.primitive_cylinder_add(radius=0.015, depth=2.4, location=(-0.012, 0.0, -0.3))
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=36, y_subdivisions=24, size=1.0)
    flag = bpy.context.object
    for vertex in flag.data.vertices:
        vertex.co = (1.5 * (vertex.co.x + 0.5), 0.0, vertex.co.y)
    flag.data.polygons.foreach_set("use_smooth", [True] * len(flag.data.polygons))
    follow = flag.vertex_groups.new(name="Rumple Follow")
    for vertex in flag.data.vertices:
        follow.add([vertex.index], float(vertex.co.x < 0.01), "REPLACE")
    material = bpy.data.materials.new("Flag")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value, shader.inputs["Roughness"].default_value = (0.5, 0.07, 0.05, 1.0), 0.7
    flag.data.materials.append(material)
    swing(flag, 0.8, 0.12)
    blow(9.0, 25.0, 0.6)
    return Vector((0.68, 0.0, -0.1))


def build_skirt() -> Vector:
    """On the figure, that stands still. Returns what the camera looks at."""
    skirt = lesson_scenes.build_skirt_scene()
    skirt.parent.animation_data_clear()
    skirt.parent.rotation_euler.z = 0.0
    swing(skirt, 0.3, 0.12)
    blow(5.0, 12.0, 0.5)
    return Vector((0.05, 0.0, 0.78))


def look(at: Vector, away: float) -> None:
    scene = bpy.context.scene
    gallery_light.light(scene)
    scene.cycles.samples, (scene.render.resolution_x, scene.render.resolution_y) = 16, TILE
    scene.render.resolution_percentage, scene.frame_start, scene.frame_end = 100, 1, FRAMES[-1]
    camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(camera)
    camera.data.lens, scene.camera = 48.0, camera
    camera.location = at + away * Vector((0.05, -1.0, 0.12))
    camera.rotation_euler = (at - camera.location).to_track_quat("-Z", "Y").to_euler()


def main() -> None:
    rumple.register()
    bpy.context.preferences.view.show_splash = False
    with tempfile.TemporaryDirectory() as folder:
        found: dict[tuple[int, int], tuple[str, Path]] = {}
        for row, (name, build, away) in enumerate((("flag", build_flag, 3.0), ("skirt", build_skirt, 2.2))):
            look(build(), away)
            scene = bpy.context.scene
            for frame in range(1, FRAMES[-1] + 1):
                scene.frame_set(frame)
                if frame in FRAMES:
                    found[frame, row] = f"{name}, frame {frame}", Path(folder) / f"{name}{frame}.png"
                    gallery_light.render(found[frame, row][1])
        compose([found[key] for key in sorted(found)], 2, Path(folder) / "sheet.png")
        from PIL import Image
        Image.open(Path(folder) / "sheet.png").save(HERE / "force_fields.jpg", quality=86, optimize=True)


if __name__ == "__main__":
    main()
