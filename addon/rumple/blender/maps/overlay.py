# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws influences as colours over the mesh in the viewport: a hue for each pose, with its mask as strength."""
from __future__ import annotations

import colorsys

import bpy
import numpy as np

from ...core.systems.poses import PACKED
from .. import compat
from ..nodes import maps_shader
from ..viewport.draw_handler import DrawHandler
from . import modifier as maps_modifier

STRONGEST = 0.85  # alpha where the masks sum to 1: the shading stays visible
NEARER = 1e-4  # share of the depth by which colours are drawn in front of the mesh


def palette(count: int) -> np.ndarray:
    """(count, 3) hues, the first red, as far apart as they can be."""
    return np.array([colorsys.hsv_to_rgb(number / count, 0.9, 1.0) for number in range(count)], np.float32)


def colours(masks: np.ndarray) -> np.ndarray:
    """(n, 4) from the masks of o poses, (n, o): the sum of their hues. Alpha is premultiplied, which avoids dark
    rims."""
    masks = STRONGEST * masks / np.maximum(masks.sum(1, keepdims=True), 1.0)
    return np.concatenate([masks @ palette(masks.shape[1]), masks.sum(1, keepdims=True)], 1).astype(np.float32)


def _masks(mesh: bpy.types.Mesh, count: int) -> np.ndarray | None:
    packs = [mesh.attributes.get(maps_shader.MASKS.format(pack)) for pack in range((count + PACKED - 1) // PACKED)]
    if not packs or None in packs:
        return None
    return np.concatenate([compat.read_attribute(pack) for pack in packs], 1)[:, :count]


def _draw() -> None:
    """Called by every 3D view."""
    mapped = [obj for obj, _ in maps_modifier.mapped_objects()]
    objects = [obj for obj in mapped if obj.rumple_maps.show_influences and obj.visible_get()]
    if not objects:
        return
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for obj in objects:
        evaluated = obj.evaluated_get(depsgraph)
        masks = _masks(evaluated.data, len(obj.rumple_maps.poses))
        if masks is not None:
            _draw_mesh(evaluated, colours(masks))


def _draw_mesh(evaluated: bpy.types.Object, colour: np.ndarray) -> None:
    import gpu  # not in background mode, where 3.4 has none
    from gpu_extras.batch import batch_for_shader
    from mathutils import Vector
    mesh = evaluated.data
    shader = gpu.shader.from_builtin(compat.SMOOTH_COLOR_SHADER)
    batch = batch_for_shader(shader, "TRIS", dict(pos=compat.positions(mesh), color=colour),
                             indices=compat.triangle_vertices(mesh))
    gpu.state.blend_set("ALPHA_PREMULT")
    gpu.state.depth_test_set("LESS_EQUAL")
    with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
        projection = gpu.matrix.get_projection_matrix()
        projection[2] = projection[2] - NEARER * Vector(projection[3])
        gpu.matrix.load_projection_matrix(projection)
        gpu.matrix.multiply_matrix(evaluated.matrix_world)
        batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


handler = DrawHandler("the overlay of the influences", _draw)
register, unregister = handler.add, handler.remove
