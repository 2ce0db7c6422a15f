# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that counts for an object, its length unit in metres, and the first frame of the clip."""
from __future__ import annotations

import bpy
import numpy as np


def scene_of(obj: bpy.types.Object) -> bpy.types.Scene:
    """The scene whose units and frames count for an object."""
    return next(iter(obj.users_scene), None) or bpy.context.scene


def first_frame(obj: bpy.types.Object, scene: bpy.types.Scene) -> int:
    """The frame of the clip that needs none before it. Not the scene's Start alone: that one is moved to render a part
    again, and a bake may begin before it."""
    return min(scene.frame_start, obj.rumple.bake_start)


def frame_of(scene: bpy.types.Scene) -> float:
    """Its number on the timeline, by which frames follow one another. Under Time Stretching frame_current_final is what
    of the animation is shown there: 0.5, 1.0, 1.5 in the frames 1 to 3."""
    return float(np.float32(scene.frame_current + scene.frame_subframe))


def frame_rate(scene: bpy.types.Scene) -> float:
    """Frames of the timeline for each second of the animation."""
    render = scene.render
    return render.fps / render.fps_base * (render.frame_map_new / render.frame_map_old)


def metres_per_unit(obj: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """Mean absolute scale of an object times the scene's unit scale.

    From the parents' own transforms, not from matrix_world: that one is not there yet after loading a file.
    """
    matrix, parent = obj.matrix_basis.copy(), obj.parent
    inverse = obj.matrix_parent_inverse
    while parent is not None:
        matrix = parent.matrix_basis @ inverse @ matrix
        inverse, parent = parent.matrix_parent_inverse, parent.parent
    scale = matrix.to_scale()
    return sum(abs(s) for s in scale) / 3.0 * scene.unit_settings.scale_length
