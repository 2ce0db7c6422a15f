# SPDX-License-Identifier: GPL-3.0-or-later
"""Shortcuts for Weight Paint's gradient and sampling on wrinkled objects: see objects/weight_paint.py.

Blender's own shortcuts run the tools at once, but viewports must show the coarse mesh before that. So the same keys run
our operator.
"""
from __future__ import annotations

import bpy

from .. import ui_base
from ..objects import modifier, weight_paint

KEYMAP = "Weight Paint"
_TOOLS = (("SAMPLE", "Sample Weight", ""), ("SAMPLE_GROUP", "Sample Vertex Group", ""),
          ("LINEAR", "Linear Gradient", ""), ("RADIAL", "Radial Gradient", ""))

_keys: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


class OBJECT_OT_rumple_paint_tool(ui_base.OnWrinkled, bpy.types.Operator):
    """Sample, or draw a gradient, in Weight Paint: on the coarse mesh, whose weights they are"""

    bl_idname = "object.rumple_paint_tool"
    bl_label = "Weight Paint on the Coarse Mesh"
    bl_options = {"INTERNAL"}

    tool: bpy.props.EnumProperty(name="Tool", items=_TOOLS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Otherwise Blender's own operator runs."""
        return (super().poll(context) and context.object.mode == weight_paint.MODE
                and not weight_paint.needs_coarse(context.object))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        weight_paint.ask_for_coarse(True)
        self._obj = context.object.name
        context.object.update_tag()
        context.view_layer.update()
        try:
            result = self._run()
        except RuntimeError as error:  # for example, poll() fails because nothing is selected
            self.report({"WARNING"}, str(error))
            result = {"CANCELLED"}
        if "RUNNING_MODAL" in result:
            context.window_manager.modal_handler_add(self)
            return {"RUNNING_MODAL"}
        self._end()
        return result

    def _run(self) -> set[str]:
        if self.tool == "SAMPLE":
            return bpy.ops.paint.weight_sample("INVOKE_DEFAULT")
        if self.tool == "SAMPLE_GROUP":
            return bpy.ops.paint.weight_sample_group("INVOKE_DEFAULT")
        return bpy.ops.paint.weight_gradient("INVOKE_DEFAULT", type=self.tool)

    def modal(self, _context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """It is in front of the gradient, which consumes every event, and waits for its end."""
        if event.type in ("ESC", "RIGHTMOUSE", "RET") or (event.type, event.value) == ("LEFTMOUSE", "RELEASE"):
            self._end()
            return {"FINISHED", "PASS_THROUGH"}
        return {"PASS_THROUGH"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """Called when another file is opened, or the window is closed."""
        self._end()

    def _end(self) -> None:
        """Show the folds again, by a timer, because the ending tool still needs the coarse mesh."""
        weight_paint.ask_for_coarse(False)
        modifier.tag_soon(obj for obj in (bpy.data.objects.get(self._obj),) if obj is not None)


def _tool_of(item: bpy.types.KeyMapItem) -> str:
    """The tool of one of Blender's key map items, if it is one of ours; otherwise empty."""
    if item.idname == "paint.weight_gradient":
        return item.properties.type
    return {"paint.weight_sample": "SAMPLE", "paint.weight_sample_group": "SAMPLE_GROUP"}.get(item.idname, "")


def _add_keys() -> None:
    """Add the same keys as Blender's own, with priority over them."""
    configs = bpy.context.window_manager.keyconfigs
    own = configs.default.keymaps.get(KEYMAP)
    if own is None or configs.addon is None or _keys:
        return
    ours = configs.addon.keymaps.new(KEYMAP)
    for item in filter(_tool_of, own.keymap_items):
        key = ours.keymap_items.new(OBJECT_OT_rumple_paint_tool.bl_idname, item.type, item.value, shift=item.shift,
                                    ctrl=item.ctrl, alt=item.alt, oskey=item.oskey)
        key.properties.tool = _tool_of(item)
        _keys.append((ours, key))


_register, _unregister = bpy.utils.register_classes_factory((OBJECT_OT_rumple_paint_tool,))


def register() -> None:
    _register()
    if not bpy.app.background:  # Blender's own keys may be registered after the add-on
        bpy.app.timers.register(_add_keys, first_interval=0.1, persistent=True)


def unregister() -> None:
    if bpy.app.timers.is_registered(_add_keys):
        bpy.app.timers.unregister(_add_keys)
    for keymap, key in _keys:
        keymap.keymap_items.remove(key)
    _keys.clear()
    _unregister()
