# SPDX-License-Identifier: GPL-3.0-or-later
"""The live solve: called between Blender's two evaluation passes, for every depsgraph and every subframe.

The picture is a function of the pose and of stored state (core/history.py), so it does not matter how often,
for which depsgraph and in which order this is called. Rules that keep Blender alive:
never update a depsgraph here; while a render runs leave viewport depsgraphs alone; write nothing but attributes of
the output mesh, and nothing at all when nothing changed; leave baked objects alone.
"""
from __future__ import annotations

import bpy
import numpy as np

from ...core import engine
from .. import compat, scheduler
from ..objects import bodies, evaluator, mesh_reader, messages, modifier, output_mesh, properties, runtimes, units, wind
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
        if scheduler.allowed_now() and any(_needs_structure(obj, ours) for obj, ours in objects):
            _rebuild_here(objects, depsgraph)
        outputs_seen: set[int] = set()
        written = [obj for obj, ours in objects
                   if obj not in late and _process_guarded(obj, ours, scene, depsgraph, outputs_seen)]
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
    late = {obj for obj, ours in objects if not bodies.is_connected(obj, ours)}
    for obj in late:
        runtimes.of(obj).stale = True
        scheduler.request()
    return late


def _note_groups(obj: bpy.types.Object) -> None:
    """Adding and removing vertex groups from scripts tags nothing."""
    entry = runtimes.known(obj)
    if entry is not None and entry.groups is not None and entry.groups != [group.name for group in obj.vertex_groups]:
        entry.groups, entry.paint, entry.stale = None, None, True
        scheduler.request(scheduler.DELAY)


def _needs_structure(obj: bpy.types.Object, ours: bpy.types.NodesModifier) -> bool:
    entry = runtimes.known(obj)
    return entry is None or entry.stale or modifier.output_object(ours) is None


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
    count = len(obj.data.vertices)
    found = mesh_reader.posed_positions(evaluated, count)
    return mesh_reader.plain_positions(evaluated, count) if found is None else found


def _process_guarded(obj: bpy.types.Object, ours: bpy.types.NodesModifier, scene: bpy.types.Scene,
                     depsgraph: bpy.types.Depsgraph, outputs_seen: set[int]) -> bool:
    """True when the output object was written."""
    entry = runtimes.of(obj)
    with messages.frame_errors(obj, entry):
        held = modifier.output_object(ours)
        if held is None or held.type != "MESH":
            scheduler.request()
            return False
        key = compat.session_key(held)
        if key in outputs_seen or held.library is not None or held.data.library is not None:
            scheduler.request()  # a duplicate that is not split yet, or linked: writing would be silently ignored
            return False
        outputs_seen.add(key)
        try:
            return _process(obj, ours, held, entry, scene, depsgraph)
        except mesh_reader.Reordered as error:
            raise engine.Refused(f"{obj.name}: {error}") from error
    return False


