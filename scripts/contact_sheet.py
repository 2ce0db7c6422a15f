# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact sheets: a studio look for any scene, a camera that sees the whole clip, tiles put together."""
from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Vector

if TYPE_CHECKING:
    from PIL import ImageFont

TILE = (560, 640)
VIEW = Vector((-0.55, -1.0, 0.22)).normalized()  # from the target to the camera: half from the side, a little above
LENS = 85.0
BACKGROUND = (0.30, 0.32, 0.35)
LABEL = 26  # pixels above a picture


def studio(scene: bpy.types.Scene) -> None:
    """Workbench with studio light and soft shadows; materials keep their viewport colours."""
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x, scene.render.resolution_y = TILE
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.view_settings.view_transform = "Standard"
    shading = scene.display.shading
    shading.light, shading.color_type = "STUDIO", "MATERIAL"
    if "paint.sl" in {light.name for light in bpy.context.preferences.studio_lights}:
        shading.studio_light = "paint.sl"
    shading.show_cavity = shading.show_object_outline = False
    shading.show_shadows, shading.shadow_intensity = True, 0.35
    scene.display.light_direction = Vector((-0.45, 0.55, 0.70)).normalized()
    scene.world = bpy.data.worlds.new("Contact Sheet")
    scene.world.color = BACKGROUND
    scene.display.render_aa = "8"


def frame_camera(garment: bpy.types.Object, frames: range) -> None:
    """A camera that follows the garment: parented to nothing, keyed at every frame to the middle of its bounds."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Contact Sheet", bpy.data.cameras.new("Contact Sheet"))
    scene.collection.objects.link(camera)
    camera.data.lens = LENS
    scene.camera = camera
    radius = 0.0
    middles = {}
    for frame in frames:
        scene.frame_set(frame)
        corners = np.array([garment.matrix_world @ Vector(corner) for corner in garment.bound_box])
        middles[frame] = Vector((corners.min(0) + corners.max(0)) / 2)
        radius = max(radius, float(np.linalg.norm(np.ptp(corners, axis=0))) / 2)
    distance = 2.6 * radius * LENS / 36.0
    camera.rotation_euler = (-VIEW).to_track_quat("-Z", "Y").to_euler()
    for frame, middle in middles.items():
        camera.location = middle + distance * VIEW
        camera.keyframe_insert("location", frame=frame)


def label_font() -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Of what stands above a picture; where it is not installed, the small one that Pillow has. Needs Pillow."""
    from PIL import ImageFont
    try:
        return ImageFont.truetype("DejaVuSans.ttf", 14)
    except OSError:
        return ImageFont.load_default()


def compose(tiles: list[tuple[str, Path]], rows: int, path: Path) -> None:
    """Tiles in columns of `rows`, each with its label, as one PNG. Needs Pillow."""
    from PIL import Image, ImageDraw
    pictures = [(label, Image.open(tile).convert("RGB")) for label, tile in tiles]
    width, height = pictures[0][1].size
    font = label_font()
    sheet = Image.new("RGB", (width * (len(tiles) // rows), (height + LABEL) * rows), (24, 24, 26))
    pen = ImageDraw.Draw(sheet)
    for number, (label, picture) in enumerate(pictures):
        x, y = width * (number // rows), (height + LABEL) * (number % rows)
        sheet.paste(picture, (x, y + LABEL))
        pen.text((x + 8, y + 5), label, fill=(225, 225, 225), font=font)
    sheet.save(path, optimize=True)
