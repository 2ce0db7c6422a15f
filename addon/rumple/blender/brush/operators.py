# SPDX-License-Identifier: GPL-3.0-or-later
"""The brush for rest-pose wrinkles: its settings (scene.rumple_brush), operators and tool.

bpy.ops.object.rumple_brush() activates the brush in the 3D viewports. rumple_brush_stroke() paints one stroke.
rumple_scatter(seed=0, density=0.5, size=0.1, length=0.7) and rumple_clear_rest_wrinkles() work without a mouse.
"""
from __future__ import annotations

import math
from typing import Callable

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ...core.base.wording import UserError
from ...core.systems.brush import DEFAULT_LENGTH, LONGEST
from .. import compat, scheduler, ui_base
from ..objects import messages, modifier, shared_mesh
from ..translation import said
from . import canvas as brush_canvas, overlay as brush_overlay
from .stroke import Stroke

TOOL = "rumple.rest_wrinkles"

_LENGTH = dict(name="Depth", min=0.0, max=LONGEST, default=DEFAULT_LENGTH, subtype="FACTOR",
               description="How strong the painted folds are. 0.7: as where the cloth is pushed together to half its "
                           "width")


PATCH = 0.1  # metres, default size


class RUMPLE_Brush(bpy.types.PropertyGroup):
    """The brush for rest-pose wrinkles."""

    radius: bpy.props.IntProperty(name="Radius", default=50, min=1, max=2000, soft_max=500, subtype="PIXEL",
                                  options=set(), description="Of the brush, in pixels. F in the viewport changes it")
    strength: bpy.props.FloatProperty(name="Strength", default=0.5, min=0.0, max=1.0, subtype="FACTOR", options=set(),
                                      description="Blend factor of one dab. Shift F in the viewport changes it")
    length: bpy.props.FloatProperty(options=set(), **_LENGTH)
    falloff: bpy.props.EnumProperty(name="Falloff", default="SMOOTH", options=set(), items=[
        ("SMOOTH", "Smooth", "Soft at the rim and in the middle", "SMOOTHCURVE", 0),
        ("SHARP", "Sharp", "Falls off at once", "SHARPCURVE", 1),
        ("LINEAR", "Linear", "Falls off evenly", "LINCURVE", 2),
        ("CONSTANT", "Constant", "The same up to the rim", "NOCURVE", 3)],
        description="How the brush fades towards its rim")
    direction: bpy.props.EnumProperty(name="Direction", default="STROKE", options=set(), items=[
        ("STROKE", "Stroke", "The way of the hand"),
        ("HORIZONTAL", "Left-Right", "From left to right on the screen, wherever the hand goes"),
        ("VERTICAL", "Up-Down", "Up the screen, wherever the hand goes"),
        ("ANGLE", "Angle", "A direction on the screen, wherever the hand goes")],
        description="What the folds go by")
    angle: bpy.props.FloatProperty(name="Angle", default=0.0, min=-math.pi, max=math.pi, subtype="ANGLE", options=set(),
                                   description="On the screen: 0 is left to right, 90 degrees upwards. Ctrl Alt F in "
                                               "the viewport changes it")
    run: bpy.props.EnumProperty(name="Folds Run", default="ALONG", options=set(), items=[
        ("ALONG", "Along", "Crests and valleys follow the direction"),
        ("ACROSS", "Across", "Crests and valleys cross the direction: it is the cloth's compression")],
        description="How the folds lie to the direction")
    mirror_x: bpy.props.BoolProperty(name="Mirror X", default=False, options=set(),
                                     description="Paint the mirror image too, across the rest shape's own X axis")
    pressure_strength: bpy.props.BoolProperty(name="Pressure Strength", default=True, options=set(),
                                              description="The pen's pressure scales the strength")
    pressure_radius: bpy.props.BoolProperty(name="Pressure Radius", default=False, options=set(),
                                            description="The pen's pressure scales the radius")
    show_overlay: bpy.props.BoolProperty(name="Overlay", default=True, options=set(),
                                         description="Draw what is painted while the brush is in hand")
    show_vectors: bpy.props.BoolProperty(name="Show Vectors", default=False, options=set(),
                                         description="Draw the stored vectors, across the folds, in place of lines "
                                                     "along them")


def refusal(obj: bpy.types.Object | None) -> str:
    """Why an object cannot be painted; empty if it can."""
    if obj is None or obj.type != "MESH":
        return "Choose a mesh object first"
    if not (compat.is_editable(obj) and compat.is_editable(obj.data)):
        return ui_base.LINKED_MESH
    if obj.mode != "OBJECT":
        return "Go to Object Mode first"
    nodes_mod = modifier.find(obj)
    if nodes_mod is None or modifier.system(nodes_mod).method != "FIELD":
        return "This object has no Wrinkle Field: add one first"
    return ""


