# SPDX-License-Identifier: GPL-3.0-or-later
"""The live solve, called between Blender's two evaluation passes, for every depsgraph and every subframe.

The result depends only on the pose and on stored state (core/frame/frame_cache.py), so the number and order of calls
and the depsgraph do not matter. Rules that keep Blender from crashing: never update a depsgraph here; do not touch
viewport depsgraphs while a render runs; write only attributes of the output mesh, and nothing if nothing changed; do
not touch baked objects.
"""
from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ...core.mesh.frame_result import FrameResult
from .. import scheduler
from ..nodes.output_flags import Flag, set_flag
from ..objects import (bodies, changes, clip_range, incoming_mesh, mesh_reader, messages, modifier, output_mesh,
                       posed_coarse, runtimes, units, viewport_mesh, visibility)
from ..objects.runtimes import Runtime
from ..scheduler import LOCK
from . import first_pass, garment_frame
from .garment_reader import GarmentReader


def process(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Solve the objects of this depsgraph. Never raises."""
    if not scheduler.may_process(depsgraph):
        return
    evaluated = first_pass.seconds_evaluated()
    with LOCK:
        objects = [pair for pair in modifier.wrinkled_objects() if first_pass.must_be_solved(*pair)]
        late = {obj for obj, nodes_mod in objects if _is_late(obj, nodes_mod)}
        try:
            if scheduler.allowed_now() and (changes.take_converted() or any(
                    _needs_structure(obj, nodes_mod) for obj, nodes_mod in objects)):
                _rebuild_here(objects, depsgraph)
            garments = [pair for pair in objects if pair[0] not in late]
            with bodies.read_once():
                written = _solve_levels(garments, objects, scene, depsgraph)
            # Reading a garment may show that other points arrive than it was made for. What is worn over it follows it.
            changed = [pair for pair in garments if scheduler.allowed_now() and _needs_structure(*pair)]
            if changed:
                _rebuild_here(changed, depsgraph)
                with bodies.read_once():
                    written += _solve_levels(garments, objects, scene, depsgraph)
        finally:
            for obj, _ours in objects:
                runtimes.of(obj).pose = runtimes.of(obj).current = None  # valid only in this call
        for obj, _ours in objects:
            _note_seconds(runtimes.of(obj), evaluated)
        if written and len(objects) > 1:
            _tag_dependents(written, [obj for obj, _ in objects])


def _solve_levels(garments: list[bodies.Wrinkled], objects: list[bodies.Wrinkled], scene: bpy.types.Scene,
                  depsgraph: bpy.types.Depsgraph) -> list[bpy.types.Object]:
    """Solve garments, what is worn under others first. objects: also those that are not solved here. Returns the
    garments whose output was written."""
    outputs_seen: set[int] = set()
    differing = viewport_mesh.may_differ(objects)
    written: list[bpy.types.Object] = []
    for level in bodies.in_levels(garments):
        read = [GarmentReader(obj, nodes_mod, scene, depsgraph).read(outputs_seen, obj in differing)
                for obj, nodes_mod in level]
        frames = [frame for frame in read if frame is not None]
        garment_frame.solve_all(frames)
        written += [frame.obj for frame in frames if frame.show()]
    return written


def _note_seconds(runtime: Runtime, evaluated: float | None) -> None:
    """Store the time of this frame, if it was solved in this call. evaluated: seconds before the solve."""
    if evaluated is not None and runtime.solving > 0.0:
        runtime.frame_seconds = evaluated + runtime.solving
    runtime.solving = 0.0


def _tag_dependents(written: list[bpy.types.Object], wrinkled: list[bpy.types.Object]) -> None:
    """Wrinkled objects that depend on a written one have used its former result: let them be evaluated again.

    In background mode, in renders and in exports, tags would be too late. There these objects are one solve late
    (clip_status.py reports it).
    """
    if bpy.app.background or scheduler.rendering() or not scheduler.in_main_thread():
        return
    modifier.tag_soon(obj for obj in wrinkled if obj.library is None and modifier.depends_on(obj, written))


def _is_late(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether this depsgraph may not have evaluated its bodies, because the modifier does not refer to them yet."""
    with messages.frame_errors(obj, runtimes.of(obj)):
        _note_groups(obj)
        if clip_range.is_outdated(obj):
            scheduler.request(scheduler.DELAY)
        if bodies.is_connected(obj, nodes_mod):
            return False
        runtimes.of(obj).stale = True
        scheduler.request()
    return True


def _note_groups(obj: bpy.types.Object) -> None:
    """Detect vertex groups added or removed by scripts, because this tags nothing."""
    runtime = runtimes.known(obj)
    if runtime is not None and runtime.seen.groups not in (None, [group.name for group in obj.vertex_groups]):
        runtime.paint.forget()
        runtime.seen.groups, runtime.stale = None, True
        scheduler.request(scheduler.DELAY)


def _needs_structure(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    runtime = runtimes.known(obj)
    return runtime is None or runtime.stale or modifier.output_object(nodes_mod) is None


def _rebuild_here(objects: list, depsgraph: bpy.types.Depsgraph) -> None:
    """In background mode, rebuild between the passes, with the pose that the old mesh still has."""
    poses = {}
    for obj, nodes_mod in objects:
        with messages.frame_errors(obj, runtimes.of(obj)):
            poses[obj.name_full] = _posed(obj, depsgraph) if modifier.is_on(nodes_mod, depsgraph) else None
    scheduler.sync_all()
    for obj, nodes_mod in objects:
        with messages.frame_errors(obj, runtimes.of(obj)):
            if poses.get(obj.name_full) is None and modifier.is_on(nodes_mod, depsgraph):
                poses[obj.name_full] = _posed(obj, depsgraph)  # of another number of points than before
        runtimes.of(obj).pose = poses.get(obj.name_full)


def _posed(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Coarse positions of this frame: from the tree, or from the mesh itself if the tree did not change it."""
    evaluated = obj.evaluated_get(depsgraph)
    if not evaluated.is_evaluated or mesh_reader.is_busy(obj) or visibility.is_skipped(obj, depsgraph):
        return None
    count = len(incoming_mesh.of(obj).vertices)
    found = posed_coarse.positions(obj, count, depsgraph)
    return mesh_reader.plain_positions(evaluated, count) if found is None else found


def show_fine_meshes() -> None:
    """Called before a file is saved, because without the add-on it shows the saved output meshes. Viewports get their
    own meshes back."""
    with LOCK:
        for obj, nodes_mod in modifier.wrinkled_objects():
            runtime, output_obj = runtimes.known(obj), modifier.output_object(nodes_mod)
            if modifier.is_baked(nodes_mod) and modifier.play_clip(nodes_mod, True):  # live folds need the add-on
                modifier.tag_soon([obj])
                continue
            inputs = None if runtime is None else runtime.inputs
            if output_obj is None or inputs is None or not (inputs.for_preview or inputs.in_viewport
                                                            or inputs.shows_coarse
                                                            or not first_pass.shows_fine_mesh(nodes_mod)):
                continue
            try:
                first = units.first_frame(obj, units.scene_of(obj))
                result = runtime.evaluator.finish_frame(runtime.evaluator.find_frame(replace(
                    inputs, start=first, for_preview=False, in_viewport=False)))
                assert isinstance(result, FrameResult)
                output_mesh.write_result(output_obj.data, result, runtime.evaluator.ATTRIBUTES)
                set_flag(output_obj, Flag.COARSE_ONLY, False)  # a running bake sets it again
                if inputs.for_preview or inputs.shows_coarse:
                    output_mesh.write_proxy(output_obj.data, None)
            except Exception as error:  # the file is saved in any case
                print(f"Rumple: {messages.unexpected(obj, error)}")
            if inputs.for_preview or inputs.shows_coarse:
                runtime.invalidate_output()
                modifier.tag_soon([obj])
