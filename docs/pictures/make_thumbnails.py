# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the fabrics and of the systems, addon/rumple/thumbnails/*.png: the bent sleeve of the gallery with
every preset and with waves; of Wrinkle Maps the forehead of a lesson (docs/pictures/lessons/face.jpg).

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_thumbnails.py
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
import gallery_scenes  # noqa: E402
import rumple  # noqa: E402
from PIL import Image  # noqa: E402
from rumple.blender.ui import thumbnails  # noqa: E402
from rumple.core.systems.all_systems import SYSTEMS  # noqa: E402

FRAME, FIRST = 28, 10  # played from there
SIZE, SAMPLES = 112, 48
COLOURS = 96  # of a picture: it stays small
VIEW, DISTANCE, LENS = Vector((1.0, -0.75, 0.12)).normalized(), 1.15, 85.0
TARGET = (0.0, 0.0, 0.03)  # metres beside the elbow


FOREHEAD = (940, 120, 1140, 320)  # of the lesson's picture
WAVES = 0.03  # metres from one to the next


def show(method: str, preset: str = "") -> None:
    """The sleeve in that fabric, in its pose."""
    bpy.ops.wm.read_homefile(use_empty=True)
    shirt = gallery_scenes.build_elbow()
    shirt.rumple.field.output, shirt.rumple.field.wavelength = "GEOMETRY", WAVES
    assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}, shirt.rumple.message
    if preset:
        assert bpy.ops.object.rumple_preset(preset=preset) == {"FINISHED"}, shirt.rumple.message
    gallery_light.light(bpy.context.scene)
    plain_ground(bpy.context.scene.world.node_tree)
    gallery_light.dye(shirt, preset or "COTTON")
    for frame in range(FIRST, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    assert not shirt.rumple.message, shirt.rumple.message


def plain_ground(tree: bpy.types.NodeTree) -> None:
    """The sky alone, without the gallery's paper: small pictures beside one another have one ground."""
    sky = next(node for node in tree.nodes if node.type == "BACKGROUND")
    end = next(node for node in tree.nodes if node.type == "OUTPUT_WORLD")
    tree.links.new(sky.outputs[0], end.inputs["Surface"])


def render(path: Path) -> None:
    scene = bpy.context.scene
    skeleton, camera = bpy.data.objects["Skeleton"], scene.camera
    place = skeleton.matrix_world @ skeleton.pose.bones["elbow.L"].head + Vector(TARGET)
    camera.location, camera.data.lens = place + DISTANCE * VIEW, LENS
    camera.rotation_euler = (-VIEW).to_track_quat("-Z", "Y").to_euler()
    scene.cycles.samples = SAMPLES
    scene.render.resolution_x = scene.render.resolution_y = 2 * SIZE
    scene.render.resolution_percentage = 100
    gallery_light.render(path)


def save_small(picture: Image.Image, path: Path) -> None:
    small = picture.convert("RGB").resize((SIZE, SIZE), Image.LANCZOS)
    # Median cut, the usual one, loses the hue of the skin.
    small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1).save(path, optimize=True)


def main() -> None:
    rumple.register()
    thumbnails.FOLDER.mkdir(exist_ok=True)
    save_small(Image.open(HERE / "lessons" / "face.jpg").crop(FOREHEAD), thumbnails.path("MAPS"))
    with tempfile.TemporaryDirectory() as folder:
        for method, system in SYSTEMS.items():
            for preset in system.presets or ("",):
                show(method, preset)
                render(Path(folder) / "large.png")
                save_small(Image.open(Path(folder) / "large.png"), thumbnails.path(method, preset))


if __name__ == "__main__":
    main()