class _OnField:
    """Operators for an object with a Wrinkle Field whose mesh can be written."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        why = refusal(context.object)
        return ui_base.may_run(cls, why)

    @staticmethod
    def rebuild_what_is_due() -> None:
        """Do pending rebuilds first, because the brush needs the current mesh."""
        if not scheduler.rendering():
            scheduler.sync_all()


class OBJECT_OT_rumple_brush(_OnField, bpy.types.Operator):
    """Take up the brush for rest-pose wrinkles in the 3D viewports"""

    bl_idname = "object.rumple_brush"
    bl_label = "Paint Rest Wrinkles"
    bl_options = {"REGISTER"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        ui_base.warn(self, shared_mesh.note(context.object))
        return bpy.ops.wm.tool_set_by_id(name=TOOL, space_type="VIEW_3D")


class OBJECT_OT_rumple_brush_stroke(_OnField, bpy.types.Operator):
    """Paint rest-pose wrinkles. Ctrl erases, Shift smooths, Esc takes the stroke back"""

    bl_idname = "object.rumple_brush_stroke"
    bl_label = "Rest Wrinkle Stroke"
    bl_options = {"UNDO", "BLOCKING", "INTERNAL"}

    touch: bpy.props.EnumProperty(name="Touch", default="PAINT", options={"SKIP_SAVE"}, items=[
        ("PAINT", "Paint", "Add wrinkles"), ("ERASE", "Erase", "Take them away"),
        ("SMOOTH", "Smooth", "Even them out")])

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        # Errors of the object are reported when the mouse is pressed, so they must not disable the operator.
        return context.mode == "OBJECT" and context.region_data is not None

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        why = refusal(context.object)
        if why:
            self.report({"WARNING"}, said(why))
            return {"CANCELLED"}
        self.stroke: Stroke | None = None
        result = self._guarded(context, lambda: self._press(context, event))
        if result == {"RUNNING_MODAL"}:
            context.window_manager.modal_handler_add(self)
        return result

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            return self._guarded(context, self._take_back)
        if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
            return self._guarded(context, lambda: self._on(event, self.stroke.move))
        if event.type == "LEFTMOUSE" and event.value == "RELEASE":
            return {"FINISHED"} if self.stroke.changed else {"CANCELLED"}
        return {"RUNNING_MODAL"}

    def _press(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.rebuild_what_is_due()
        self.stroke = Stroke(context.object, context.scene.rumple_brush, self.touch, context.region,
                             context.region_data, context.evaluated_depsgraph_get())
        return self._on(event, self.stroke.press)

    def _on(self, event: bpy.types.Event, act: Callable[[float, float, float], None]) -> set[str]:
        region = self.stroke.region
        act(event.mouse_x - region.x, event.mouse_y - region.y, event.pressure)
        return {"RUNNING_MODAL"}

    def _take_back(self) -> set[str]:
        if self.stroke is not None:
            self.stroke.cancel()
        return {"CANCELLED"}

    def _guarded(self, context: bpy.types.Context, step: Callable[[], set[str]]) -> set[str]:
        """Run a step. After an error, report it and undo the stroke."""
        try:
            return step()
        except UserError as error:
            self.report({"ERROR"}, said(str(error)))
            return self._take_back()
        except Exception as error:  # a message, never a traceback; the mesh may be gone
            return ui_base.refuse(self, messages.unexpected(context.object, error))


class OBJECT_OT_rumple_scatter(_OnField, bpy.types.Operator):
    """Random rest-pose wrinkles all over the mesh, in place of what is painted"""

    bl_idname = "object.rumple_scatter"
    bl_label = "Scatter Rest Wrinkles"

    seed: bpy.props.IntProperty(name="Seed", default=0, min=0, description="Another seed gives other wrinkles")
    density: bpy.props.FloatProperty(name="Density", default=0.4, min=0.0, max=1.0, subtype="FACTOR",
                                     description="Share of the mesh's points that wrinkle")
    size: bpy.props.FloatProperty(name="Size", default=PATCH, min=0.0001, soft_max=1.0, max=100.0, subtype="DISTANCE",
                                  unit="LENGTH", options={"SKIP_SAVE"},
                                  description="Of the wrinkled patches, on the rest shape")
    length: bpy.props.FloatProperty(**_LENGTH)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        self.rebuild_what_is_due()
        try:
            brush_canvas.read(obj.data)
            unit = context.scene.unit_settings.scale_length
            if not self.properties.is_property_set("size"):
                self.size = PATCH / unit
            metres = self.size * unit
            scattered = brush_canvas.canvas_of(obj).easel.scatter(self.seed, self.density, metres, self.length)
        except UserError as error:
            return ui_base.refuse(self, error)
        brush_canvas.write(obj.data, scattered)
        self.report({"INFO"}, said(f"{int(np.any(scattered != 0.0, axis=1).sum())} points wrinkle at rest"))
        ui_base.warn(self, shared_mesh.note(obj))
        return {"FINISHED"}


class OBJECT_OT_rumple_clear_rest_wrinkles(_OnField, bpy.types.Operator):
    """Take away all rest-pose wrinkles, painted and scattered"""

    bl_idname = "object.rumple_clear_rest_wrinkles"
    bl_label = "Clear Rest Wrinkles"

    def execute(self, context: bpy.types.Context) -> set[str]:
        brush_canvas.write(context.object.data, None)
        ui_base.warn(self, shared_mesh.note(context.object))
        return {"FINISHED"}


def _radial(path: str, **keys: bool) -> tuple:
    return ("wm.radial_control", {"type": "F", "value": "PRESS", **keys},
            {"properties": [("data_path_primary", f"scene.rumple_brush.{path}")]})


def _stroke(touch: str, **keys: bool) -> tuple:
    return (OBJECT_OT_rumple_brush_stroke.bl_idname, {"type": "LEFTMOUSE", "value": "PRESS", **keys},
            {"properties": [("touch", touch)]})


class RUMPLE_RestWrinkleTool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = TOOL
    bl_label = "Rest Wrinkles"
    bl_description = "Paint wrinkles that the cloth has at rest.\n\u2022 Ctrl erases.\n\u2022 Shift smooths"
    bl_icon = "brush.particle.comb"
    bl_cursor = "PAINT_BRUSH"
    bl_keymap = (_stroke("PAINT"), _stroke("ERASE", ctrl=True), _stroke("SMOOTH", shift=True),
                 _radial("radius"), _radial("strength", shift=True), _radial("angle", ctrl=True, alt=True))

    @staticmethod
    def draw_settings(context: bpy.types.Context, layout: bpy.types.UILayout, _tool: object) -> None:
        draw_brush(layout, context.scene.rumple_brush, brief=context.region.type == "TOOL_HEADER")

    @staticmethod
    def draw_cursor(context: bpy.types.Context, _tool: object, place: tuple[float, float]) -> None:
        brush_overlay.draw_cursor(context.scene.rumple_brush, place)


def draw_brush(layout: bpy.types.UILayout, brush: bpy.types.PropertyGroup, brief: bool = False) -> None:
    """The settings of the brush. brief: only those that fit into the viewport's header."""
    for name, pressure in (("radius", "pressure_radius"), ("strength", "pressure_strength")):
        row = layout.row(align=True)
        row.prop(brush, name)
        row.prop(brush, pressure, text="", icon="STYLUS_PRESSURE")
    layout.prop(brush, "length")
    layout.prop(brush, "direction")
    if brush.direction == "ANGLE":
        layout.prop(brush, "angle")
    layout.prop(brush, "run")
    layout.prop(brush, "mirror_x")
    if brief:
        return
    layout.prop(brush, "falloff")
    layout.prop(brush, "show_overlay")
    if brush.show_overlay:
        layout.prop(brush, "show_vectors")


