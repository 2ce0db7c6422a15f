# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys of a clip, for exporters and other programs."""
from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from ..frame import rebuild
from ..objects import modifier


def shape_key_object(context: bpy.types.Context, obj: bpy.types.Object, shapes: list[np.ndarray],
                     start: int) -> bpy.types.Object:
    """A copy of obj whose mesh is the fine one, moved by absolute shape keys; later modifiers stay."""
    mesh = modifier.output_object(modifier.find(obj)).data.copy()
    copy = obj.copy()
    mesh.name = copy.name = f"{obj.name} shape keys"
    last = list(copy.modifiers).index(modifier.find(copy))
    for name in [m.name for m in copy.modifiers][:last + 1]:
        copy.modifiers.remove(copy.modifiers[name])
    copy.data = mesh
    copy.rumple.method = "NONE"
    rebuild.drop_internal_attributes(copy)
    for collection in obj.users_collection or (context.scene.collection,):
        collection.objects.link(copy)
    copy.shape_key_add(name="Rest")
    keys = mesh.shape_keys
    keys.use_relative = False
    for number, shape in enumerate(shapes):
        key = copy.shape_key_add(name=f"Frame {start + number}", from_mix=False)
        key.data.foreach_set("co", np.ascontiguousarray(shape, np.float32).ravel())
    _key_evaluation_time(keys, start)
    return copy


def _key_evaluation_time(keys: bpy.types.Key, start: int) -> None:
    """One key of evaluation time for every frame: each shows its own shape exactly."""
    for number, block in enumerate(keys.key_blocks[1:]):
        block.interpolation = "KEY_LINEAR"
        keys.eval_time = block.frame
        keys.keyframe_insert("eval_time", frame=start + number)
    for curve in compat.action_curves(keys.animation_data.action):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
