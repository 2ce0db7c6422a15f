# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene of an object, its length unit in metres, and the first frame of the clip."""
from __future__ import annotations

from typing import Iterator

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...core.base import transforms
from .. import compat

SCALES = [(name, axis) for name in ("scale", "delta_scale") for axis in range(3)]
LEAST = 1e-3  # a smaller scale is used to hide an object or a character
EVEN = 1.02  # largest ratio of scales along two axes whose difference is hardly visible


def scene_of(obj: bpy.types.Object) -> bpy.types.Scene:
    """The scene whose units and frames are used for an object."""
    return next(iter(obj.users_scene), None) or bpy.context.scene


def first_frame(obj: bpy.types.Object, scene: bpy.types.Scene) -> int:
    """The frame of the clip that depends on no frame before it. Not only the scene's Start: artists move it to render a
    part again, and a bake may begin before it."""
    about = obj.rumple
    if not about.bake_scene_range:
        return min(scene.frame_start, about.bake_start)
    first, last = about.bake_known_range
    return scene.frame_start if scene.frame_start > last else min(scene.frame_start, first)


def bake_range(obj: bpy.types.Object, scene: bpy.types.Scene) -> tuple[int, int]:
    """The first and the last frame of a bake."""
    about = obj.rumple
    return (scene.frame_start, scene.frame_end) if about.bake_scene_range else (about.bake_start, about.bake_end)


def frame_of(scene: bpy.types.Scene) -> float:
    """The frame number on the timeline, which defines the order of frames. With Time Stretching, frame_current_final
    would be the shown time of the animation: 0.5, 1.0, 1.5 in the frames 1 to 3."""
    return float(np.float32(scene.frame_current + scene.frame_subframe))


def frame_rate(scene: bpy.types.Scene) -> float:
    """Frames of the timeline per second of the animation."""
    render = scene.render
    return render.fps / render.fps_base * (render.frame_map_new / render.frame_map_old)


def metres_per_unit(obj: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """Mean absolute scale of an object times the scene's unit scale. Of a keyed scale, the value in the clip's first
    frame is used, or the first one that shows it, so that the result does not depend on the current frame."""
    mean = sum(abs(s) for s in _matrix_at(obj, first_frame(obj, scene)).to_scale()) / 3.0
    if any(_scale_curves(one) for one in with_parents(obj)):
        mean = float(f"{mean:.5g}")  # rounding errors of an evaluated scale differ between frames
    return mean * scene.unit_settings.scale_length


def unevenly_scaled(obj: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The object whose scale makes lengths along the axes of an object differ in the clip's first frame: the most
    distant ancestor with an uneven scale, or the object itself. None if the scale is even, or only the armature's space
    has the same uneven scale."""
    first, rig = first_frame(obj, scene), obj.find_armature()
    matrix = _matrix_at(obj, first)
    bent = matrix if rig is None else _matrix_at(rig, first).inverted_safe() @ matrix
    if not (_is_uneven(matrix) and _is_uneven(bent)):
        return None
    in_common = set() if rig is None else set(with_parents(rig))
    uneven = [one for one in with_parents(obj) if one not in in_common and _differ(_own_scale(one, first))]
    return uneven[-1] if uneven else obj


def _is_uneven(matrix: Matrix) -> bool:
    least, most = transforms.stretch_range(np.array(matrix.to_3x3()))
    return most > EVEN * least


def _differ(scale: list[float]) -> bool:
    sizes = [abs(size) for size in scale]
    return max(sizes) > EVEN * min(sizes)


def _matrix_at(obj: bpy.types.Object, frame: int) -> Matrix:
    """The object's world matrix, with the scales that are keyed for a frame.

    It is computed from the parents' own transforms, because matrix_world is not yet valid after loading a file.
    """
    matrix, parent = _basis_at(obj, frame), obj.parent
    inverse = obj.matrix_parent_inverse
    while parent is not None:
        matrix = _basis_at(parent, frame) @ inverse @ matrix
        inverse, parent = parent.matrix_parent_inverse, parent.parent
    return matrix


def most_metres_per_unit(obj: bpy.types.Object, scene: bpy.types.Scene) -> float:
    """Scale along the longest axis: no distance in the object is longer in metres."""
    return max(abs(scale) for scale in obj.matrix_world.to_scale()) * scene.unit_settings.scale_length


def plain_scales(obj: bpy.types.Object, scene: bpy.types.Scene) -> tuple:
    """The current values that metres_per_unit() depends on. They are read in each frame, and hardly ever change."""
    return (scene.unit_settings.scale_length, *((*one.scale, *one.delta_scale, one.matrix_parent_inverse.median_scale)
                                                for one in with_parents(obj)))


def scale_is_known(obj: bpy.types.Object) -> bool:
    """Whether metres_per_unit() is the same in all frames until somebody edits it. It is not with drivers or strips."""
    return not any(_scales_otherwise(one.animation_data) for one in with_parents(obj)
                   if one.animation_data is not None)


def _scales_otherwise(about: bpy.types.AnimData) -> bool:
    return (compat.has_strips(about)
            or any(about.drivers.find(name, index=axis) is not None for name, axis in SCALES))


def with_parents(obj: bpy.types.Object) -> Iterator[bpy.types.Object]:
    """An object, its parent, the parent's parent, ..."""
    one: bpy.types.Object | None = obj
    while one is not None:
        yield one
        one = one.parent


def _scale_curves(obj: bpy.types.Object) -> list[bpy.types.FCurve]:
    about = obj.animation_data
    found = [] if about is None else [compat.find_curve(about, *place) for place in SCALES]
    return [curve for curve in found if curve is not None]


def _basis_at(obj: bpy.types.Object, frame: int) -> Matrix:
    """The object's own transform, with the scale that is keyed for a frame."""
    if not _scale_curves(obj):
        return obj.matrix_basis.copy()
    place, turn, _ = obj.matrix_basis.decompose()
    return Matrix.LocRotScale(place, turn, Vector(_own_scale(obj, frame)))


def _own_scale(obj: bpy.types.Object, frame: int) -> list[float]:
    """The object's own scale per axis, as keyed for a frame. If it is hidden there by a scale of zero, because it pops
    up later, it has the scale of the next key that shows it."""
    curves = _scale_curves(obj)
    later = sorted({key.co.x for curve in curves for key in curve.keyframe_points if key.co.x > frame})
    found = [_scale_as_keyed(obj, curves, time) for time in (frame, *later)]
    return next((scale for scale in found if max(abs(size) for size in scale) >= LEAST), found[0])


def _scale_as_keyed(obj: bpy.types.Object, curves: list[bpy.types.FCurve], time: float) -> list[float]:
    scale = {name: list(getattr(obj, name)) for name in ("scale", "delta_scale")}
    for curve in curves:
        scale[curve.data_path][curve.array_index] = curve.evaluate(time)
    return [own * more for own, more in zip(*scale.values())]
