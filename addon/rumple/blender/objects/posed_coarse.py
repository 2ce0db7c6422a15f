# SPDX-License-Identifier: GPL-3.0-or-later
"""Posed positions of the coarse mesh, whatever the modifiers behind the wrinkles do.

The node tree stores them on the mesh that it shows, in the first points. A modifier behind may remove these (Mask,
Decimate, nodes), merge them (Weld), or make another mesh altogether (Remesh). Then the modifiers in front are evaluated
once more, without those behind: what the evaluated copy of the object makes anew when it is asked for a mesh with all
of its layers. Cost: that of the modifiers in front.
"""
from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

import bpy
import numpy as np

from ...core.engine import UserError
from .. import compat
from . import mesh_reader, modifier

# Modifiers behind the wrinkles that leave the first points, and their order, as they are.
_KEEP_POINTS = modifier.NEUTRAL | {"EDGE_SPLIT", "MULTIRES", "SUBSURF", "TRIANGULATE"}
_SHOWN = ("show_viewport", "show_render")
# Modifiers that ask the depsgraph for the frame; nodes may.
_TIMED = frozenset(("BUILD", "CLOTH", "EXPLODE", "FLUID", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "NODES", "OCEAN",
                    "PARTICLE_SYSTEM", "SOFT_BODY", "WAVE"))


def positions(obj: bpy.types.Object, count: int, depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Incoming coarse positions of an object in this depsgraph's frame, (count, 3); None where the tree did not run.
    Raises UserError."""
    nodes_mod, evaluated = modifier.find(obj), obj.evaluated_get(depsgraph)
    which = "show_render" if depsgraph.mode == "RENDER" else "show_viewport"
    removers = set() if nodes_mod is None else _removers(obj, nodes_mod, which)
    found = None
    if removers <= {"NODES"}:  # most node groups keep the points, and their numbers
        found = mesh_reader.posed_positions(evaluated, count)
    if found is None and removers and getattr(nodes_mod, which):
        with _without(evaluated, list(obj.modifiers).index(nodes_mod), *_mode_of(obj, which, depsgraph)) as mesh:
            found = compat.positions(mesh) if len(mesh.vertices) == count else None
    return found


def _removers(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, which: str) -> set[str]:
    """Types of what is on behind the wrinkles, by that of its switches, and may remove points."""
    modifiers = list(obj.modifiers)
    return {m.type for m in modifiers[modifiers.index(nodes_mod) + 1:]
            if m.type not in _KEEP_POINTS and getattr(m, which)}


def _mode_of(obj: bpy.types.Object, which: str, depsgraph: bpy.types.Depsgraph) -> tuple[str, bpy.types.Depsgraph]:
    """By which switches the modifiers in front are on, and the depsgraph that says which are looked at: Blender locks
    those of renders on what is linked. So that is evaluated as in viewports, in the pose of the render. Raises
    UserError where its points depend on the frame: that would be the viewport's."""
    if which == "show_viewport" or obj.library is None:
        return which, depsgraph
    viewport = depsgraph.view_layer.depsgraph
    unseen = [m.name for m in modifier.in_front(obj) if getattr(m, which) and (m.type in _TIMED or viewport is None)]
    if unseen:
        raise UserError(f"{obj.name}: it is linked, and a modifier below the wrinkles removes points, so renders do "
                        f"not see what \"{unseen[0]}\" does: make a library override of it")
    return which, viewport or depsgraph


@contextmanager
def _without(evaluated: bpy.types.Object, index: int, which: str,
             depsgraph: bpy.types.Depsgraph) -> Iterator[bpy.types.Mesh]:
    """Its mesh as it arrives at that modifier. Nothing is tagged: only the evaluated copy is told, by foreach_set,
    which calls no update. which: the switches that count."""
    former = {}
    for name in _SHOWN:
        former[name] = np.empty(len(evaluated.modifiers), bool)
        evaluated.modifiers.foreach_get(name, former[name])
    try:
        for name in _SHOWN:
            evaluated.modifiers.foreach_set(name, former[which] & (np.arange(len(former[which])) < index))
        yield evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
    finally:
        for name, values in former.items():
            evaluated.modifiers.foreach_set(name, values)
        evaluated.to_mesh_clear()
