# SPDX-License-Identifier: GPL-3.0-or-later
"""Posed positions of the coarse mesh, independent of the modifiers behind the wrinkles.

The node tree stores the positions on the first points of the mesh that it shows. A modifier behind may remove these
points (Mask, Decimate, nodes), merge them (Weld), or make a different mesh (Remesh). Then only the modifiers in front
are evaluated again. The evaluated copy of the object does this when it is asked for a mesh with all of its layers.
Cost: as the modifiers in front.
"""
from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

import bpy
import numpy as np

from ...core.base.wording import UserError
from .. import compat
from . import mesh_reader, modifier

# Modifiers behind the wrinkles that keep the first points in their order.
_KEEP_POINTS = modifier.NEUTRAL | {"EDGE_SPLIT", "MULTIRES", "SUBSURF", "TRIANGULATE"}
_SHOWN = ("show_viewport", "show_render")
# Modifiers that read the frame from the depsgraph; nodes may do so.
_TIMED = frozenset(("BUILD", "CLOTH", "EXPLODE", "FLUID", "MESH_CACHE", "MESH_SEQUENCE_CACHE", "NODES", "OCEAN",
                    "PARTICLE_SYSTEM", "SOFT_BODY", "WAVE"))


def positions(obj: bpy.types.Object, count: int, depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Incoming coarse positions of an object in this depsgraph's frame, (count, 3); None if the tree did not run.
    Raises UserError."""
    nodes_mod, evaluated = modifier.find(obj), obj.evaluated_get(depsgraph)
    which = "show_render" if depsgraph.mode == "RENDER" else "show_viewport"
    removers = set() if nodes_mod is None else _removers(obj, nodes_mod, which)
    found = None
    if removers <= {"NODES"}:  # most node groups keep the points and their indices
        found = mesh_reader.posed_positions(evaluated, count)
    if found is None and removers and getattr(nodes_mod, which):
        with _without(evaluated, list(obj.modifiers).index(nodes_mod), *_mode_of(obj, which, depsgraph)) as mesh:
            found = compat.positions(mesh) if len(mesh.vertices) == count else None
    return found


def _removers(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, which: str) -> set[str]:
    """Types of the enabled modifiers behind the wrinkles that may remove points. which: the property that enables
    them."""
    modifiers = list(obj.modifiers)
    return {m.type for m in modifiers[modifiers.index(nodes_mod) + 1:]
            if m.type not in _KEEP_POINTS and getattr(m, which)}


def _mode_of(obj: bpy.types.Object, which: str, depsgraph: bpy.types.Depsgraph) -> tuple[str, bpy.types.Depsgraph]:
    """The property that enables the modifiers in front, and the depsgraph to evaluate them with. Of linked objects
    Blender locks the render property. So these are evaluated as in viewports, in the render's pose. Raises UserError if
    the points depend on the frame, because the frame would be the viewport's."""
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
    """The mesh as it arrives at that modifier. Only the evaluated copy is changed, by foreach_set, which calls no
    update, so nothing is tagged. which: the property that enables modifiers."""
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
