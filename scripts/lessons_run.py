# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows a lesson of docs/lessons inside Blender and renders the picture that it ends in. Started by scripts/lessons.

A lesson's page has the same steps as Python, in its block "python": that is what runs here, in the lesson's scene.
"""
from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import bpy
from mathutils import Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import demo_scene  # noqa: E402
import lesson_scenes  # noqa: E402

PAGES = HERE.parent / "docs" / "lessons"
MOST_BYTES = 150_000


def shirt_example() -> bpy.types.Object:
    """The example Shirt as it opens: dressed, each garment with a Wrinkle Mesh."""
    shirt = demo_scene.build_demo_scene()
    demo_scene.add_wrinkles("MESH")
    return shirt


@dataclass(frozen=True)
class Lesson:
    """Where a lesson begins, and the picture that it ends in."""

    begin: Callable[[], bpy.types.Object]
    camera: tuple[float, float, float]  # metres
    target: tuple[float, float, float]
    lens: float  # millimetres
    size: tuple[int, int] = (640, 640)


LESSONS = {
    "first_wrinkles": Lesson(shirt_example, (0.95, -2.85, 1.45), (0.035, 0.0, 1.348), 91.0),
    "skirt": Lesson(lesson_scenes.build_skirt_scene, (0.6, -2.9, 1.0), (0.0, 0.0, 0.86), 100.0),
    "painting": Lesson(shirt_example, (0.1, -2.9, 1.40), (0.0, 0.0, 1.30), 105.0),
    "face": Lesson(lesson_scenes.build_face_scene, (0.12, -1.1, 1.70), (0.0, -0.03, 1.69), 130.0),
    "bake": Lesson(shirt_example, (-0.95, -2.85, 1.40), (0.035, 0.0, 1.33), 91.0),
}


def script_of(name: str) -> str:
    """The Python of a lesson's page."""
    found = re.findall(r"^```python\n(.*?)^```", (PAGES / f"{name}.md").read_text(encoding="utf-8"), re.M | re.S)
    if len(found) != 1:
        raise ValueError(f"{name}.md has {len(found)} blocks of Python: one is wanted")
    return found[0]


def follow(name: str) -> bpy.types.Object:
    """Begin a lesson and do what it says. Returns the object that it is about."""
    obj = LESSONS[name].begin()
    exec(compile(script_of(name), f"{name}.md", "exec"), {"__name__": name})
    return obj


def look(lesson: Lesson, samples: int) -> None:
    """Cycles, with the lesson's camera and size."""
    scene = bpy.context.scene
    camera = scene.camera
    camera.location, camera.data.lens = lesson.camera, lesson.lens
    camera.rotation_euler = (Vector(lesson.target) - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", samples, False
    scene.render.resolution_x, scene.render.resolution_y = lesson.size
    scene.render.image_settings.file_format = "PNG"


def render(path: Path) -> Path:
    """The frame of now, as it stands: what is posed by hand stays."""
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


def save(tiles: list[Path], path: Path) -> None:
    """Side by side, as JPEG."""
    from PIL import Image
    pictures = [Image.open(tile).convert("RGB") for tile in tiles]
    sheet = Image.new("RGB", (sum(one.width for one in pictures), pictures[0].height))
    for number, one in enumerate(pictures):
        sheet.paste(one, (number * one.width, 0))
    for quality in range(90, 40, -5):
        sheet.save(path, quality=quality, optimize=True)
        if path.stat().st_size < MOST_BYTES:
            break
    print(f"| {path.name} {path.stat().st_size / 1e3:.0f} kB", flush=True)


def bare(obj: bpy.types.Object, shown: bool, off: list[bpy.types.Modifier]) -> None:
    """Switch everything that makes wrinkles off, or on again, but for what the lesson has switched off itself."""
    for modifier in obj.modifiers:
        if modifier.type == "NODES" and modifier not in off:
            modifier.show_render = modifier.show_viewport = shown
    for pose in obj.rumple_maps.poses:
        pose.muted = not shown
    bpy.context.view_layer.update()


def main() -> None:
    parser = argparse.ArgumentParser(prog="scripts/lessons")
    parser.add_argument("--lesson", required=True, choices=LESSONS)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--samples", type=int, default=48)
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    import rumple
    rumple.register()
    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / "lesson.blend"))
        obj = follow(options.lesson)
        look(LESSONS[options.lesson], options.samples)
        tiles = []
        off = [modifier for modifier in obj.modifiers if not modifier.show_render]
        for name, shown in (("after", True), ("before", False)):
            bare(obj, shown, off)
            tiles.append(render(Path(folder) / f"{name}.png"))
        save(tiles[::-1], options.out / f"{options.lesson}.jpg")


if __name__ == "__main__":
    main()
