# SPDX-License-Identifier: GPL-3.0-or-later
"""The live solve: called between Blender's two evaluation passes, for every depsgraph and every subframe.

The picture is a function of the pose and of stored state (core/frame_cache.py), so it does not matter how often,
for which depsgraph and in which order this is called. Rules that keep Blender alive:
never update a depsgraph here; while a render runs leave viewport depsgraphs alone; write nothing but attributes of
the output mesh, and nothing at all when nothing changed; leave baked objects alone.
"""
from __future__ import annotations

import bpy
import numpy as np

from ...core import engine
from .. import compat, scheduler
from ..objects import (bodies, evaluator, incoming_mesh, mesh_reader, messages, modifier, output_mesh, properties,
                       runtimes, units, wind)
from ..objects.runtimes import Inputs, Runtime
from ..scheduler import LOCK
from ..viewport import preview
from . import clip_status, path_curves


def process(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Solve what this depsgraph shows. Never raises."""
    if not scheduler.may_process(depsgraph):
        return
    with LOCK:
        objects = bodies.in_order(list(modifier.wrinkled_objects()))
        late = _not_connected(objects)
        for obj, _ours in objects:
            _note_groups(obj)
        if scheduler.allowed_now() and any(_needs_structure(obj, nodes_mod) for obj, nodes_mod in objects):
            _rebuild_here(objects, depsgraph)
        outputs_seen: set[int] = set()
        written = [obj for obj, nodes_mod in objects
                   if obj not in late and _process_guarded(obj, nodes_mod, scene, depsgraph, outputs_seen)]
        for obj, _ours in objects:
            runtimes.of(obj).pose = None  # it belongs to this call only
        if written and len(objects) > 1:
            _tag_dependents(written, [obj for obj, _ in objects])


def _tag_dependents(written: list[bpy.types.Object], wrinkled: list[bpy.types.Object]) -> None:
    """Wrinkled objects that lean on a written one saw its last picture: let them be evaluated once more.

    In background and in renders nothing can be tagged in time: they are one solve late there (clip_status.py says so).
    """
    if bpy.app.background or scheduler.rendering():
        return
    scheduler.tag_soon({obj.name for obj in wrinkled if obj.library is None and modifier.depends_on(obj, written)})


def _not_connected(objects: list) -> set[bpy.types.Object]:
    """Those whose bodies this depsgraph may not have evaluated: their modifiers do not name them yet."""
    late = {obj for obj, nodes_mod in objects if not bodies.is_connected(obj, nodes_mod)}
    for obj in late:
        runtimes.of(obj).stale = True
        scheduler.request()
    return late


def _note_groups(obj: bpy.types.Object) -> None:
    """Adding and removing vertex groups from scripts tags nothing."""
    runtime = runtimes.known(obj)
    if runtime is not None and runtime.groups is not None and runtime.groups != [group.name
                                                                                 for group in obj.vertex_groups]:
        runtime.groups, runtime.paint, runtime.stale = None, None, True
        scheduler.request(scheduler.DELAY)


def _needs_structure(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    runtime = runtimes.known(obj)
    return runtime is None or runtime.stale or modifier.output_object(nodes_mod) is None


def _rebuild_here(objects: list, depsgraph: bpy.types.Depsgraph) -> None:
    """Background mode: rebuild between the passes, with the pose that the old mesh still carries."""
    poses = {obj.name_full: _posed(obj, depsgraph) for obj, _ in objects}
    scheduler.sync_all()
    for obj, _ours in objects:
        runtimes.of(obj).pose = poses[obj.name_full]


def _posed(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Coarse positions of this frame, from the tree or, where it passed the coarse mesh through, from that."""
    evaluated = obj.evaluated_get(depsgraph)
    if not evaluated.is_evaluated or obj.mode in mesh_reader.BUSY_MODES:
        return None
    count = len(incoming_mesh.of(obj).vertices)
    found = mesh_reader.posed_positions(evaluated, count)
    return mesh_reader.plain_positions(evaluated, count) if found is None else found


def _process_guarded(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, scene: bpy.types.Scene,
                     depsgraph: bpy.types.Depsgraph, outputs_seen: set[int]) -> bool:
    """True when the output object was written."""
    runtime = runtimes.of(obj)
    with messages.frame_errors(obj, runtime):
        output_obj = modifier.output_object(nodes_mod)
        if output_obj is None or output_obj.type != "MESH":
            scheduler.request()
            return False
        key = compat.session_key(output_obj)
        if key in outputs_seen or output_obj.library is not None or output_obj.data.library is not None:
            scheduler.request()  # a duplicate that is not split yet, or linked: writing would be silently ignored
            return False
        outputs_seen.add(key)
        try:
            return _process(obj, nodes_mod, output_obj, runtime, scene, depsgraph)
        except mesh_reader.Reordered as error:
            raise engine.UserError(f"{obj.name}: {error}") from error
    return False


def _process(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, output_obj: bpy.types.Object, runtime: Runtime,
             scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> bool:
    evaluated = obj.evaluated_get(depsgraph)
    if not evaluated.is_evaluated or obj.mode in mesh_reader.BUSY_MODES:
        return False
    if modifier.is_baked(nodes_mod):
        frame = float(scene.frame_current_final)
        messages.set_frame_error(runtime, clip_status.compare_pose(obj, runtime, evaluated, frame))
        return False
    if runtime.evaluator is None:
        evaluator.ensure(obj, runtime)
    if not _fits(output_obj, runtime):
        runtime.stale = True
        scheduler.request()
        return False
    inputs = _inputs(obj, nodes_mod, runtime, evaluated, scene, depsgraph)
    if inputs is None:
        return False
    if runtime.analyzing:
        runtime.analyzed = inputs
        messages.set_frame_error(runtime, "")
        return False
    if inputs.same_as(runtime.inputs) and runtime.output_key == compat.session_key(output_obj.data):
        messages.set_frame_error(runtime, "")  # what was wrong in between is as it was before
        messages.note_unplayed(runtime, runtime.unplayed, depsgraph.mode == "RENDER")
        return False
    result = _solve(runtime, inputs, scene, inputs.uses_proxy)
    runtime.inputs = inputs
    messages.set_frame_error(runtime, "")
    unplayed = runtime.evaluator.unplayed_message(inputs.frame, scene.frame_start) if result.unplayed else ""
    messages.note_unplayed(runtime, unplayed, depsgraph.mode == "RENDER")
    if runtime.evaluator.HAS_CURVES:
        path_curves.write(obj, runtime)
    written = _show(output_obj, runtime, result, depsgraph.mode == "VIEWPORT")
    if written:
        runtime.written_at = compat.session_key(scene), inputs.frame
    return written


def _solve(runtime: Runtime, inputs: Inputs, scene: bpy.types.Scene,
           for_preview: bool) -> engine.FrameResult | engine.PreviewFrame:
    return runtime.evaluator.solve_frame(inputs.frame, inputs.positions, inputs.settings, inputs.paint,
                                         start=scene.frame_start, world_from_object=inputs.world_from_object,
                                         frame_rate=inputs.frame_rate, for_preview=for_preview, body=inputs.body,
                                         surroundings=inputs.surroundings)


def show_fine_meshes() -> None:
    """Before a file is saved: without the add-on it shows what its output objects hold. Viewports get theirs back."""
    with LOCK:
        for obj, nodes_mod in modifier.wrinkled_objects():
            runtime, output_obj = runtimes.known(obj), modifier.output_object(nodes_mod)
            if output_obj is None or runtime is None or runtime.inputs is None or not runtime.inputs.uses_proxy:
                continue
            try:
                _show(output_obj, runtime, _solve(runtime, runtime.inputs, units.scene_of(obj), for_preview=False),
                      True)
            except Exception as error:  # the file is saved all the same
                print(f"Rumple: {messages.unexpected(obj, error)}")
            runtime.invalidate_output()
            scheduler.tag_soon({obj.name})


def _inputs(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime, evaluated: bpy.types.Object,
            scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> Inputs | None:
    """Everything the picture depends on; None where there is nothing to solve."""
    positions = _incoming(obj, nodes_mod, runtime, evaluated, depsgraph)
    if positions is None or bodies.are_busy(obj):
        return None
    body = bodies.read(obj, evaluated, depsgraph)
    if runtime.paint is None:
        runtime.paint = mesh_reader.paint(obj, properties.settings_of(obj, scene))
    # The evaluated copy: animated settings are right there, in renders too.
    settings = properties.settings_of(evaluated, scene)
    world = np.array(evaluated.matrix_world.to_3x3(), np.float32)
    uses_proxy = depsgraph.mode == "VIEWPORT" and preview.uses_proxy(obj, nodes_mod)
    return Inputs(float(scene.frame_current_final), settings, positions, world, runtime.paint,
                  scene.render.fps / scene.render.fps_base, uses_proxy, body,
                  wind.surroundings(evaluated, depsgraph, settings))


def _fits(output_obj: bpy.types.Object, runtime: Runtime) -> bool:
    """Whether the output object is the fine mesh that is solved. The costly comparison is made once for each."""
    if runtime.output_key == compat.session_key(output_obj.data):
        return len(output_obj.data.vertices) == runtime.evaluator.vertex_count
    return output_mesh.is_embedding_of(output_obj.data, runtime.evaluator)


def _incoming(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime, evaluated: bpy.types.Object,
              depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Coarse positions of this frame; None where the modifier is off or passed the coarse mesh through."""
    if runtime.pose is not None:
        return runtime.pose
    count = runtime.evaluator.coarse_count
    positions = mesh_reader.posed_positions(evaluated, count)
    shown = nodes_mod.show_render if depsgraph.mode == "RENDER" else nodes_mod.show_viewport
    if positions is not None or not shown:
        return positions
    _follow_topology(obj, nodes_mod, runtime, len(evaluated.data.vertices), depsgraph.mode == "RENDER")
    return None


def _follow_topology(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime, arriving: int,
                     in_render: bool) -> None:
    """Other points arrive than the wrinkles were made for: let them be made anew. Raises UserError where that was
    tried, or cannot be. arriving: how many vertices the object has now, modifiers behind the wrinkles included."""
    changer, own = modifier.topology_changer_before(obj), len(incoming_mesh.of(obj).vertices)
    edited = (own != runtime.evaluator.coarse_count or modifier.coarse_vertices(nodes_mod) != own
              or incoming_mesh.is_own(obj) != (changer is None)
              or runtime.stack != incoming_mesh.stack_fingerprint(obj))
    if changer is not None and not edited and (in_render or runtime.tried == arriving):
        raise engine.UserError(f"{obj.name}: \"{changer.name}\" or another modifier in front of {nodes_mod.name} makes "
                               f"another number of vertices here than at rest in the viewport ({own}): set the same "
                               f"for viewport and renders, apply it, or move it behind {nodes_mod.name}")
    if edited or changer is not None:
        runtime.stale, runtime.tried = True, arriving
        scheduler.request()


def _show(output_obj: bpy.types.Object, runtime: Runtime, result: engine.FrameResult | engine.PreviewFrame,
          in_viewport: bool) -> bool:
    """Write the picture, unless it is there already: a write tags the mesh and costs another evaluation."""
    key = compat.session_key(output_obj.data)
    last = runtime.result
    runtime.result = result
    if last is not None and runtime.output_key == key and last.shows_the_same(result):
        return False
    if isinstance(result, engine.PreviewFrame):
        output_mesh.write_proxy(output_obj.data, result.proxy_offset)
    else:
        output_mesh.write_result(output_obj.data, result, runtime.evaluator.ATTRIBUTES)
        if in_viewport:
            output_mesh.write_proxy(output_obj.data, None)
    runtime.output_key = key
    return True
