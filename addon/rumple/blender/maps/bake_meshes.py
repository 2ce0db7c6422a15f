# SPDX-License-Identifier: GPL-3.0-or-later
"""The two meshes of a bake of maps: copies of the object, what they have of it, and how they are baked."""
from __future__ import annotations

from contextlib import ExitStack

import bpy
import numpy as np

from ...core.base.wording import UserError
from .. import compat
from ..frame import rebuild
from ..objects import guide_curves, made_collections, modifier
from . import keys as maps_keys, modifier as maps_modifier

EDGE = 1e-4  # of a tile: how far UVs may stand outside by rounding
MOST_STEPS = 2  # of Smooth Viewport: viewports, whose mesh is baked, show what renders do


# ---------------------------------------------------------------- copies of the object
def plain_copy(obj: bpy.types.Object, scene: bpy.types.Scene, suffix: str, keys: dict[str, float], ended: ExitStack
               ) -> bpy.types.Object:
    """A copy with only the deforming modifiers, in a scene. Its animation and drivers stay active, except for its shape
    keys, which keep the stored values. ended: deletes it."""
    copy = obj.copy()
    ended.callback(delete, copy)
    copy.data = obj.data.copy()
    if keys:
        maps_keys.freeze(copy.data, keys)
    copy.name = f"{obj.name} bake {suffix}"
    nodes_mod, wrinkles = maps_modifier.find(copy), modifier.find(copy)
    behind = {m.name for m in list(copy.modifiers)[modifier.place_behind_deforming(copy):]}
    for name in [m.name for m in copy.modifiers if m in (nodes_mod, wrinkles) or m.name in behind]:
        copy.modifiers.remove(copy.modifiers[name])
    copy.rumple.method, copy.show_only_shape_key = "NONE", False
    copy.rumple.viewport_steps = MOST_STEPS
    scene.collection.objects.link(copy)
    copy.hide_set(False)
    copy.hide_viewport = False
    return copy


def copy_guides(garment: bpy.types.Object, copy: bpy.types.Object, ended: ExitStack) -> None:
    """Give a copy of a garment copies of its fold guides, in no scene. ended: deletes them."""
    for number, guide in enumerate(guide_curves.of(garment)):
        own = guide.copy()
        ended.callback(bpy.data.objects.remove, own)
        own.name, own.parent = f"{copy.name} guide {number:04d}", copy  # their order is that of the names


def remove_wrinkles(obj: bpy.types.Object) -> None:
    """Remove the modifier, and the collection that the first click made, unless another object has it too."""
    if modifier.find(obj) is not None:
        rebuild.remove_all(obj)
    worn_over, obj.rumple.body_collection = obj.rumple.body_collection, None
    if worn_over is not None and worn_over.users == 0 and made_collections.is_ours(worn_over):
        bpy.data.collections.remove(worn_over)


def delete(obj: bpy.types.Object) -> None:
    mesh = obj.data
    bpy.data.objects.remove(obj)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)


# ---------------------------------------------------------------- what is baked
def uv_map(obj: bpy.types.Object) -> str:
    """The UV map in which the maps are shown. Raises UserError."""
    layers, chosen = obj.data.uv_layers, obj.rumple_maps.uv_map
    if not layers:
        raise UserError(f"{obj.name}: it has no UV map to bake to: unwrap it in Edit Mode first")
    if chosen and chosen not in layers:
        raise UserError(f"{obj.name}: it has no UV map \"{chosen}\": give it its name back, or choose another in "
                        "Shading")
    return chosen or next(layer.name for layer in layers if layer.active_render)


def _tile(uv: np.ndarray) -> np.ndarray:
    """(2,) the tile that has all UVs, or else the first one."""
    tile = np.floor(uv.min(0) + EDGE)
    return tile if (uv.max(0) <= tile + 1.0 + EDGE).all() else np.zeros(2, np.float32)


def outside_notes(obj: bpy.types.Object, uv_map: str) -> list[str]:
    """A warning about faces that the baker leaves out: it fills one tile, the first one or that of all faces."""
    uv = compat.uv_values(obj.data.uv_layers[uv_map])
    if not len(uv) or not np.isfinite(uv).all():
        return []  # nothing can be baked, as is said elsewhere
    uv -= _tile(uv)
    outside = (uv < -EDGE).any(1) | (uv > 1.0 + EDGE).any(1)
    count = int(np.logical_or.reduceat(outside, compat.indices(obj.data.polygons, "loop_start")).sum())
    return [f"{obj.name}: {count} of its faces lie outside of the first tile (0 to 1) of the UV map \"{uv_map}\", so "
            "the maps do not have their folds: move them into it in the UV Editor, and bake again"] if count else []


def choose_uv_map(mesh: bpy.types.Mesh, name: str) -> None:
    """Let the baker, which takes the active one, bake to this UV map, and to the tile of all its faces."""
    if name not in mesh.uv_layers:
        return
    layer = mesh.uv_layers[name]
    mesh.uv_layers.active, layer.active_render = layer, True
    uv = compat.uv_values(layer)
    if _tile(uv).any():
        layer.data.foreach_set("uv", (uv - _tile(uv)).ravel())


def show_only(low: bpy.types.Object, image: bpy.types.Image) -> bpy.types.Material:
    """Give all faces one material whose active node is the image. The baker writes to this image."""
    material = bpy.data.materials.new(low.name)
    compat.use_nodes(material)
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    material.node_tree.nodes.active = texture
    low.data.materials.clear()
    low.data.materials.append(material)
    return material
