# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads one garment in one frame: whether it is to be solved, and from what. Called by handlers: see solve.py."""
from __future__ import annotations

import bpy
import numpy as np

from ...core.base.wording import UserError
from .. import compat, scheduler
from ..objects import (bodies, evaluator, incoming_mesh, mesh_reader, messages, modifier, output_mesh, painted_maps,
                       posed_coarse, properties, runtimes, units, viewport_mesh, visibility, weight_paint, wind)
from ..objects.runtimes import Inputs
from ..viewport import preview
from . import clip_status, disk_frames
from .garment_frame import GarmentFrame

TWO_SCENES = "Two windows show this object in two scenes: both have the folds of the one that changed last"


class GarmentReader:
    """A garment in the frame of a depsgraph."""

    def __init__(self, obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, scene: bpy.types.Scene,
                 depsgraph: bpy.types.Depsgraph) -> None:
        self.obj, self.nodes_mod, self.scene, self.depsgraph = obj, nodes_mod, scene, depsgraph
        self.runtime = runtimes.of(obj)
        self.for_viewport = depsgraph.mode == "VIEWPORT"

    def read(self, outputs_seen: set[int], may_differ: bool) -> GarmentFrame | None:
        """What is to be solved; None if there is nothing. outputs_seen: session keys of the output objects of garments
        that were read before. may_differ: whether viewports may show other points than renders."""
        with messages.frame_errors(self.obj, self.runtime):
            if not self._can_write(outputs_seen):
                scheduler.request()
                return None
            if scheduler.may_prepare_frame():
                viewport_mesh.show_in_viewports(self.nodes_mod, may_differ)
            return self._read()
        return None

    def _can_write(self, outputs_seen: set[int]) -> bool:
        """Whether it has its own output objects, of its own system. Otherwise structural work makes them."""
        output_obj, outputs = modifier.output_object(self.nodes_mod), modifier.outputs(self.nodes_mod)
        if output_obj is None or output_obj.type != "MESH":
            return False
        if self.obj.rumple.method != modifier.system(self.nodes_mod).method:
            self.runtime.stale = True  # the modifier was copied from another object
            return False
        keys = {compat.session_key(output) for output in outputs}
        if keys & outputs_seen or not all(compat.is_editable(o) and compat.is_editable(o.data) for o in outputs):
            return False  # linked, or a duplicate that still shares its output: writing would have no effect
        outputs_seen |= keys
        return True

    def _read(self) -> GarmentFrame | None:
        obj, nodes_mod, runtime = self.obj, self.nodes_mod, self.runtime
        self.evaluated = obj.evaluated_get(self.depsgraph)
        if (not self.evaluated.is_evaluated or mesh_reader.is_busy(obj)
                or visibility.is_skipped(obj, self.depsgraph)):
            return None
        if self.for_viewport:
            evaluator.note_scale(obj, runtime)
        clip_fault = ""
        if modifier.is_baked(nodes_mod):
            clip_fault, is_played = self._play_clip()
            if is_played:
                return None
        if runtime.evaluator is None:
            evaluator.ensure(obj, runtime)
        if not self._fits():
            runtime.stale = True
            scheduler.request()
            return None
        inputs = self._inputs()
        if inputs is None:
            return None
        if runtime.analyzing:
            runtime.analyzed = inputs
            messages.set_frame_error(runtime, "")
            return None
        shown = modifier.viewport_output(nodes_mod) if inputs.in_viewport else modifier.output_object(nodes_mod)
        if self.for_viewport and not bpy.app.background:
            fine = runtime.evaluator.in_viewport if inputs.in_viewport else runtime.evaluator
            weight_paint.carry_colours(obj, shown, fine, runtime)
        if self._stays(inputs, compat.session_key(shown.data), clip_fault):
            runtime.current = inputs
            return None
        disk_frames.follow(obj, runtime)
        runtime.evaluator.settings_are_keyed = properties.are_keyed(obj)
        found = runtime.evaluator.find_frame(inputs)
        return GarmentFrame(obj, nodes_mod, shown, runtime, inputs, self.scene, self.depsgraph.mode, clip_fault, found)

    def _stays(self, inputs: Inputs, output_key: int, clip_fault: str) -> bool:
        """Whether the mesh with this key has these inputs, or must be left to another scene. Sets the messages."""
        runtime = self.runtime
        if inputs.same_as(runtime.inputs) and runtime.output_key == output_key:
            messages.set_frame_error(runtime, clip_fault)  # clear a message of another state
            messages.note_unplayed(runtime, runtime.unplayed, self.depsgraph.mode == "RENDER")
            return True
        if self.for_viewport and self._gave_way(inputs):
            messages.note_unplayed(runtime, TWO_SCENES, rendering=False)
            return True
        return False

    def _gave_way(self, inputs: Inputs) -> bool:
        """Whether only another scene, in another window, has written the shared mesh, and nothing else changed. Writing
        it back would make the other scene write again, without end."""
        if bpy.app.background:
            return False
        scenes = {compat.session_key(window.scene) for window in bpy.context.window_manager.windows}
        if len(scenes) < 2:
            self.runtime.written_for.clear()
            return False
        key = compat.session_key(self.scene)
        if inputs.same_as(self.runtime.written_for.get(key)):
            return True
        self.runtime.written_for[key] = inputs
        return False

    def _play_clip(self) -> tuple[str, bool]:
        """The error of this frame of a baked clip, and whether the clip is shown. If it is not, the frame is solved."""
        obj, runtime, frame = self.obj, self.runtime, float(self.scene.frame_current_final)
        fault = clip_status.cannot_play(obj, modifier.output_object(self.nodes_mod), frame)
        if fault and runtime.evaluator is None:
            evaluator.ensure(obj, runtime)
        if fault and runtime.evaluator.coarse_count != len(incoming_mesh.of(obj).vertices):
            fault = ""  # edited since the bake, as its note says: the evaluator is for another mesh
        can_solve = bool(fault) and self._fits()  # a restored clip needs the unchanged output object
        if modifier.play_clip(self.nodes_mod, not can_solve):
            runtime.stale = True
            scheduler.request()
        if not can_solve:
            messages.set_frame_error(runtime, fault or clip_status.compare_pose(obj, runtime, self.depsgraph, frame))
        return fault, not can_solve

    def _inputs(self) -> Inputs | None:
        """All inputs of the result; None if there is nothing to solve."""
        obj, evaluated, scene = self.obj, self.evaluated, self.scene
        positions = self._incoming()
        if positions is None or bodies.are_busy(obj):
            return None
        body = bodies.read(obj, evaluated, self.depsgraph)
        paint = painted_maps.read(obj)
        # Use the evaluated copy, because it has the right animated settings, also in renders. Lengths are in the units
        # of the scene that the fine mesh was made for, whichever scene is evaluated.
        known = evaluated if evaluated.rumple.method == obj.rumple.method else obj  # the method was set in this frame
        settings = properties.settings_of(known, units.scene_of(obj))
        world = np.array(evaluated.matrix_world.to_3x3(), np.float32)
        return Inputs(units.frame_of(scene), positions, settings, paint, units.first_frame(obj, scene), world,
                      units.frame_rate(scene), self.for_viewport and preview.uses_proxy(obj, self.nodes_mod), body,
                      wind.surroundings(evaluated, self.depsgraph, settings),
                      in_viewport=self.for_viewport and viewport_mesh.shows_own_mesh(self.nodes_mod),
                      shows_coarse=self.for_viewport and weight_paint.needs_coarse(obj))

    def _fits(self) -> bool:
        """Whether the output objects are the solved meshes. The expensive comparison is made once for each."""
        meshes = [output.data for output in modifier.outputs(self.nodes_mod)]
        solved = viewport_mesh.solved_for(self.nodes_mod, self.runtime.evaluator)
        if modifier.is_baked(self.nodes_mod):  # its output objects do not change, and only the first is shown
            meshes, solved = meshes[:1], solved[:1]
        if len(meshes) != len(solved):
            return False
        keys = tuple(compat.session_key(mesh) for mesh in meshes)
        if self.runtime.fitting == keys:
            return all(len(mesh.vertices) == fine.vertex_count for mesh, fine in zip(meshes, solved))
        if not all(output_mesh.is_embedding_of(mesh, fine) for mesh, fine in zip(meshes, solved)):
            return False
        self.runtime.fitting = keys
        return True

    def _incoming(self) -> np.ndarray | None:
        """Coarse positions of this frame; None if the modifier is off or did not change the mesh."""
        runtime, count = self.runtime, self.runtime.evaluator.coarse_count
        is_refused = bool(runtime.refusal) and len(incoming_mesh.of(self.obj).vertices) != count
        if is_refused and incoming_mesh.is_own(self.obj):
            return None  # until the mesh is edited the last valid result stays
        if runtime.pose is not None and len(runtime.pose) == count:
            return runtime.pose
        positions = posed_coarse.positions(self.obj, count, self.depsgraph)
        if positions is None and modifier.is_on(self.nodes_mod, self.depsgraph):
            arriving, in_render = len(self.evaluated.data.vertices), self.depsgraph.mode == "RENDER"
            if is_refused and arriving == runtime.seen.tried:
                return None  # the modifiers above the wrinkles make what was refused
            if arriving or in_render or not self._evaluate_outputs():
                self._follow_topology(arriving, in_render)
        else:
            runtime.seen.empty_at = None
            if is_refused and positions is not None:  # the evaluator is for the mesh that arrives now
                runtime.stale = True
                scheduler.request()
        return positions

    def _evaluate_outputs(self) -> bool:
        """Let Blender evaluate the output objects if nothing is shown, once per frame. Blender forgets them if
        relations are rebuilt while the modifier is off or the object is hidden. Returns whether this was requested."""
        frame = units.frame_of(self.depsgraph.scene)
        if self.runtime.seen.empty_at == frame:
            return False
        self.runtime.seen.empty_at = frame
        for output in modifier.outputs(self.nodes_mod):
            compat.values_changed(output.data)
        return True

    def _follow_topology(self, arriving: int, in_render: bool) -> None:
        """The number of incoming points has changed: request a rebuild. Raises UserError if this was already tried, or
        is impossible. arriving: the object's current number of vertices, including modifiers behind the wrinkles."""
        obj, runtime = self.obj, self.runtime
        changer, own = modifier.topology_changer_before(obj), len(incoming_mesh.of(obj).vertices)
        edited = (own != runtime.evaluator.coarse_count or modifier.coarse_vertices(self.nodes_mod) != own
                  or (changer is None and not incoming_mesh.is_own(obj))
                  or runtime.seen.stack != incoming_mesh.stack_fingerprint(obj))
        if changer is not None and not edited and arriving != own and (in_render or runtime.seen.tried == arriving):
            raise UserError(f"{obj.name}: the modifier \"{changer.name}\", or another above {self.nodes_mod.name}, "
                            f"makes another number of vertices here than at rest in the viewport ({own}), so there "
                            "are no wrinkles here: set the same for viewport and renders; where the number changes "
                            f"within the clip, apply it, or move it below {self.nodes_mod.name}")
        if edited or (changer is not None and arriving != own):  # otherwise this frame was just evaluated
            runtime.stale, runtime.seen.tried = True, arriving
            scheduler.request()
