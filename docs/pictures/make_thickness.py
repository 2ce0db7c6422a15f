# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture of clothes with a modelled thickness for the docs, thickness.jpg: a padded shirt on a torso that turns, as
it is animated, as cloth, and its hem from near.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_thickness.py
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
import gallery_scenes  # noqa: E402
import rumple  # noqa: E402
import scene_motions  # noqa: E402
from contact_sheet import compose, studio  # noqa: E402
from PIL import Image  # noqa: E402
from rumple.blender import compat  # noqa: E402

FRAME, THICKNESS = 26, 0.012  # in the turn; metres
WHOLE = Vector((0.06, 0.0, 1.24)), Vector((0.35, -1.85, 0.15))  # what is looked at, and the way to the camera
HEM = Vector((-0.03, -0.12, 1.02)), Vector((-0.22, -0.52, -0.22))


def padded_shirt() -> bpy.types.Object:
    """A shirt over trousers on the figure that turns, in which Solidify was applied."""
    gallery_scenes.dressed(scene_motions.twist())
    shirt = gallery_scenes.ready("Shirt")
    solidify = shirt.modifiers.new("Thickness", "SOLIDIFY")
    solidify.thickness, solidify.offset = THICKNESS, -1.0
    compat.move_modifier(shirt, len(shirt.modifiers) - 1, 0)
    bpy.ops.object.modifier_apply(modifier="Thickness")
    return shirt


def wrinkle(obj: bpy.types.Object) -> None:
    for other in bpy.context.selected_objects:
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}


def shown(view: tuple[Vector, Vector], path: Path) -> Path:
    camera, (target, way) = bpy.context.scene.camera, view
    camera.location, camera.data.lens = target + way, 50.0
    camera.rotation_euler = (-way).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


def main() -> None:
    rumple.register()
    shirt, scene = padded_shirt(), bpy.context.scene
    studio(scene)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        scene.frame_set(FRAME)
        tiles = [("12 mm thick, as animated", shown(WHOLE, folder / "bare.png"))]
        for obj in (bpy.data.objects["Trousers"], shirt):
            wrinkle(obj)
        for frame in range(scene.frame_start, FRAME + 1):
            scene.frame_set(frame)
        assert not shirt.rumple.message, shirt.rumple.message
        tiles.append(("One click", shown(WHOLE, folder / "cloth.png")))
        scene.display.shading.show_shadows = False  # so near they are noise
        tiles.append(("Its hem", shown(HEM, folder / "hem.png")))
        compose(tiles, 1, folder / "sheet.png")
        Image.open(folder / "sheet.png").save(HERE / "thickness.jpg", quality=82, optimize=True)


if __name__ == "__main__":
    main()