def _process(obj: bpy.types.Object, ours: bpy.types.NodesModifier, held: bpy.types.Object, entry: Runtime,
             scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> bool:
    evaluated = obj.evaluated_get(depsgraph)
    if not evaluated.is_evaluated or obj.mode in mesh_reader.BUSY_MODES:
        return False
    if modifier.is_baked(ours):
        frame = float(scene.frame_current_final)
        messages.set_frame_error(entry, clip_status.compare_pose(obj, entry, evaluated, frame))
        return False
    if entry.evaluator is None:
        evaluator.ensure(obj, entry)
    if not _fits(held, entry):
        entry.stale = True
        scheduler.request()
        return False
    inputs = _inputs(obj, ours, entry, evaluated, scene, depsgraph)
    if inputs is None:
        return False
    if entry.analyzing:
        entry.analyzed = inputs
        messages.set_frame_error(entry, "")
        return False
    if inputs.same_as(entry.inputs) and entry.output_key == compat.session_key(held.data):
        messages.set_frame_error(entry, "")  # what was wrong in between is as it was before
        messages.note_unplayed(entry, entry.unplayed, depsgraph.mode == "RENDER")
        return False
    picture = _solve(entry, inputs, scene, inputs.uses_proxy)
    entry.inputs = inputs
    messages.set_frame_error(entry, "")
    unplayed = entry.evaluator.unplayed_message(inputs.frame, scene.frame_start) if picture.unplayed else ""
    messages.note_unplayed(entry, unplayed, depsgraph.mode == "RENDER")
    if entry.evaluator.HAS_CURVES:
        path_curves.write(obj, entry)
    return _show(held, entry, picture, depsgraph.mode == "VIEWPORT")


def _solve(entry: Runtime, inputs: Inputs, scene: bpy.types.Scene, sketched: bool) -> engine.Picture | engine.Sketch:
    return entry.evaluator.solve_frame(inputs.frame, inputs.positions, inputs.settings, inputs.paint,
                                       start=scene.frame_start, world_from_object=inputs.world_from_object,
                                       frame_rate=inputs.frame_rate, sketched=sketched, body=inputs.body,
                                       surroundings=inputs.surroundings)


def show_fine_meshes() -> None:
    """Before a file is saved: without the add-on it shows what its output objects hold. Viewports get theirs back."""
    with LOCK:
        for obj, ours in modifier.wrinkled_objects():
            entry, held = runtimes.known(obj), modifier.output_object(ours)
            if held is None or entry is None or entry.inputs is None or not entry.inputs.uses_proxy:
                continue
            try:
                _show(held, entry, _solve(entry, entry.inputs, units.scene_of(obj), sketched=False), True)
            except Exception as error:  # the file is saved all the same
                print(f"Rumple: {messages.unexpected(obj, error)}")
            entry.invalidate_output()
            scheduler.tag_soon({obj.name})


def _inputs(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime, evaluated: bpy.types.Object,
            scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> Inputs | None:
    """Everything the picture depends on; None where there is nothing to solve."""
    positions = _incoming(obj, ours, entry, evaluated, depsgraph)
    if positions is None or bodies.are_busy(obj):
        return None
    body = bodies.read(obj, evaluated, depsgraph)
    if entry.paint is None:
        entry.paint = mesh_reader.paint(obj, properties.settings_of(obj, scene))
    # The evaluated copy: animated settings are right there, in renders too.
    settings = properties.settings_of(evaluated, scene)
    world = np.array(evaluated.matrix_world.to_3x3(), np.float32)
    uses_proxy = depsgraph.mode == "VIEWPORT" and preview.uses_proxy(obj, ours)
    return Inputs(float(scene.frame_current_final), settings, positions, world, entry.paint,
                  scene.render.fps / scene.render.fps_base, uses_proxy, body,
                  wind.surroundings(evaluated, depsgraph, settings))


def _fits(held: bpy.types.Object, entry: Runtime) -> bool:
    """Whether the output object is the fine mesh that is solved. The costly comparison is made once for each."""
    if entry.output_key == compat.session_key(held.data):
        return len(held.data.vertices) == entry.evaluator.vertex_count
    return output_mesh.is_embedding_of(held.data, entry.evaluator)


def _incoming(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime, evaluated: bpy.types.Object,
              depsgraph: bpy.types.Depsgraph) -> np.ndarray | None:
    """Coarse positions of this frame; None where the modifier is off or passed the coarse mesh through."""
    if entry.pose is not None:
        return entry.pose
    count = len(entry.evaluator.base.positions)
    positions = mesh_reader.posed_positions(evaluated, count)
    shown = ours.show_render if depsgraph.mode == "RENDER" else ours.show_viewport
    if positions is not None or not shown:
        return positions
    if len(obj.data.vertices) != count or modifier.coarse_vertices(ours) != count:
        entry.stale = True
        scheduler.request()  # the topology was edited
        return None
    changer = modifier.topology_changer_before(obj)
    if changer is not None:
        raise engine.Refused(f"{obj.name}: the modifier \"{changer.name}\" in front of {ours.name} changes the number "
                             "of vertices: apply it, or move it behind")
    return None


def _show(held: bpy.types.Object, entry: Runtime, picture: engine.Picture | engine.Sketch, in_viewport: bool) -> bool:
    """Write the picture, unless it is there already: a write tags the mesh and costs another evaluation."""
    key = compat.session_key(held.data)
    last = entry.picture
    entry.picture = picture
    if last is not None and entry.output_key == key and last.shows_the_same(picture):
        return False
    if isinstance(picture, engine.Sketch):
        output_mesh.write_proxy(held.data, picture.proxy_offset)
    else:
        output_mesh.write_picture(held.data, picture, entry.evaluator.ATTRIBUTES)
        if in_viewport:
            output_mesh.write_proxy(held.data, None)
    entry.output_key = key
    return True
