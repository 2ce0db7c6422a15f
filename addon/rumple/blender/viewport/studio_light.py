# SPDX-License-Identifier: GPL-3.0-or-later
"""What a Solid viewport lights and colours an object with, as the preview's shader takes it."""
from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector

_DEFAULT_ROUGHNESS = 0.4  # of what has no material of its own, as Blender has it


@dataclass
class Lights:
    """Four lights in view space, as shaders/preview/preview_block.glsl orders them."""

    direction: np.ndarray  # (4, 4) float32
    diffuse: np.ndarray  # (4, 4), w: wrap
    specular: np.ndarray  # (4, 4)
    ambient: np.ndarray  # (4,)
    has_specular: bool


@dataclass
class Finish:
    """The surface of one material slot."""

    color: tuple[float, ...]  # three, scene linear
    metallic: float = 0.0
    roughness: float = math.sqrt(_DEFAULT_ROUGHNESS)
    image: bpy.types.Image | None = None

    def __post_init__(self) -> None:
        # Blender's own engine keeps both in eight bits, which shows.
        self.metallic, self.roughness = math.floor(self.metallic * 7.0) / 7.0, math.floor(self.roughness * 31.0) / 31.0


def lights(shading: bpy.types.View3DShading, view: Matrix) -> Lights:
    """Of a viewport with this view matrix. A MatCap has no lights: it gets those of the preferences."""
    found = Lights(np.zeros((4, 4), np.float32), np.zeros((4, 4), np.float32), np.zeros((4, 4), np.float32),
                   np.zeros(4, np.float32), shading.show_specular_highlight)
    if shading.light == "FLAT":
        found.ambient[:] = 1.0
        found.has_specular = False
        return found
    system = bpy.context.preferences.system
    studio = system if shading.light != "STUDIO" or system.use_studio_light_edit else shading.selected_studio_light
    turn = Matrix.Identity(3)
    if shading.light == "STUDIO" and shading.use_world_space_lighting:
        upright = Matrix.Rotation(0.5 * math.pi, 3, "X")  # their y, up in the view, is the world's z
        turn = view.to_3x3() @ Matrix.Rotation(-shading.studiolight_rotate_z, 3, "Z") @ upright
    for i, light in enumerate(studio.solid_lights):
        if light.use:
            found.direction[i, :3] = turn @ Vector(light.direction)
            found.diffuse[i] = (*light.diffuse_color, light.smooth)
            found.specular[i, :3] = light.specular_color
    found.ambient[:3] = studio.light_ambient
    return found


def finish(obj: bpy.types.Object, slot: int, shading: bpy.types.View3DShading) -> Finish:
    """Of a material slot, by the viewport's colour setting; attribute and random colours show the material's."""
    if shading.color_type == "SINGLE":
        return Finish(tuple(shading.single_color))
    if shading.color_type == "OBJECT":
        return Finish(tuple(obj.color[:3]))
    material = obj.material_slots[slot].material if slot < len(obj.material_slots) else None
    if material is None:
        return Finish((0.8, 0.8, 0.8))
    image = _image_of(material) if shading.color_type == "TEXTURE" else None
    return Finish(tuple(material.diffuse_color[:3]), material.metallic, math.sqrt(material.roughness), image)


def _image_of(material: bpy.types.Material) -> bpy.types.Image | None:
    """The image that Texture colour shows: of the active image node, or of the first. None where it has no file."""
    if material.node_tree is None:
        return None
    nodes = [node for node in material.node_tree.nodes if node.type == "TEX_IMAGE" and node.image is not None
             and node.image.source != "TILED" and min(node.image.size) > 0]
    active = material.node_tree.nodes.active
    chosen = active if active in nodes else next(iter(nodes), None)
    return chosen.image if chosen is not None else None
