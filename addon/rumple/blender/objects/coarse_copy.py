# SPDX-License-Identifier: GPL-3.0-or-later
"""Posed positions of the coarse mesh, whatever the modifiers behind the wrinkles do.

The node tree stores them on the mesh that it shows, in the first points. A modifier behind may remove these (Mask,
Decimate), merge them (Weld), or make another mesh altogether (Remesh). Then the tree also hands on an instance of the
bare points: mesh modifiers leave instances alone, and no engine draws points without faces. A flag tells the tree
(nodes/output_flags.py).
"""
from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from ..nodes import wrinkle_tree
from ..nodes.output_flags import Flag, change_flag, is_set
from . import mesh_reader, modifier

# Modifiers behind the wrinkles that leave the first points, and their order, as they are.
_KEEP_POINTS = modifier.NEUTRAL | {"EDGE_SPLIT", "MULTIRES", "SUBSURF", "TRIANGULATE"}


def hand_on_if_needed(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Let the tree hand on the points where they are needed. True when that changed. Allowed where first_pass.py sets
    its flag."""
    output = modifier.output_object(nodes_mod)
    wanted = any(m.type != "NODES" for m in removers(obj, nodes_mod))
    return output is not None and change_flag(output, Flag.POINTS_BESIDE, wanted)


def removers(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> list[bpy.types.Modifier]:
    """What is on behind the wrinkles and may remove points. Node groups may do so to instances too: they are named, and
    nothing is handed on for their sake."""
    modifiers = list(obj.modifiers)
    return [m for m in modifiers[modifiers.index(nodes_mod) + 1:]
            if m.type not in _KEEP_POINTS and (m.show_viewport or m.show_render)]


def _is_beside(nodes_mod: bpy.types.NodesModifier) -> bool:
    output = modifier.output_object(nodes_mod)
    return output is not None and is_set(output, Flag.POINTS_BESIDE)


def posed_positions(obj: bpy.types.Object, count: int, depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Incoming coarse positions of an object in this depsgraph's frame, (count, 3); None where the tree did not run.

    Raises mesh_reader.Reordered where a modifier behind removed points and no instance has them.
    """
    nodes_mod = modifier.find(obj)
    if nodes_mod is not None and _is_beside(nodes_mod):
        found = _from_instance(obj, count, depsgraph)
        if found is not None:
            return found
    return mesh_reader.posed_positions(obj.evaluated_get(depsgraph), count)


def _from_instance(obj: bpy.types.Object, count: int, depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Cost: a microsecond for each instance of the scene."""
    for instance in depsgraph.object_instances:
        if not instance.is_instance or instance.object.original != obj:
            continue
        mesh = instance.object.data
        if not isinstance(mesh, bpy.types.Mesh) or len(mesh.vertices) != count or len(mesh.polygons):
            continue
        stored = mesh.attributes.get(wrinkle_tree.BASE_POSITION)
        if stored is not None:
            return np.array(compat.read_attribute(stored), np.float32)
    return None
