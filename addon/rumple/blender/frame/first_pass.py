# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender evaluates a garment twice in a frame: before the solve, and again because the solve has written it.

The first result is never visible. The handler only reads the posed coarse mesh from it. So in the first pass the node
tree outputs the coarse mesh, which costs a tenth of the fine one. A flag tells the node tree (nodes/output_flags.py).

While a clip is baked (baking.py), the second result is not visible either, and both passes output the coarse mesh.

Otherwise the flag is set only between frame_change_pre and frame_change_post. At all other times, in files, and in
evaluations without these handlers, the flag is not set and the fine mesh is shown.
"""
from __future__ import annotations

import time

import bpy

from .. import compat, scheduler
from ..nodes.output_flags import Flag, is_set, set_flag
from ..objects import modifier, runtimes, units, viewport_mesh
from . import baking

_some_are_coarse = False
_began: float | None = None  # start of the frame that Blender evaluates now, by time.perf_counter()


def must_be_solved(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the wrinkles of an object are visible, or read by a bake."""
    return baking.reads(obj) or shows_fine_mesh(nodes_mod)


def shows_fine_mesh(nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the second pass outputs the fine mesh."""
    output = modifier.output_object(nodes_mod)
    return not baking.is_running() or output is None or not is_set(output, Flag.COARSE_ONLY)


def hand_on_coarse(scene: bpy.types.Scene) -> None:
    """Called before a frame: set the flag of the garments that moved in the last frame. Blender does not even evaluate
    the others.

    Cost: about a microsecond for each modifier of the file and each node of its geometry node groups.
    """
    global _some_are_coarse, _began
    _began = time.perf_counter()
    if not scheduler.may_prepare_frame():
        return
    with scheduler.LOCK:
        moving = [(obj, nodes_mod) for obj, nodes_mod in modifier.wrinkled_objects()
                  if _moved(obj, nodes_mod, scene) or (baking.is_running() and not modifier.is_baked(nodes_mod))]
        if not moving or viewport_mesh.nodes_keep_meshes():
            return
        bound = viewport_mesh.targets()
        for obj, nodes_mod in moving:
            output = modifier.output_object(nodes_mod)
            if output is not None and obj not in bound and viewport_mesh.keeps_nothing_behind(obj, nodes_mod):
                _some_are_coarse |= set_flag(output, Flag.COARSE_ONLY, True)


def seconds_evaluated() -> float | None:
    """The time that Blender has needed for the first pass of the frame; None between frames."""
    return None if _began is None else time.perf_counter() - _began


def show_fine(scene: bpy.types.Scene) -> None:
    """Called after the first pass, also after errors: clear the flags."""
    global _some_are_coarse, _began
    _began = None
    if baking.is_running():
        return
    if scheduler.rendering() and not bpy.app.background:
        return  # nothing was prepared, and the rendering thread may hold the lock
    with scheduler.LOCK:
        left = False
        for obj, nodes_mod in modifier.wrinkled_objects():
            runtime, output = runtimes.known(obj), modifier.output_object(nodes_mod)
            if runtime is not None and runtime.written_at == (compat.session_key(scene), units.frame_of(scene)):
                runtime.moved_in = compat.session_key(scene)
            elif runtime is not None and runtime.moved_in == compat.session_key(scene):
                runtime.moved_in = 0
            if _some_are_coarse and output is not None and is_set(output, Flag.COARSE_ONLY):
                left |= not set_flag(output, Flag.COARSE_ONLY, False)
        _some_are_coarse = left


def _moved(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, scene: bpy.types.Scene) -> bool:
    runtime = runtimes.known(obj)
    return (runtime is not None and runtime.moved_in == compat.session_key(scene) and not runtime.stale
            and not modifier.is_baked(nodes_mod) and compat.is_editable(obj))
