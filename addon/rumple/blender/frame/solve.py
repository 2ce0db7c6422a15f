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

from ...core.base.wording import UserError
from ...core.frame import engine
from .. import compat, scheduler
from ..nodes.output_flags import Flag, set_flag
from ..objects import (bodies, changes, clip_range, evaluator, incoming_mesh, mesh_reader, messages, modifier,
                       output_mesh, painted_maps, posed_coarse, properties, runtimes, units, viewport_mesh, visibility,
                       weight_paint, wind)
from ..objects.runtimes import Inputs, Runtime
from ..scheduler import LOCK
from ..viewport import preview
from . import clip_status, disk_frames, first_pass, garment_frame
from .garment_frame import GarmentFrame


TWO_SCENES = "Two windows show this object in two scenes: both have the folds of the one that changed last"


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
            with bodies.read_once():
                written = _solve_levels([pair for pair in objects if pair[0] not in late], objects, scene, depsgraph)
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
        read = [_read_guarded(obj, nodes_mod, scene, depsgraph, outputs_seen, obj in differing)
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
    for obj, _ours in objects:
        runtimes.of(obj).pose = poses.get(obj.name_full)


def _posed(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Coarse positions of this frame: from the tree, or from the mesh itself if the tree did not change it."""
    evaluated = obj.evaluated_get(depsgraph)
    if not evaluated.is_evaluated or mesh_reader.is_busy(obj) or visibility.is_skipped(obj, depsgraph):
        return None
    count = len(incoming_mesh.of(obj).vertices)
    found = posed_coarse.positions(obj, count, depsgraph)
    return mesh_reader.plain_positions(evaluated, count) if found is None else found


def _read_guarded(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, scene: bpy.types.Scene,
                  depsgraph: bpy.types.Depsgraph, outputs_seen: set[int], may_differ: bool) -> GarmentFrame | None:
    """What is to be solved; None if there is nothing. may_differ: whether viewports may show other points than
    renders."""
    runtime = runtimes.of(obj)
    with messages.frame_errors(obj, runtime):
        output_obj = modifier.output_object(nodes_mod)
        if output_obj is None or output_obj.type != "MESH":
            scheduler.request()
            return None
        if obj.rumple.method != modifier.system(nodes_mod).method:  # the modifier was copied from another object
            runtime.stale = True
            scheduler.request()
            return None
        keys = {compat.session_key(output) for output in modifier.outputs(nodes_mod)}
        if keys & outputs_seen or not all(compat.is_editable(o) and compat.is_editable(o.data)
                                          for o in modifier.outputs(nodes_mod)):
            scheduler.request()  # linked, or a duplicate that still shares its output: writing would have no effect
            return None
        outputs_seen |= keys
        if scheduler.may_prepare_frame():
            viewport_mesh.show_in_viewports(nodes_mod, may_differ)
        return _read(obj, nodes_mod, output_obj, runtime, scene, depsgraph)
    return None


def _read(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, output_obj: bpy.types.Object, runtime: Runtime,
          scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> GarmentFrame | None:
    evaluated = obj.evaluated_get(depsgraph)
    if not evaluated.is_evaluated or mesh_reader.is_busy(obj) or visibility.is_skipped(obj, depsgraph):
        return None
    if depsgraph.mode == "VIEWPORT":
        evaluator.note_scale(obj, runtime)
    clip_fault = ""
    if modifier.is_baked(nodes_mod):
        clip_fault, is_played = _play_clip(obj, nodes_mod, output_obj, runtime, depsgraph,
                                           float(scene.frame_current_final))
        if is_played:
            return None
    if runtime.evaluator is None:
        evaluator.ensure(obj, runtime)
    if not _fits(nodes_mod, runtime):
        runtime.stale = True
        scheduler.request()
        return None
    inputs = _inputs(obj, nodes_mod, runtime, evaluated, scene, depsgraph)
    if inputs is None:
        return None
    if runtime.analyzing:
        runtime.analyzed = inputs
        messages.set_frame_error(runtime, "")
        return None
    shown = modifier.viewport_output(nodes_mod) if inputs.in_viewport else output_obj
    if depsgraph.mode == "VIEWPORT" and not bpy.app.background:
        fine = runtime.evaluator.in_viewport if inputs.in_viewport else runtime.evaluator
        weight_paint.carry_colours(obj, shown, fine, runtime)
    if _stays(runtime, inputs, compat.session_key(shown.data), scene, depsgraph, clip_fault):
        runtime.current = inputs
        return None
    disk_frames.follow(obj, runtime)
    runtime.evaluator.settings_are_keyed = properties.are_keyed(obj)
    found = runtime.evaluator.find_frame(inputs)
    return GarmentFrame(obj, nodes_mod, shown, runtime, inputs, scene, depsgraph.mode, clip_fault, found)


def _stays(runtime: Runtime, inputs: Inputs, output_key: int, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph,
           clip_fault: str) -> bool:
    """Whether the mesh with this key has these inputs, or must be left to another scene. Sets the messages."""
    if inputs.same_as(runtime.inputs) and runtime.output_key == output_key:
        messages.set_frame_error(runtime, clip_fault)  # clear a message of another state
        messages.note_unplayed(runtime, runtime.unplayed, depsgraph.mode == "RENDER")
        return True
    if depsgraph.mode == "VIEWPORT" and _gave_way(runtime, inputs, scene):
        messages.note_unplayed(runtime, TWO_SCENES, rendering=False)
        return True
    return False


def _gave_way(runtime: Runtime, inputs: Inputs, scene: bpy.types.Scene) -> bool:
    """Whether only another scene, in another window, has written the shared mesh, and nothing else changed. Writing it
    back would make the other scene write again, without end."""
    if bpy.app.background:
        return False
    scenes = {compat.session_key(window.scene) for window in bpy.context.window_manager.windows}
    if len(scenes) < 2:
        runtime.written_for.clear()
        return False
    key = compat.session_key(scene)
    if inputs.same_as(runtime.written_for.get(key)):
        return True
    runtime.written_for[key] = inputs
    return False


def _play_clip(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, output_obj: bpy.types.Object,
               runtime: Runtime, depsgraph: bpy.types.Depsgraph, frame: float) -> tuple[str, bool]:
    """The error of this frame of a baked clip, and whether the clip is shown. If it is not, the frame is solved."""
    fault = clip_status.cannot_play(obj, output_obj, frame)
    if fault and runtime.evaluator is None:
        evaluator.ensure(obj, runtime)
    if fault and runtime.evaluator.coarse_count != len(incoming_mesh.of(obj).vertices):
        fault = ""  # edited since the bake, as its note says: the evaluator is for another mesh
    can_solve = bool(fault) and _fits(nodes_mod, runtime)  # a restored clip needs the unchanged output object
    if modifier.play_clip(nodes_mod, not can_solve):
        runtime.stale = True
        scheduler.request()
    if not can_solve:
        messages.set_frame_error(runtime, fault or clip_status.compare_pose(obj, runtime, depsgraph, frame))
    return fault, not can_solve


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
                assert isinstance(result, engine.FrameResult)
                output_mesh.write_result(output_obj.data, result, runtime.evaluator.ATTRIBUTES)
                set_flag(output_obj, Flag.COARSE_ONLY, False)  # a running bake sets it again
                if inputs.for_preview or inputs.shows_coarse:
                    output_mesh.write_proxy(output_obj.data, None)
            except Exception as error:  # the file is saved in any case
                print(f"Rumple: {messages.unexpected(obj, error)}")
            if inputs.for_preview or inputs.shows_coarse:
                runtime.invalidate_output()
                modifier.tag_soon([obj])


def _inputs(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime, evaluated: bpy.types.Object,
            scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> Inputs | None:
    """All inputs of the result; None if there is nothing to solve."""
    positions = _incoming(obj, nodes_mod, runtime, depsgraph)
    if positions is None or bodies.are_busy(obj):
        return None
    body = bodies.read(obj, evaluated, depsgraph)
    paint = painted_maps.read(obj)
    # Use the evaluated copy, because it has the right animated settings, also in renders. Lengths are in the units of
    # the scene that the fine mesh was made for, whichever scene is evaluated.
    known = evaluated if evaluated.rumple.method == obj.rumple.method else obj  # the method was set in this frame
    settings = properties.settings_of(known, units.scene_of(obj))
    world = np.array(evaluated.matrix_world.to_3x3(), np.float32)
    for_viewport = depsgraph.mode == "VIEWPORT"
    return Inputs(units.frame_of(scene), positions, settings, paint, units.first_frame(obj, scene), world,
                  units.frame_rate(scene), for_viewport and preview.uses_proxy(obj, nodes_mod), body,
                  wind.surroundings(evaluated, depsgraph, settings),
                  in_viewport=for_viewport and viewport_mesh.shows_own_mesh(nodes_mod),
                  shows_coarse=for_viewport and weight_paint.needs_coarse(obj))


def _fits(nodes_mod: bpy.types.NodesModifier, runtime: Runtime) -> bool:
    """Whether the output objects are the solved meshes. The expensive comparison is made once for each."""
    meshes = [output.data for output in modifier.outputs(nodes_mod)]
    solved = viewport_mesh.solved_for(nodes_mod, runtime.evaluator)
    if modifier.is_baked(nodes_mod):  # its output objects do not change, and only the first is shown
        meshes, solved = meshes[:1], solved[:1]
    if len(meshes) != len(solved):
        return False
    keys = tuple(compat.session_key(mesh) for mesh in meshes)
    if runtime.fitting == keys:
        return all(len(mesh.vertices) == fine.vertex_count for mesh, fine in zip(meshes, solved))
    if not all(output_mesh.is_embedding_of(mesh, fine) for mesh, fine in zip(meshes, solved)):
        return False
    runtime.fitting = keys
    return True


def _incoming(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime,
              depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Coarse positions of this frame; None if the modifier is off or did not change the mesh."""
    count = runtime.evaluator.coarse_count
    if runtime.refusal and len(incoming_mesh.of(obj).vertices) != count:
        return None  # the current mesh was refused: the last valid result stays
    if runtime.pose is not None and len(runtime.pose) == count:
        return runtime.pose
    positions = posed_coarse.positions(obj, count, depsgraph)
    if positions is None and modifier.is_on(nodes_mod, depsgraph):
        arriving = len(obj.evaluated_get(depsgraph).data.vertices)
        in_render = depsgraph.mode == "RENDER"
        if arriving or in_render or not _evaluate_outputs(nodes_mod, runtime, units.frame_of(depsgraph.scene)):
            _follow_topology(obj, nodes_mod, runtime, arriving, in_render)
    else:
        runtime.seen.empty_at = None
    return positions


def _evaluate_outputs(nodes_mod: bpy.types.NodesModifier, runtime: Runtime, frame: float) -> bool:
    """Let Blender evaluate the output objects if nothing is shown, once per frame. Blender forgets them if relations
    are rebuilt while the modifier is off or the object is hidden. Returns whether this was requested."""
    if runtime.seen.empty_at == frame:
        return False
    runtime.seen.empty_at = frame
    for output in modifier.outputs(nodes_mod):
        compat.values_changed(output.data)
    return True


def _follow_topology(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime, arriving: int,
                     in_render: bool) -> None:
    """The number of incoming points has changed: request a rebuild. Raises UserError if this was already tried, or is
    impossible. arriving: the object's current number of vertices, including modifiers behind the wrinkles."""
    changer, own = modifier.topology_changer_before(obj), len(incoming_mesh.of(obj).vertices)
    edited = (own != runtime.evaluator.coarse_count or modifier.coarse_vertices(nodes_mod) != own
              or (changer is None and not incoming_mesh.is_own(obj))
              or runtime.seen.stack != incoming_mesh.stack_fingerprint(obj))
    if changer is not None and not edited and arriving != own and (in_render or runtime.seen.tried == arriving):
        raise UserError(f"{obj.name}: the modifier \"{changer.name}\", or another above {nodes_mod.name}, "
                        f"makes another number of vertices here than at rest in the viewport ({own}), so there "
                        "are no wrinkles here: set the same for viewport and renders; where the number changes "
                        f"within the clip, apply it, or move it below {nodes_mod.name}")
    if edited or (changer is not None and arriving != own):  # otherwise this frame was just evaluated
        runtime.stale, runtime.seen.tried = True, arriving
        scheduler.request()
