# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake Wrinkle Map: makes the map of a reference pose from the wrinkles of another system in this pose.

bpy.ops.rumple.maps_bake() bakes the active pose, maps_bake(every=True) bakes all poses. A copy of the object gets the
chosen wrinkles, which are solved in the pose until they settle. Blender's own baker (Cycles, selected to active) writes
their normals to the coarse mesh's UV map. This works on copies in a separate scene. Only the image and its slot change
in the artist's file.
"""
from __future__ import annotations

import io
from contextlib import ExitStack, contextmanager, redirect_stdout
from pathlib import Path
from typing import Generator, Iterator

import bpy
import numpy as np
from mathutils import Matrix

from ...core.base.wording import UserError
from .. import compat, scheduler, ui_base
from ..nodes import maps_shader
from ..objects import clip_place, messages, properties, runtimes, units
from ..translation import said
from . import (bake_apart, bake_meshes, bake_source, changes as maps_changes, export as maps_export, keys as maps_keys,
               operators as maps_operators, posed_rig, rig as maps_rig)

SAMPLES = 8  # samples per texel, so that wrinkles narrower than a texel are averaged
SETTLE_ITERATIONS = 100  # from the canonical start: a single frame may take longer
HIGH_FOLDS = 99.0  # per cent of the points: the others lie in corners of mouth and eyes, where skin meets skin ...
CAGE_OFFSETS = 2.0  # ... and an automatic cage that stands this many heights outside sees no other skin

STEEPEST = 0.2  # cosine of the steepest slope that a wrinkle can have: 78 degrees
BONE_CHANNELS = ("location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")

_runs_in = -1  # number of the file of which a window bakes maps


class MapBake:
    """Bakes poses one after the other. steps() does the work, close() restores the former state."""

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object, poses: list[int]) -> None:
        """poses: their places in the list. Raises UserError if nothing can be baked."""
        self.context, self.obj, settings = context, obj, obj.rumple_maps
        maps_rig.refuse_without_pose(obj)
        # As they are now: while a second Blender bakes, the artist may change all of them.
        self.name, self.poses = obj.name, [settings.poses[number].name for number in poses]
        self.size, self.deep, self.folder = settings.bake_size, settings.bake_deep, settings.bake_folder
        self.armature = obj.find_armature()
        self.done = 0
        self.names: list[str] = []  # of the images
        self.gone: list[str] = []  # poses that are no longer there
        self.uv_map = bake_meshes.uv_map(obj)
        self.notes = bake_meshes.outside_notes(obj, self.uv_map)
        if "CYCLES" not in _engines():
            raise UserError("Cycles bakes the maps: switch on its add-on in the preferences")
        self._was_locked = context.scene.render.use_lock_interface
        self._former = [(bone.name, name, tuple(getattr(bone, name))) for name in BONE_CHANNELS
                        for bone in (self.armature.pose.bones if self.armature is not None else ())]

    @property
    def count(self) -> int:
        return 3 * len(self.poses)

    def steps(self) -> Generator[str, None, None]:
        """Yields a description before each step. Raises UserError."""
        for name in self.poses:
            pose = self.obj.rumple_maps.poses[name]
            yield f"{pose.name}: settling the wrinkles"
            with self._posed_copies(pose) as (low, high, height):
                self.done += 1
                yield f"{pose.name}: baking"
                image = self._bake(pose, low, high, height)
                self.done += 1
            yield f"{pose.name}: storing the map"
            pose.image = image
            self._store(image)
            self.names.append(image.name)
            self.done += 1

    def take(self, name: str, pixels: np.ndarray) -> None:
        """Store the map of a pose that another Blender has baked, unless the pose is gone. Everything is looked up by
        name, because an undo makes Python's references invalid. pixels: (4 texels,) float32."""
        obj = bpy.data.objects.get(self.name)
        pose = None if obj is None else obj.rumple_maps.poses.get(name)
        if pose is None:
            self.gone.append(name)
            return
        image = self._new_image(name)
        with ExitStack() as failed:
            failed.callback(bpy.data.images.remove, image)
            image.pixels.foreach_set(pixels)
            image.update()
            failed.pop_all()
        pose.image = image
        self.names.append(image.name)
        self._store(image)

    def refuse(self, text: str) -> None:
        """Raise UserError with the error of the other Blender."""
        raise UserError(text)

    def close(self) -> None:
        """Restore the pose of the armature, and the scene's lock, which the first click sets."""
        self.context.scene.render.use_lock_interface = self._was_locked
        for bone, name, values in self._former:
            setattr(self.armature.pose.bones[bone], name, values)
        maps_changes.maps_changed(self.obj)
        self.context.view_layer.update()

    # --- the two meshes
    @contextmanager
    def _posed_copies(self, pose: bpy.types.PropertyGroup
                      ) -> Iterator[tuple[bpy.types.Object, bpy.types.Object, float]]:
        """The coarse and the wrinkled mesh in a reference pose, both without modifiers; and the height of the folds."""
        with ExitStack() as ended:
            rig = posed_rig.PosedRig(self.context, self.obj, pose.bones, ended)
            keys = maps_keys.of_records(pose.keys)
            coarse, wrinkled = (bake_meshes.plain_copy(self.obj, self.context.scene, suffix, keys, ended)
                                for suffix in ("low", "high"))
            for copy in (coarse, wrinkled):
                rig.lead(copy)
            bake_meshes.copy_guides(self.obj, wrinkled, ended)
            ended.callback(bake_meshes.remove_wrinkles, wrinkled)
            with self._printed_of_copy(wrinkled):
                self._add_wrinkles(wrinkled)
            low, high = (self._frozen(copy, ended) for copy in (coarse, wrinkled))
            if rig.astray():
                raise UserError(f"{self.obj.name}: bone {rig.astray()} of {self.armature.name} does not come to where "
                                f"pose {pose.name} has it: bring it there with what moves it, and bake")
            for mesh in (low.data, high.data):  # alike, so that the map is flat where there is no fold
                compat.shade_smooth(mesh)
                mesh.update()
            if "rumple_offset" not in high.data.attributes:
                raise UserError(self._of_copy(wrinkled, runtimes.message(wrinkled))
                                or f"{self.obj.name}: its wrinkles do not show in this pose: change the pose, or "
                                "choose another source")
            offsets = compat.read_attribute(high.data.attributes["rumple_offset"])
            yield low, high, float(np.percentile(np.sqrt((offsets * offsets).sum(1)), HIGH_FOLDS))

    def _add_wrinkles(self, copy: bpy.types.Object) -> None:
        method = self.obj.rumple_maps.bake_source
        copy.rumple.method = method
        properties.apply_values(copy, self.context.scene,
                                bake_source.skin_settings(self.obj, self.context.scene, method))
        copy.rumple.method = "NONE"  # else rumple_add() takes a captured rest shape for a trace of a former modifier
        with self.context.temp_override(object=copy, active_object=copy, selected_objects=[copy]):
            try:
                bpy.ops.object.rumple_add(method=method, shade=False)
            except RuntimeError as error:  # what it reports as an error
                raise UserError(self._of_copy(copy, str(error).removeprefix("Error: ").strip())) from error
        settings = properties.group_of(copy)
        settings.stateless = True  # a single pose without frames before it
        if method == "FIELD":
            settings.output = "GEOMETRY"
        elif method == "MESH":
            settings.start_iterations = max(SETTLE_ITERATIONS, settings.start_iterations)
        scheduler.sync_all()
        for _ in range(2):  # the first update solves, the second one shows the result
            copy.update_tag()
            self.context.view_layer.update()

    def _of_copy(self, copy: bpy.types.Object, text: str) -> str:
        """A message about a copy of the object, with the name of the object that the artist knows."""
        return text.replace(copy.name, self.obj.name)

    @contextmanager
    def _printed_of_copy(self, copy: bpy.types.Object) -> Iterator[None]:
        """What is said on the console about a copy meanwhile has the name of the object too."""
        printed = io.StringIO()
        try:
            with redirect_stdout(printed):
                yield
        finally:
            print(self._of_copy(copy, printed.getvalue()), end="")

    def _frozen(self, copy: bpy.types.Object, ended: ExitStack) -> bpy.types.Object:
        """A copy without modifiers, scaled to metres, because the baker's lengths are in the units of its own scene and
        of the coarse mesh. ended: deletes it."""
        depsgraph = self.context.evaluated_depsgraph_get()
        mesh = bpy.data.meshes.new_from_object(copy.evaluated_get(depsgraph), preserve_all_data_layers=True,
                                               depsgraph=depsgraph)
        metres = self.context.scene.unit_settings.scale_length
        mesh.transform(Matrix.Diagonal((*(metres * abs(scale) for scale in copy.matrix_world.to_scale()), 1.0)))
        frozen = bpy.data.objects.new(copy.name, mesh)
        ended.callback(bake_meshes.delete, frozen)
        return frozen

    # --- the baker
    def _bake(self, pose: bpy.types.PropertyGroup, low: bpy.types.Object, high: bpy.types.Object,
              height: float) -> bpy.types.Image:
        settings, image = self.obj.rumple_maps, self._new_image(pose.name)
        with ExitStack() as failed, ExitStack() as ended:
            failed.callback(bpy.data.images.remove, image)
            material = bake_meshes.show_only(low, image)
            ended.callback(bpy.data.materials.remove, material)
            bake_meshes.choose_uv_map(low.data, self.uv_map)
            metres = units.metres_per_unit(self.obj, self.context.scene)
            cage = (settings.bake_cage * self.context.scene.unit_settings.scale_length
                    or max(CAGE_OFFSETS * height * metres, 1e-6))
            scene = bpy.data.scenes.new("Rumple Bake")
            ended.callback(bpy.data.scenes.remove, scene)
            for obj in (low, high):
                scene.collection.objects.link(obj)
                obj.rumple.method = "NONE"
            scene.render.engine = "CYCLES"
            scene.cycles.samples, scene.cycles.use_denoising = SAMPLES, False
            layer = scene.view_layers[0]
            layer.update()
            with self.context.temp_override(scene=scene, view_layer=layer, object=low, active_object=low,
                                            selected_objects=[low, high]):
                try:
                    bpy.ops.object.bake(type="NORMAL", normal_space="TANGENT", use_selected_to_active=True,
                                        use_clear=True, cage_extrusion=cage, max_ray_distance=2.0 * cage,
                                        margin=settings.bake_margin, target="IMAGE_TEXTURES", save_mode="INTERNAL")
                except RuntimeError as error:
                    raise UserError(f"{self.obj.name}: pose {pose.name} cannot be baked: {error}") from error
            _flatten_strays(image)
            failed.pop_all()
        return image

    def _new_image(self, pose: str) -> bpy.types.Image:
        image = bpy.data.images.new(f"{self.name} {pose}", self.size, self.size, alpha=False, float_buffer=self.deep,
                                    is_data=True)
        image.colorspace_settings.name = "Non-Color"
        return image

    def _store(self, image: bpy.types.Image) -> None:
        """Store the image in the blend file, or as a file if a folder is set."""
        if not self.folder:
            image.pack()
            return
        try:
            folder = Path(bpy.path.abspath(clip_place.blend_path(self.folder)))
            maps_export.save_image(image, folder, self.deep)
        except (OSError, RuntimeError) as error:
            image.pack()
            raise UserError(f"{self.name}: the map {image.name} cannot be saved and is packed: {error}") from error


