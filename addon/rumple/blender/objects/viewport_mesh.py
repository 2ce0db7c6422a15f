# SPDX-License-Identifier: GPL-3.0-or-later
"""A separate mesh for viewports, with fewer subdivisions than in renders, like the two levels of Subdivision.

The same folds are solved for both. The mesh is in another hidden output object. A flag (nodes/output_flags.py) controls
whether viewports show it. They show the mesh of renders while a bake reads it, and if something depends on the points
of that mesh.
"""
from __future__ import annotations

from contextlib import contextmanager
from typing import Iterator

import bpy

from ...core.frame import engine
from ...core.mesh.shown_mesh import ShownMesh
from .. import compat
from ..nodes.output_flags import Flag, change_flag, is_set
from . import modifier

# Modifiers behind the wrinkles that store nothing of their input: they work with any number of points.
_KEEP_NOTHING = frozenset((
    "ARRAY", "BEVEL", "CAST", "DECIMATE", "DISPLACE", "EDGE_SPLIT", "LAPLACIANSMOOTH", "MASK", "MIRROR", "NODES",
    "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "WARP", "WEIGHTED_NORMAL", "WELD",
    "WIREFRAME"))
# Modifiers of other objects that are bound to the points of their target.
_BOUND_TO_TARGET = frozenset(("MESH_DEFORM", "PARTICLE_INSTANCE", "SURFACE_DEFORM"))

# Nodes that store a mesh, from 3.6 on.
_KEEPING = tuple(name for name in ("GeometryNodeSimulationOutput", "GeometryNodeBake") if hasattr(bpy.types, name))

_pauses = 0


@contextmanager
def paused() -> Iterator[None]:
    """Inside this context a viewport's depsgraph has the mesh of renders, for bakes and Apply."""
    global _pauses
    _pauses += 1
    try:
        yield
    finally:
        _pauses -= 1


def is_paused() -> bool:
    return _pauses > 0


def may_differ(pairs: list[tuple[bpy.types.Object, bpy.types.NodesModifier]]) -> set[bpy.types.Object]:
    """The wrinkled objects that viewports may show with other points than renders.

    Cost: about a microsecond for each modifier of the file and each node of its geometry node groups.
    """
    mine = [(obj, nodes_mod) for obj, nodes_mod in pairs if modifier.viewport_output(nodes_mod) is not None]
    if not mine or is_paused() or nodes_keep_meshes():
        return set()
    return _with_free_points(mine)


def may_have_other_points(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether nothing stores the points that viewports show of an object, or is bound to them. Cost: may_differ()'s."""
    return not nodes_keep_meshes() and bool(_with_free_points([(obj, nodes_mod)]))


def _with_free_points(pairs: list[tuple[bpy.types.Object, bpy.types.NodesModifier]]) -> set[bpy.types.Object]:
    """The objects to whose shown points nothing is bound, and whose own modifiers store none of them."""
    bound = targets()
    return {obj for obj, nodes_mod in pairs
            if obj not in bound and keeps_nothing_behind(obj, nodes_mod) and not _is_read_behind(obj, nodes_mod)}


def _is_read_behind(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether nodes behind the wrinkles refer to the mesh of renders, as Wrinkle Maps do."""
    output, modifiers = modifier.output_object(nodes_mod), list(obj.modifiers)
    behind = [m for m in modifiers[modifiers.index(nodes_mod) + 1:] if m.type == "NODES" and m.node_group is not None]
    return any(compat.modifier_input(m, identifier) == output
               for m in behind for identifier in compat.group_sockets(m.node_group, "INPUT").values())


def solved_for(nodes_mod: bpy.types.NodesModifier, evaluator: engine.Wrinkles) -> list[ShownMesh]:
    """The meshes that modifier.outputs() must have: the one of renders, and the one of viewports if it exists."""
    in_viewport = evaluator.in_viewport if modifier.can_show_in_viewport(nodes_mod) else None
    return [evaluator] if in_viewport is None else [evaluator, in_viewport]


def show_in_viewports(nodes_mod: bpy.types.NodesModifier, wanted: bool) -> None:
    """Let viewports show their own mesh, or not. Allowed wherever first_pass.py may set its flag."""
    mesh = modifier.viewport_output(nodes_mod)
    if mesh is not None:
        change_flag(mesh, Flag.RENDER_MESH, not wanted)


def shows_own_mesh(nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether viewports show their own mesh."""
    mesh = modifier.viewport_output(nodes_mod)
    return mesh is not None and not is_set(mesh, Flag.RENDER_MESH) and not modifier.is_baked(nodes_mod)


def keeps_nothing_behind(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the object itself has no data that depends on its shown mesh."""
    modifiers = list(obj.modifiers)
    behind = modifiers[modifiers.index(nodes_mod) + 1:]
    return obj.rigid_body is None and all(m.type in _KEEP_NOTHING for m in behind)


def targets() -> set[bpy.types.Object | None]:
    """The objects that modifiers of other objects are bound to, and that other garments follow."""
    bound = {getattr(m, "target", None) or getattr(m, "object", None)
             for obj in bpy.data.objects for m in obj.modifiers if m.type in _BOUND_TO_TARGET}
    wrinkled = [obj for obj, _nodes_mod in modifier.wrinkled_objects()]
    return bound | {modifier.depends_on(obj, wrinkled) for obj in wrinkled}


def nodes_keep_meshes() -> bool:
    """Whether any nodes store a mesh."""
    return bool(_KEEPING) and any(node.bl_idname in _KEEPING for group in bpy.data.node_groups
                                  if group.users and group.bl_idname == "GeometryNodeTree" for node in group.nodes)
