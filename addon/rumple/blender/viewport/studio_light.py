# SPDX-License-Identifier: GPL-3.0-or-later
"""The light and colour of an object in a Solid viewport, for the preview's shader."""
from __future__ import annotations

import math
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector

_DEFAULT_ROUGHNESS = 0.4  # of objects without a material, as in Blender


@dataclass
class Lights:
    """Four lights in view space, in the order of shaders/preview/preview_block.glsl."""

    direction: np.ndarray  # (4, 4) float32
    diffuse: np.ndarray  # (4, 4), w: wrap
    specular: np.ndarray  # (4, 4)
    ambient: np.ndarray  # (4,)
    has_specular: bool


@dataclass
class Finish:
    """The surface of one material slot."""

    color: tuple[float, ...]  # RGB, scene linear
    metallic: float = 0.0
    roughness: float = math.sqrt(_DEFAULT_ROUGHNESS)
    image: bpy.types.Image | None = None

    def __post_init__(self) -> None:
        # Blender's own engine quantises both, which is visible.
        self.metallic, self.roughness = math.floor(self.metallic * 7.0) / 7.0, math.floor(self.roughness * 31.0) / 31.0


def lights(shading: bpy.types.View3DShading, view: Matrix) -> Lights:
    """The lights of a viewport with this view matrix. A MatCap has no lights; it gets those of the preferences."""
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
        upright = Matrix.Rotation(0.5 * math.pi, 3, "X")  # maps the view's up axis y to the world's z axis
        turn = view.to_3x3() @ Matrix.Rotation(-shading.studiolight_rotate_z, 3, "Z") @ upright
    for i, light in enumerate(studio.solid_lights):
        if light.use:
            found.direction[i, :3] = turn @ Vector(light.direction)
            found.diffuse[i] = (*light.diffuse_color, light.smooth)
            found.specular[i, :3] = light.specular_color
    found.ambient[:3] = studio.light_ambient
    return found


def finish(obj: bpy.types.Object, slot: int, shading: bpy.types.View3DShading) -> Finish:
    """The surface of a material slot, according to the viewport's colour setting. Attribute and random colours use the
    material's."""
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
    """The image for Texture colour: of the active image node, or of the first one. None if there is no usable one."""
    if material.node_tree is None:
        return None
    nodes = [node for node in material.node_tree.nodes if node.type == "TEX_IMAGE" and node.image is not None
             and node.image.source != "TILED" and min(node.image.size) > 0]
    active = material.node_tree.nodes.active
    chosen = active if active in nodes else next(iter(nodes), None)
    return chosen.image if chosen is not None else None