def _engines() -> set[str]:
    return {"CYCLES"} if hasattr(bpy.types.Scene, "cycles") else set()


def _flatten_strays(image: bpy.types.Image) -> None:
    """Make texels flat whose normals are almost sideways. Their rays hit other skin, where a mesh folds over itself."""
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    texels = pixels.reshape(-1, 4)
    strays = texels[:, 2] < 0.5 + 0.5 * STEEPEST
    if strays.any():
        texels[strays] = maps_shader.FLAT
        image.pixels.foreach_set(pixels)
        image.update()


class RUMPLE_OT_maps_bake(maps_operators.OnPose, ui_base.ModalWork, bpy.types.Operator):
    """Make the wrinkle map of the active reference pose from the object's own wrinkles"""

    bl_idname = "rumple.maps_bake"
    bl_label = "Bake Wrinkle Map"

    every: bpy.props.BoolProperty(name="Every Pose", description="Bake the maps of all reference poses",
                                  options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        bake = None
        try:
            bake = self._begin(context)
            for _ in bake.steps():
                pass
        except UserError as error:
            return ui_base.refuse(self, error)
        finally:
            if bake is not None:
                bake.close()
        return self._finished(bake)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        global _runs_in
        if bpy.app.background:
            return self.execute(context)
        if _runs_in == scheduler.file_number():
            self.report({"WARNING"}, said("Another bake is under way: wait for it, or press Esc in its window"))
            return {"CANCELLED"}
        try:
            self._running = bake_apart.ApartBake(self._begin(context))
        except UserError as error:
            return ui_base.refuse(self, error)
        _runs_in, self._steps = scheduler.file_number(), self._running.steps()
        return self.begin_modal(context, self._running.count, 0.05)

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        plan = self._running.plan
        if (event.type, event.value) == ("ESC", "PRESS"):  # the release may be of an Esc that ended something else
            self._stop(context)
            self.report({"INFO"}, said(f"Bake cancelled; finished maps: {', '.join(plan.names) or 'none'}"))
            return {"CANCELLED"}
        if event.type != "TIMER" or scheduler.job_runs():
            return {"PASS_THROUGH"}
        try:
            text = said(next(self._steps))
        except StopIteration:
            self._stop(context)
            return self._finished(plan)
        except Exception as error:  # any exception: otherwise Blender would continue to call this operator
            self._stop(context)
            text = str(error) if isinstance(error, UserError) else messages.unexpected(plan.name, error)
            return ui_base.refuse(self, text)
        context.window_manager.progress_update(self._running.done)
        self.show_status(context, said(f"{text} ({self._running.done} of {self._running.count}). Esc cancels"))
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Called if another file is opened or the window is closed."""
        self._stop(context)

    def _begin(self, context: bpy.types.Context) -> MapBake:
        obj = maps_operators.target(context)
        settings = obj.rumple_maps
        return MapBake(context, obj, list(range(len(settings.poses))) if self.every else [settings.active])

    def _stop(self, context: bpy.types.Context) -> None:
        global _runs_in
        _runs_in = -1
        self._steps.close()
        self._running.close()
        self.end_modal(context)

    def _finished(self, bake: MapBake) -> set[str]:
        if bake.names:
            self.report({"INFO"}, said(f"Baked {', '.join(bake.names)}"))
        ui_base.warn(self, "; ".join(bake.notes))
        if bake.gone:
            self.report({"WARNING"}, said(f"{bake.name}: it or these poses were removed or renamed during the bake, so "
                                          f"they get no map: {', '.join(bake.gone)}"))
        return {"FINISHED"} if bake.names else {"CANCELLED"}


CLASSES = (RUMPLE_OT_maps_bake,)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