CLASSES = (RUMPLE_Brush, OBJECT_OT_rumple_brush, OBJECT_OT_rumple_brush_stroke, OBJECT_OT_rumple_scatter,
           OBJECT_OT_rumple_clear_rest_wrinkles)


def _where_it_paints(context: bpy.types.Context | None) -> tuple:
    """The tool for the toolbar, which accepts functions instead of tools. Without a context, it asks for all possible
    tools."""
    obj = None if context is None else context.object
    nodes_mod = modifier.find(obj) if obj is not None and obj.type == "MESH" else None
    shown = context is None or (nodes_mod is not None and modifier.system(nodes_mod).method == "FIELD")
    return (RUMPLE_RestWrinkleTool._bl_tool,) if shown else ()


def _exchange(listed: object, other: object) -> None:
    """Replace an entry in the list of tools of Object Mode."""
    tools = bpy.types.VIEW3D_PT_tools_active._tools[RUMPLE_RestWrinkleTool.bl_context_mode]
    tools[tools.index(listed)] = other


@persistent
def _on_load(*_arguments: object) -> None:
    brush_canvas.forget()
    brush_overlay.forget()


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.rumple_brush = bpy.props.PointerProperty(type=RUMPLE_Brush)
    if not bpy.app.background:  # in the background there are no keymaps when Blender starts with the add-on enabled
        bpy.utils.register_tool(RUMPLE_RestWrinkleTool, after={"builtin.cursor"}, separator=True)
        _exchange(RUMPLE_RestWrinkleTool._bl_tool, _where_it_paints)
    bpy.app.handlers.load_post.append(_on_load)
    brush_overlay.register(TOOL)


def unregister() -> None:
    brush_overlay.unregister()
    bpy.app.handlers.load_post.remove(_on_load)
    if not bpy.app.background:
        _exchange(_where_it_paints, RUMPLE_RestWrinkleTool._bl_tool)
        bpy.utils.unregister_tool(RUMPLE_RestWrinkleTool)
    del bpy.types.Scene.rumple_brush
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    brush_canvas.forget()
