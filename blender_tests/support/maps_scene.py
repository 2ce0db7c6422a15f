# SPDX-License-Identifier: GPL-3.0-or-later
"""A face with Wrinkle Maps for an engine: exported, and pictures of its normals. In a Blender of its own:
blender -b --python maps_scene.py -- FOLDER FRAME..."""
from __future__ import annotations

import os
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[2] / "addon"),
                os.environ["RUMPLE_NATIVE"]]
import addon_utils  # noqa: E402

addon_utils.enable("rumple", default_set=True)
addon_utils.enable("io_scene_gltf2")

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from mathutils import Euler  # noqa: E402
from rumple.blender import scheduler  # noqa: E402
from support import face, maps_renders  # noqa: E402

SIDE, SIZE, WIDTH = 64, 256, 0.14  # texels of a map; pixels and metres of a picture
FRAMES, FAR = 11, 0.001  # metres: of the reference poses


def waves(name: str, along: int, crests: float) -> bpy.types.Image:
    """A normal map of sines along u (0) or v (1), steep enough to be seen."""
    place = (np.arange(SIDE) + 0.5) / SIDE
    slope = 0.6 * np.cos(2.0 * np.pi * crests * place)
    normals = np.zeros((SIDE, SIDE, 3))
    normals[..., along] = slope[None, :] if along == 0 else slope[:, None]
    normals[..., 2] = np.sqrt(1.0 - normals[..., along] ** 2)
    image = bpy.data.images.new(name, SIDE, SIDE, is_data=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((SIDE, SIDE, 4), np.float32)
    pixels[..., :3] = np.rint(255.0 * (0.5 * normals + 0.5)) / 255.0
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def animated_face() -> bpy.types.Object:
    """The left brow goes up, the right one down, from frame 1 to 11. By a millimetre: influences compare with the
    reference poses, and an engine turns tangents with the bones where Blender makes them of the deformed mesh."""
    obj, rig = face.scene()
    for name, heights in (("Surprise", dict(brow_L=FAR, brow_R=FAR)), ("Anger", dict(brow_L=-FAR, brow_R=-FAR))):
        face.pose(rig, **heights)
        bpy.ops.rumple.pose_add(name=name)
    settings = obj.rumple_maps
    obj.data.materials[0] = maps_renders.material("Skin", waves("Neutral", 0, 9.0))
    for pose, name, along in zip(settings.poses, ("Up", "Down"), (1, 0)):
        pose.image = waves(name, along, 5.0)
    settings.poses[1].strength = 0.7
    bpy.ops.rumple.maps_show()
    for frame, share in ((1, 0.0), (FRAMES, 1.0)):
        face.pose(rig, brow_L=0.9 * FAR * share, brow_R=-0.6 * FAR * share)
        for name in face.BROWS:
            rig.pose.bones[name].keyframe_insert("location", frame=frame)
    for curve in face.compat.keyed_curves(rig.animation_data):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    scheduler.sync_all()
    return obj


def export(obj: bpy.types.Object, folder: Path) -> None:
    bpy.ops.rumple.maps_export(filepath=str(folder / "face.json"), images=True, frames=True)
    bare = obj.copy()  # the sample needs no wrinkles of Blender's, and no material
    bare.data = obj.data.copy()
    bare.data.materials.clear()
    bare.modifiers.remove(next(m for m in bare.modifiers if m.type == "NODES"))
    bpy.context.scene.collection.objects.link(bare)
    for other in bpy.data.objects:
        other.select_set(other == bare or other.type == "ARMATURE")
    bpy.ops.export_scene.gltf(filepath=str(folder / "face.glb"), export_format="GLB", use_selection=True,
                              export_yup=True, export_materials="NONE", export_animations=True, export_skins=True)
    bpy.data.objects.remove(bare)


def render(folder: Path, frames: list[int]) -> None:
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", WIDTH
    camera.location, camera.rotation_euler = (0.0, -1.0, 0.0), Euler((np.pi / 2.0, 0.0, 0.0))
    scene.collection.objects.link(camera)
    scene.camera, scene.render.engine, scene.view_settings.view_transform = camera, "CYCLES", "Raw"
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "8"
    if scene.world is not None:
        scene.world.color = (0.0, 0.0, 0.0)
    for frame in frames:
        scene.frame_set(frame)
        scene.render.filepath = str(folder / f"blender_{frame}.png")
        bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    to, *numbers = sys.argv[sys.argv.index("--") + 1:]
    Path(to).mkdir(parents=True)
    shown = animated_face()
    export(shown, Path(to))
    maps_renders.emit_normals(shown.data.materials[0].node_tree)
    render(Path(to), [int(number) for number in numbers])
