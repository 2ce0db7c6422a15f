# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of the Wrinkle Maps: s4_face.jpg and s4_face_close.jpg, from a scene of ../shared/data.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup ../shared/data/S4_face_expressions.blend \
        --python-exit-code 1 --python docs/pictures/make_face.py
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
import face_poses  # noqa: E402
import rumple  # noqa: E402
from contact_sheet import compose  # noqa: E402

SHOWN = ("Neutral", "Surprise", "One brow up", "Anger", "Laughing", "Crying")
CLOSE = {"Surprise": (0.02, -0.15, 0.858), "Laughing": (0.028, -0.15, 0.778)}  # what close-ups look at
VIEW = Vector((0.35, -1.0, 0.05)).normalized()
SIZE = 2048  # texels


def stage(head: bpy.types.Object) -> None:
    """Skin, a low sun and a camera before the face; Cycles."""
    scene = bpy.context.scene
    for light in [o for o in bpy.data.objects if o.type == "LIGHT"]:
        bpy.data.objects.remove(light)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle = 3.5, 0.05
    sun.rotation_euler = Vector((0.6, -0.6, 1.3)).to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("Studio")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.25, 0.27, 0.32, 1.0)
    shader = next(n for n in head.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (0.55, 0.36, 0.28, 1.0)
    shader.inputs["Roughness"].default_value = 0.5
    camera, middle = scene.camera, head.matrix_world @ Vector((-0.005, -0.066, 0.79))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.19
    camera.location = middle + 2.0 * VIEW
    camera.rotation_euler = VIEW.to_track_quat("Z", "Y").to_euler()
    render = scene.render
    render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 40, False
    render.resolution_x, render.resolution_y, render.resolution_percentage = 330, 400, 100


def show(rig: bpy.types.Object, clip: bpy.types.Action, name: str) -> None:
    """An expression of the clip, the brows raised in some: so that it stays when a render plays the frame."""
    rig.animation_data.action = clip if name != "One brow up" else None
    face_poses.go_to(rig, face_poses.HELD.get(name, 1))
    if name in ("Surprise", "One brow up"):
        face_poses.raise_brows(rig, face_poses.BROWS if name == "Surprise" else face_poses.BROWS[:1])


def influences(head: bpy.types.Object) -> bpy.types.Material:
    """A material that shows the masks: the first pose in red, the second in green."""
    material = head.data.materials[0].copy()
    tree = material.node_tree
    shader = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    masks, colour = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeVectorMath")
    masks.attribute_name = "rumple_poses_0"
    colour.operation = "MULTIPLY_ADD"
    colour.inputs[1].default_value, colour.inputs[2].default_value = (0.7, 0.5, 0.0), (0.08, 0.08, 0.08)
    tree.links.new(masks.outputs["Vector"], colour.inputs[0])
    tree.links.new(colour.outputs["Vector"], shader.inputs["Base Color"])
    return material


def picture(head: bpy.types.Object, muted: bool, material: bpy.types.Material, path: Path) -> Path:
    head.data.materials[0] = material
    for pose in head.rumple_maps.poses:
        pose.muted = muted
    bpy.context.view_layer.update()
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


def look_closely(head: bpy.types.Object, place: tuple[float, float, float]) -> None:
    scene = bpy.context.scene
    scene.camera.location = head.matrix_world @ Vector(place) + 2.0 * VIEW
    scene.camera.data.ortho_scale = 0.085
    scene.render.resolution_x, scene.render.resolution_y = 560, 440


def save(tiles: list[tuple[str, Path]], rows: int, path: Path) -> None:
    """As JPEG."""
    from PIL import Image
    sheet = tiles[0][1].with_name("sheet.png")
    compose(tiles, rows, sheet)
    Image.open(sheet).save(path, quality=82, optimize=True)


def main() -> None:
    rumple.register()
    head, rig = bpy.data.objects["Head"], bpy.data.objects["HeadRig"]
    face_poses.add_maps(head, rig, SIZE)
    stage(head)
    skin, clip = head.data.materials[0], rig.animation_data.action
    coloured = influences(head)
    with tempfile.TemporaryDirectory() as folder:
        tiles: list[tuple[str, Path]] = []

        def add(label: str, muted: bool, material: bpy.types.Material) -> None:
            tiles.append((label, picture(head, muted, material, Path(folder) / f"{len(tiles)}.png")))

        for name in SHOWN:
            show(rig, clip, name)
            add(name, True, skin)
            add("Influences", False, coloured)
            add("Wrinkle Maps", False, skin)
        save(tiles, 3, HERE / "s4_face.jpg")
        tiles.clear()
        for name, place in CLOSE.items():
            show(rig, clip, name)
            look_closely(head, place)
            add(name, True, skin)
            add("Wrinkle Maps", False, skin)
        save(tiles, 2, HERE / "s4_face_close.jpg")


if __name__ == "__main__":
    main()
