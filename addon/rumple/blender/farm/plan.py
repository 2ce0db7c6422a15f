# SPDX-License-Identifier: GPL-3.0-or-later
"""Which garments of a file can be baked, in which order, and how much disk space they need."""
from __future__ import annotations

import graphlib
import json

import bpy

from ...core.files import clip_file
from .. import compat
from ..objects import bodies, modifier, units

_MANIFEST_BYTES = 600  # approximately, per sample


def garments(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The editable wrinkled objects of a scene, each after the objects that it depends on."""
    found = [obj for obj, _ in bodies.in_order(list(modifier.wrinkled_objects()))
             if compat.holds(scene.objects, obj) and compat.is_editable(obj)]
    graph = {obj.name: needs(obj) for obj in found}
    try:
        order = list(graphlib.TopologicalSorter(graph).static_order())
    except graphlib.CycleError:
        return found  # each object reports its own error
    return sorted(found, key=lambda obj: order.index(obj.name))


def needs(obj: bpy.types.Object) -> list[str]:
    """The wrinkled objects that must be baked before: those under it, and the one that it follows. Linked objects are
    baked in their own files."""
    others = [] if bodies.refusal(obj) else bodies.of(obj)
    follows = modifier.depends_on_wrinkled(obj)
    if follows is not None and follows not in others:
        others.append(follows)
    return [other.name for other in others if modifier.find(other) is not None and compat.is_editable(other)]


def as_text(scene: bpy.types.Scene) -> str:
    """Names of garments and of the objects that each needs, in order, for queues."""
    return json.dumps([dict(name=obj.name, needs=needs(obj)) for obj in garments(scene)])


def bytes_of(obj: bpy.types.Object) -> int:
    """The approximate size of its clip, from the shown mesh in the file; 0 if there is none yet."""
    nodes_mod = modifier.find(obj)
    output = modifier.output_object(nodes_mod)
    if output is None or output.type != "MESH":
        return 0
    points = clip_file.point_count(len(output.data.vertices), len(output.data.loops),
                                   modifier.system(nodes_mod).wrinkles.ATTRIBUTES)
    start, end = units.bake_range(obj, bpy.context.scene)
    samples = max(end - start, 0) * obj.rumple.bake_samples + 1
    return clip_file.HEADER_BYTES + samples * (12 * points + _MANIFEST_BYTES)
