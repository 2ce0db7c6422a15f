# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons: add, remove, capture the rest shape, clear stored frames. Apply is in apply_operator.py.

bpy.ops.object.rumple_add(method="MESH"), rumple_remove(), rumple_capture_rest(), rumple_clear_frames().
"""
from __future__ import annotations

from typing import Any

import bpy

from ... import native
from ...core.mesh.base_mesh import built_once
from ...core.systems.all_systems import SYSTEMS
from .. import compat, scheduler, ui_base
from ..first_click import cloth_defaults
from ..first_click.set_up import set_up
from ..frame import disk_frames, rebuild
from ..maps import rebuild as maps_rebuild
from ..nodes import field_shader, wrinkle_tree
from ..objects import (bodies, held_by_others, incoming_mesh, modifier, posed_coarse, properties, runtimes, shared_mesh,
                       stack_notes, subdivision_behind)
from ..translation import said
from . import fabrics, thumbnails, wave_materials

_NEXT = "Next: play it; fabric and folds are set in its panel, in the modifier tab"
_OF_FINE_MESH = ("rest_shape", "source", "density", "level", "segments", "edge_length", "display_steps", "detail",
                 "most_vertices")
_Setting = tuple[bpy.types.PropertyGroup, str]
NOT_SHOWN = "The wrinkles do not show: switch the modifier on in the viewport first"


def _added_presets(operator: bpy.types.Operator, _context: bpy.types.Context | None) -> tuple:
    """The presets of the added system."""
    method = getattr(operator, "method", "")
    return (thumbnails.items(method) if method in SYSTEMS else ()) or thumbnails.items("MESH")


def _is_last_operation(context: bpy.types.Context) -> bool:
    done = context.window_manager.operators
    return len(done) > 0 and isinstance(done[-1], OBJECT_OT_rumple_add)


def _other_mesh(scene: bpy.types.Scene, name: str, obj: bpy.types.Object) -> bpy.types.Object | None:
    """The object with this name in the scene, if it can be the body of another one."""
    found = scene.objects.get(name)
    return found if found is not None and found != obj and bodies.can_be_body(found) else None


def _set_properties(obj: bpy.types.Object) -> dict[_Setting, Any]:
    """The explicitly set settings of its method and of its vertex limit, with their values."""
    of_method = properties.group_of(obj)
    settings = [(of_method, name) for name in properties.fields_of(obj)] + [(obj.rumple, "most_vertices")]
    return {(group, name): getattr(group, name) for group, name in settings if group.is_property_set(name)}


class OBJECT_OT_rumple_add(bpy.types.Operator):
    """Add wrinkles that form where the animated mesh is compressed"""

    bl_idname = "object.rumple_add"
    bl_label = "Add Wrinkles"
    bl_options = {"REGISTER", "UNDO"}

    method: bpy.props.EnumProperty(name="Method", items=(*properties.METHODS[1:], properties.MAPS), default="MESH",
                                   options={"SKIP_SAVE"})
    shade: bpy.props.BoolProperty(name="Add to Materials", default=True, options={"SKIP_SAVE"},
                                  description="Wrinkle Field: let the materials of the object draw the waves")

    # Shown by Adjust Last Operation, and used if they were changed there.
    preset: bpy.props.EnumProperty(name="Fabric", items=_added_presets, options={"SKIP_SAVE"},
                                   description="The fabric that it is made of")
    width: bpy.props.FloatProperty(name="Wavelength", subtype="DISTANCE", unit="LENGTH", min=0.0, soft_max=0.2,
                                   step=0.02, precision=4, options={"SKIP_SAVE"},
                                   description="From fold to fold, or the width of a path")
    body: bpy.props.StringProperty(name="Body", options={"SKIP_SAVE"},
                                   description="What this garment is worn over: cloth stays outside of it")
    width_of: bpy.props.StringProperty(options={"HIDDEN", "SKIP_SAVE"},
                                       description="The fabric that this wavelength was shown for")
    _may_wait = False

    def draw(self, context: bpy.types.Context) -> None:
        """Draw Adjust Last Operation."""
        system = SYSTEMS.get(self.method)
        if system is None:
            return
        column = ui_base.property_column(self.layout)
        if system.presets:
            column.prop(self, "preset")
        column.prop(self, "width", slider=True)
        column.prop_search(self, "body", context.scene, "objects")
        if self.method == "FIELD":
            column.prop(self, "shade")

    @classmethod
    def description(cls, _context: bpy.types.Context, chosen: bpy.types.OperatorProperties) -> str:
        """The tooltip of the chosen method."""
        return said(next(tip for method, _label, tip in (*properties.METHODS, properties.MAPS)
                         if method == chosen.method))

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        why = ui_base.refusal(context.object, wrinkled=False)
        if why == ui_base.WRINKLED and _is_last_operation(context):
            why = ""  # Adjust Last Operation calls poll() before it undoes the first click
        return ui_base.may_run(cls, why)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Called from a menu: long work continues in a thread. Scripts wait for the complete result."""
        self._may_wait = True
        return self.execute(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        why = ui_base.refusal(obj, wrinkled=False)
        if why:
            return ui_base.refuse(self, why)
        if self.method == "MAPS":
            return self._add_maps(obj)
        try:
            native.load()
        except native.NativeMissing as error:
            return ui_base.refuse(self, error)
        with built_once():
            return self._add_wrinkles(context, obj)

    def _add_wrinkles(self, context: bpy.types.Context, obj: bpy.types.Object) -> set[str]:
        runtimes.forget(obj)
        if obj.rumple.method in SYSTEMS:  # it was converted to a mesh, or its modifier was removed otherwise
            rebuild.drop_traces(obj)
        obj.rumple.method = self.method
        kept, maps, by_hand = _set_properties(obj), set(obj.vertex_groups.keys()), self._may_wait
        notes = set_up(obj, context.scene)
        if set(obj.vertex_groups.keys()) - maps:
            ui_base.warn(self, shared_mesh.note(obj))
        self._adjust(context, obj)
        with scheduler.suspended():
            nodes_mod = modifier.add(obj, self.method)
        # Handlers write while the window draws. Without the lock, a render in the window may crash.
        context.scene.render.use_lock_interface = True
        if self.method == "FIELD":
            self._show_waves(context, obj)
        if self._is_left_to_a_thread(obj, nodes_mod):
            bodies.connect_all()
            self._report_notes(obj, notes, [])
            self.report({"INFO"}, said(f"{said(properties.system_of(obj).label)} added: its folds are being made"))
            return {"FINISHED"}
        note = self._make(obj, nodes_mod)
        if modifier.output_object(nodes_mod) is None and by_hand:
            note = self._make_without(context, obj, nodes_mod, kept)
        bodies.connect_all()
        if modifier.output_object(nodes_mod) is None:
            why = runtimes.message(obj) or f"{obj.name}: nothing to wrinkle"
            remove(obj)
            for group in [group for group in obj.vertex_groups if group.name not in maps]:
                obj.vertex_groups.remove(group)  # painted by this click
            return ui_base.refuse(self, why)
        self._report(obj, notes, [note] if note else [])
        return {"FINISHED"}

    def _add_maps(self, obj: bpy.types.Object) -> set[str]:
        try:
            return bpy.ops.rumple.maps_add()
        except RuntimeError as error:  # bpy.ops raises this if poll() fails
            return ui_base.refuse(self, f"{obj.name}: {str(error).rsplit('poll() ', 1)[-1].strip()}")

    def _show_waves(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Show the waves of a Wrinkle Field in materials and viewports."""
        if self.shade:
            field_shader.shade_object(obj)
        if context.space_data is not None and not obj.rumple.field.is_property_set("gpu_preview"):
            obj.rumple.field.gpu_preview = True  # otherwise Solid viewports do not show it

    def _is_left_to_a_thread(self, obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
        """Whether the folds are built in a thread while the window stays usable. Not if a Subdivision behind may have
        to be changed for them: this is tried at once."""
        may_wait, self._may_wait = self._may_wait, False  # Adjust Last Operation executes it again
        if not may_wait or subdivision_behind.quality(obj):
            return False
        with scheduler.thread_builds_allowed():
            in_thread = rebuild.build_in_thread(obj, nodes_mod)
        if in_thread:
            runtimes.of(obj).build.just_added = True
            scheduler.request()
        return in_thread

    def _make(self, obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> str:
        """Make the fine mesh. Returns a sentence about modifiers that were changed for it, or an empty text."""
        if self._is_made(obj, nodes_mod):
            return ""
        return subdivision_behind.try_lighter(obj, lambda: self._is_made(obj, nodes_mod))

    @staticmethod
    def _is_made(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
        rebuild.prepare(obj, nodes_mod)
        return modifier.output_object(nodes_mod) is not None

    def _make_without(self, context: bpy.types.Context, obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier,
                      kept: dict[_Setting, Any]) -> str:
        """Try again without settings of the fine mesh that were kept from a removal, because an object without wrinkles
        has no panel to change them. If this fails too, they are restored. kept: the settings from before the click.
        Returns the same as _make()."""
        width, why = SYSTEMS[self.method].wrinkles.SUGGESTED, runtimes.message(obj)
        names = {*_OF_FINE_MESH, width}
        left_out = {setting: value for setting, value in kept.items() if setting[1] in names}
        if not left_out:
            return ""
        for group, name in [*left_out, *(setting for setting in _set_properties(obj) if setting not in kept)]:
            group.property_unset(name)
        self.properties.property_unset("width")
        set_up(obj, context.scene)
        self._adjust(context, obj)
        if cloth_defaults.is_cloth(obj):
            sheet = cloth_defaults.is_sheet(obj, obj.rumple.body)
            of_cloth = cloth_defaults.defaults(obj, context.scene, sheet, cloth_defaults.is_closed(obj, context.scene))
            properties.apply_values(obj, context.scene, {name: of_cloth[name] for name in {width} & of_cloth.keys()})
        note = self._make(obj, nodes_mod)
        if modifier.output_object(nodes_mod) is not None:
            self.report({"WARNING"}, said(why))
            return note
        for (group, name), value in left_out.items():
            setattr(group, name, value)
        return note

    def _adjust(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Apply the values of Adjust Last Operation, and show the current values there."""
        system, settings = SYSTEMS[self.method], properties.group_of(obj)
        length = system.wrinkles.SUGGESTED
        if system.presets and self.properties.is_property_set("preset") and self.preset != settings.preset:
            fabrics.use(obj, context.scene, self.preset)
        fabric = settings.preset if system.presets else ""
        if self.properties.is_property_set("width") and self.width_of == fabric:
            setattr(settings, length, self.width)
        if self.properties.is_property_set("body"):
            obj.rumple.body = _other_mesh(context.scene, self.body, obj)
        self.width, self.width_of = getattr(settings, length), fabric
        self.body = "" if obj.rumple.body is None else obj.rumple.body.name
        if system.presets:
            self.preset = fabric

    def _report_notes(self, obj: bpy.types.Object, notes: list[str], warnings: list[str]) -> None:
        for note in warnings + stack_notes.of(obj) + (
                wave_materials.unshaded(obj) if self.method == "FIELD" and self.shade else []):
            self.report({"WARNING"}, said(note))
        for note in notes:
            self.report({"INFO"}, said(note))

    def _report(self, obj: bpy.types.Object, notes: list[str], warnings: list[str]) -> None:
        evaluator = runtimes.of(obj).evaluator
        origin = evaluator.base.origin
        self._report_notes(obj, notes + ([] if origin is None else origin.notes(obj.name)), warnings)
        worn_over = ", ".join(body.name for body in bodies.of(obj))
        label = said(properties.system_of(obj).label)
        made = said(f"{label} added, {evaluator.vertex_count:,} vertices, over {worn_over}" if worn_over else
                    f"{label} added, {evaluator.vertex_count:,} vertices")
        self.report({"INFO"}, f"{made}. {said(_NEXT)}")


def remove(obj: bpy.types.Object) -> None:
    """Remove the wrinkles. Wrinkle Maps stay, and become the object's method."""
    rebuild.remove_all(obj)
    maps_rebuild.note_method(obj)


class OBJECT_OT_rumple_remove(ui_base.OnWrinkled, bpy.types.Operator):
    """Take the wrinkles away and everything that was made for them"""

    bl_idname = "object.rumple_remove"
    bl_label = "Remove Wrinkles"

    def execute(self, context: bpy.types.Context) -> set[str]:
        notes = held_by_others.after_removal(context.object)
        remove(context.object)
        ui_base.warn(self, "; ".join(notes))
        return {"FINISHED"}


class OBJECT_OT_rumple_capture_rest(ui_base.OnWrinkled, bpy.types.Operator):
    """Take the shape of the mesh at the rest frame as the unwrinkled cloth"""

    bl_idname = "object.rumple_capture_rest"
    bl_label = "Capture Rest Shape"

    frame: bpy.props.IntProperty(name="Frame", description="Frame to capture; unset: the rest frame of the panel",
                                 default=-(1 << 20), options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj, scene = context.object, context.scene
        if not compat.is_editable(incoming_mesh.of(obj)):
            return ui_base.refuse(self, ui_base.LINKED_MESH)
        if self.properties.is_property_set("frame"):
            obj.rumple.rest_frame = self.frame
        now = scene.frame_current, scene.frame_subframe
        try:
            scene.frame_set(obj.rumple.rest_frame)
            coarse = incoming_mesh.of(obj)
            positions = posed_coarse.positions(obj, len(coarse.vertices), context.evaluated_depsgraph_get())
            if positions is not None:
                compat.write_attribute(coarse, wrinkle_tree.REST_POSITION, "FLOAT_VECTOR", "POINT", positions)
                properties.group_of(obj).rest_shape = "FRAME"
                runtimes.of(obj).stale = True
                scheduler.sync_all()
        finally:
            scene.frame_set(now[0], subframe=now[1])
        if positions is None:
            return ui_base.refuse(self, runtimes.message(obj) or NOT_SHOWN)
        ui_base.warn(self, shared_mesh.note_of_capture(obj))
        return {"FINISHED"}


class OBJECT_OT_rumple_clear_frames(ui_base.OnWrinkled, bpy.types.Operator):
    """Forget the stored frames: they are solved anew"""

    bl_idname = "object.rumple_clear_frames"
    bl_label = "Clear Stored Frames"
    bl_options = {"REGISTER"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        with scheduler.LOCK:
            runtime = runtimes.of(context.object)
            if runtime.evaluator is not None:
                runtime.evaluator.frame_cache.clear()
                disk_frames.clear(context.object)
            runtime.invalidate_output()
        context.object.update_tag()
        return {"FINISHED"}


CLASSES = (OBJECT_OT_rumple_add, OBJECT_OT_rumple_remove, OBJECT_OT_rumple_capture_rest,
           OBJECT_OT_rumple_clear_frames)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
