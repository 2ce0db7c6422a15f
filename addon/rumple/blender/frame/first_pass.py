# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender evaluates a garment twice in a frame: before it is solved, and once more because the solve wrote it.

Nobody sees the first result; the handler only reads the posed coarse mesh from it. So the first pass hands on the
coarse mesh, which costs a tenth of the fine one. What tells the node tree is the place of the hidden output object,
which counts for nothing else: moving it copies no mesh and looks like no edit.

Only between frame_change_pre and frame_change_post. At all other times, in files, and for whatever evaluates without
these handlers, the output object is in its place and the fine mesh is shown.
"""
from __future__ import annotations

import bpy

from .. import compat, scheduler
from ..objects import coarse_copy, modifier, runtimes

AWAY = 1.0  # x of the output object while the coarse mesh is handed on; wrinkle_tree.py compares with a half

# Modifiers behind the wrinkles that keep nothing of a mesh they saw: another number of points does not disturb them.
_KEEP_NOTHING = frozenset((
    "ARRAY", "BEVEL", "CAST", "DECIMATE", "DISPLACE", "EDGE_SPLIT", "MASK", "MIRROR", "NODES", "SIMPLE_DEFORM",
    "SMOOTH", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "WARP", "WEIGHTED_NORMAL", "WELD", "WIREFRAME"))
# Modifiers of other objects that count on the points of their target.
_BOUND_TO_TARGET = frozenset(("MESH_DEFORM", "PARTICLE_INSTANCE", "SURFACE_DEFORM"))

_some_away = False


def hand_on_coarse(scene: bpy.types.Scene) -> None:
    """Before a frame: of the garments that moved in the last one. What stands still Blender does not even evaluate.
    And all say whether their points have to be handed on beside the mesh.

    Cost: about a microsecond for each modifier of the file and each node of its geometry node groups.
    """
    global _some_away
    if not scheduler.may_prepare_frame():
        return
    with scheduler.LOCK:
        for obj, nodes_mod in modifier.wrinkled_objects():
            coarse_copy.settle(obj, nodes_mod)
        moving = [(obj, nodes_mod) for obj, nodes_mod in modifier.wrinkled_objects() if _moved(obj, nodes_mod, scene)]
        if not moving or _nodes_keep_meshes():
            return
        bound = _targets()
        for obj, nodes_mod in moving:
            output = modifier.output_object(nodes_mod)
            if output is not None and obj not in bound and _keeps_nothing_behind(obj, nodes_mod):
                _some_away |= modifier.move_hidden(output, "x", AWAY)


def show_fine(scene: bpy.types.Scene) -> None:
    """After the first pass, whatever happened in it."""
    global _some_away
    if scheduler.rendering() and not bpy.app.background:
        return  # nothing was prepared, and the thread that renders may hold the lock
    with scheduler.LOCK:
        away = False
        for obj, nodes_mod in modifier.wrinkled_objects():
            runtime, output = runtimes.known(obj), modifier.output_object(nodes_mod)
            if runtime is not None and runtime.written_at == (compat.session_key(scene), scene.frame_current_final):
                runtime.moved_in = compat.session_key(scene)
            elif runtime is not None and runtime.moved_in == compat.session_key(scene):
                runtime.moved_in = 0
            if _some_away and output is not None and output.location.x == AWAY:
                away |= not modifier.move_hidden(output, "x", 0.0)
        _some_away = away


def _moved(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, scene: bpy.types.Scene) -> bool:
    runtime = runtimes.known(obj)
    return (runtime is not None and runtime.moved_in == compat.session_key(scene) and not runtime.stale
            and not modifier.is_baked(nodes_mod) and compat.is_editable(obj))


def _keeps_nothing_behind(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether nothing of the object itself keeps the mesh that it was shown last."""
    modifiers = list(obj.modifiers)
    behind = modifiers[modifiers.index(nodes_mod) + 1:]
    return obj.rigid_body is None and all(m.type in _KEEP_NOTHING for m in behind)


def _targets() -> set[bpy.types.Object]:
    """What modifiers of other objects are bound to, and what other garments follow as the first pass has it."""
    bound = {getattr(m, "target", None) or getattr(m, "object", None)
             for obj in bpy.data.objects for m in obj.modifiers if m.type in _BOUND_TO_TARGET}
    wrinkled = [obj for obj, _nodes_mod in modifier.wrinkled_objects()]
    return bound | {modifier.depends_on(obj, wrinkled) for obj in wrinkled}


def _nodes_keep_meshes() -> bool:
    """Whether any nodes (Blender 3.6 and later) keep what the first pass would show them."""
    return any(node.bl_idname in ("GeometryNodeSimulationOutput", "GeometryNodeBake")
               for group in bpy.data.node_groups if group.users and group.bl_idname == "GeometryNodeTree"
               for node in group.nodes)
