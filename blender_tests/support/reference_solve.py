# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame has to look like, solved apart from Blender's handlers, modifier and output object.

A twin of the coarse mesh without wrinkles says how it is posed; core/frame/engine.py, with a memory of its own,
solves that; an ordinary mesh object shows it. Whatever the add-on does late, twice or not at all shows as a
difference between pictures of the two.
"""
from __future__ import annotations

from typing import Sequence

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import mesh_reader, modifier, properties
from rumple.core.frame import engine
from rumple.core.systems import wrinkle_mesh
from support import sleeve, small_renders
from support.frames import solve_frame

STARK = 0.02  # a pixel is another one when a channel differs by more; 0..1


def twin_of(obj: bpy.types.Object) -> bpy.types.Object:
    """The same object as it was before Add > Wrinkle Mesh, seen by no camera."""
    twin = obj.copy()
    twin.name = "Twin"
    bpy.context.scene.collection.objects.link(twin)
    stack = list(twin.modifiers)
    for later in stack[stack.index(modifier.find(twin)):]:
        twin.modifiers.remove(later)
    twin.rumple.method = "NONE"
    twin.hide_render = True
    return twin


def pictures(obj: bpy.types.Object, frames: Sequence[float]) -> tuple[engine.Wrinkles, list[engine.FrameResult]]:
    """Solve these frames, and no others, one after the other."""
    scene, twin = bpy.context.scene, twin_of(obj)
    settings = properties.settings_of(obj, scene)
    base = mesh_reader.base_mesh(twin, settings.rest_shape, "")
    fine = wrinkle_mesh.WrinkleMesh.build(base, settings, unit_scale=scene.unit_settings.scale_length)
    result = []
    for frame in frames:
        whole = int(np.floor(frame))
        sleeve.at(whole, frame - whole)
        posed = np.ascontiguousarray(sleeve.shown(twin))
        result.append(solve_frame(fine, float(frame), posed, settings, {}, start=scene.frame_start))
    bpy.data.objects.remove(twin)
    return fine, result


def plain_object(obj: bpy.types.Object, fine: engine.Wrinkles, positions: np.ndarray) -> bpy.types.Object:
    """An ordinary object of the fine mesh with these positions, and the modifiers that stand behind the wrinkles."""
    mesh = bpy.data.meshes.new("Plain")
    compat.fill_polygons(mesh, positions, fine.polygon_start, fine.corner_vertex)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    mesh.materials.append(obj.data.materials[0])
    mesh.update()
    plain = bpy.data.objects.new("Plain", mesh)
    plain.parent = obj.parent
    bpy.context.scene.collection.objects.link(plain)
    stack = list(obj.modifiers)
    for later in stack[stack.index(modifier.find(obj)) + 1:]:
        assert later.type == "SUBSURF"
        copy = plain.modifiers.new(later.name, later.type)
        copy.levels, copy.render_levels = later.levels, later.render_levels
    return plain


def picture_of(obj: bpy.types.Object, fine: engine.Wrinkles, positions: np.ndarray, frame: float) -> np.ndarray:
    """A render of the plain object in place of the wrinkled one, (SIZE, SIZE, 4). Its parent is where it is then."""
    plain = plain_object(obj, fine, positions)
    hidden, obj.hide_render = obj.hide_render, True
    result = small_renders.still(frame)
    obj.hide_render = hidden
    bpy.data.meshes.remove(plain.data)
    return result


def expected(obj: bpy.types.Object, frames: Sequence[float]) -> list[np.ndarray]:
    """Renders of these frames, solved one after the other and shown by plain objects."""
    fine, solved = pictures(obj, frames)
    return [picture_of(obj, fine, picture.positions, frame) for frame, picture in zip(frames, solved)]


def unfolded(obj: bpy.types.Object, frame: float) -> np.ndarray:
    """A render of the frame without its folds."""
    fine, (picture,) = pictures(obj, [frame])
    return picture_of(obj, fine, picture.positions - picture.offset, frame)


def unlike(one: np.ndarray, other: np.ndarray) -> int:
    """Pixels in which two renders differ."""
    return int((np.abs(one - other).max(axis=2) > STARK).sum())


def uncovered(one: np.ndarray, other: np.ndarray) -> float:
    """Pixels, in parts, that only one of two renders covers."""
    return float(np.abs(one[..., 3] - other[..., 3]).sum())
