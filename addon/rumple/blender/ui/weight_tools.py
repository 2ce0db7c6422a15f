# SPDX-License-Identifier: GPL-3.0-or-later
"""Shortcuts of Weight Paint's gradient and samples, on wrinkled objects: see objects/weight_paint.py.

Blender's own shortcuts, whatever they are, run the tools at once: viewports have to show the coarse mesh before that.
"""
from __future__ import annotations

import bpy

from .. import scheduler, ui_base
from ..objects import weight_paint

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
        """Else Blender's own is run."""
        return (super().poll(context) and context.object.mode == weight_paint.MODE
                and not weight_paint.needs_coarse(context.object))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        weight_paint.ask_for_coarse(True)
        self._obj = context.object.name
        context.object.update_tag()
        context.view_layer.update()
        try:
            result = self._run()
        except RuntimeError as error:  # its poll, say: nothing is selected
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
        """In front of the gradient, which gets every event, until it ends."""
        if event.type in ("ESC", "RIGHTMOUSE", "RET") or (event.type, event.value) == ("LEFTMOUSE", "RELEASE"):
            self._end()
            return {"FINISHED", "PASS_THROUGH"}
        return {"PASS_THROUGH"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """Another file, or the window is closed."""
        self._end()

    def _end(self) -> None:
        """The folds are shown again, by a timer: what ends now still looks at the coarse mesh."""
        weight_paint.ask_for_coarse(False)
        scheduler.tag_soon({self._obj})


def _tool_of(item: bpy.types.KeyMapItem) -> str:
    """What a key of Blender's runs, of ours; empty for others."""
    if item.idname == "paint.weight_gradient":
        return item.properties.type
    return {"paint.weight_sample": "SAMPLE", "paint.weight_sample_group": "SAMPLE_GROUP"}.get(item.idname, "")


def _add_keys() -> None:
    """Where Blender's own are, in front of them."""
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
    if not bpy.app.background:  # Blender's own keys may come after the add-on
        bpy.app.timers.register(_add_keys, first_interval=0.1, persistent=True)


def unregister() -> None:
    if bpy.app.timers.is_registered(_add_keys):
        bpy.app.timers.unregister(_add_keys)
    for keymap, key in _keys:
        keymap.keymap_items.remove(key)
    _keys.clear()
    _unregister()
