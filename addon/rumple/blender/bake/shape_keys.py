# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes an object with a shape key for each frame of a clip, for exporters and other programs."""
from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from ..frame import rebuild
from ..objects import modifier

LINEAR = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items["LINEAR"].value


def shape_key_object(context: bpy.types.Context, obj: bpy.types.Object, shapes: list[np.ndarray],
                     start: int) -> bpy.types.Object:
    """A copy of obj with the fine mesh, animated by shape keys. Later modifiers stay. The keys are relative, because
    exporters ignore the animation of absolute keys."""
    mesh = modifier.output_object(modifier.find(obj)).data.copy()
    copy = obj.copy()
    mesh.name = copy.name = f"{obj.name} shape keys"
    last = list(copy.modifiers).index(modifier.find(copy))
    for name in [m.name for m in copy.modifiers][:last + 1]:
        copy.modifiers.remove(copy.modifiers[name])
    modifier.keep_parent_without_deforming(copy)
    copy.data = mesh
    copy.rumple.method = "NONE"
    rebuild.drop_internal_attributes(copy)
    for collection in obj.users_collection or (context.scene.collection,):
        collection.objects.link(copy)
    copy.shape_key_add(name="Rest")
    for number, shape in enumerate(shapes):
        key = copy.shape_key_add(name=f"Frame {start + number}", from_mix=False)
        key.data.foreach_set("co", np.ascontiguousarray(shape, np.float32).ravel())
    _animate(mesh.shape_keys, copy.name, start)
    return copy


def _animate(keys: bpy.types.Key, name: str, start: int) -> None:
    """The value of each key is 1 in its frame and 0 in the frames before and after, with linear interpolation. So
    between frames the two nearest keys are blended. Before the first frame and after the last one, the nearest key is
    held."""
    blocks = keys.key_blocks[1:]
    curves = compat.new_curves(keys, name)
    for number, block in enumerate(blocks):
        near = np.arange(max(number - 1, 0), min(number + 2, len(blocks)), dtype=np.float32)
        curve = curves.new(data_path=block.path_from_id("value"))
        points = curve.keyframe_points
        points.add(len(near))
        points.foreach_set("co", np.stack((start + near, near == number), axis=1).astype(np.float32).ravel())
        points.foreach_set("interpolation", np.full(len(near), LINEAR, np.int32))
        curve.update()
