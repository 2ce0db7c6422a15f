# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's own presets: the settings of one object under a name. They are files in Blender's preset folder, so they
can be shared.

Lengths are stored in metres, so that a preset has the same meaning in scenes of any unit.
"""
from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .. import ui_base
from ..objects import properties
from ..translation import said
from .copy_settings import OWN

_FILE = '''# Settings of a {label} of Rumple. Lengths are metres.
import bpy

bpy.ops.object.rumple_use_settings(method="{method}", values=r"""
{values}
""")
'''


def values_of(obj: bpy.types.Object, scene: bpy.types.Scene) -> dict[str, Any]:
    """The settings of an object that belong to its cloth, not to its mesh: by name, in metres and plain numbers."""
    settings = properties.settings_of(obj, scene)
    return {name: getattr(settings, name) for name in properties.fields_of(obj) if name not in OWN}


def checked(obj: bpy.types.Object, text: str) -> tuple[dict[str, Any], list[str]]:
    """The values from JSON that are valid for the object's system, and the names of the others. Raises ValueError."""
    given = json.loads(text)
    if not isinstance(given, dict):
        raise ValueError("these are no settings")
    known, fields, refused = {}, properties.fields_of(obj), []
    for name, value in given.items():
        default = fields[name].default if name in fields and name not in OWN else None
        choices = [item[0] for item in fields[name].metadata["choices"] or ()] if default is not None else []
        if isinstance(default, float) and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if (type(value) is not type(default) or (choices and value not in choices)
                or (isinstance(value, float) and not math.isfinite(value))):
            refused.append(name)
        else:
            known[name] = value
    return known, refused


class _OfSystem:
    """Each system has a folder of presets."""

    @property
    def preset_subdir(self) -> str:
        """The attribute that Blender's preset classes read."""
        return f"rumple_{bpy.context.object.rumple.method.lower()}"


class DATA_PT_rumple_saved_settings(_OfSystem, PresetPanel, bpy.types.Panel):
    bl_label = "Settings of Wrinkles"
    preset_operator = "script.execute_preset"
    preset_add_operator = "object.rumple_save_settings"


class OBJECT_OT_rumple_save_settings(_OfSystem, AddPresetBase, bpy.types.Operator):
    """Keep these settings under a name, for other objects and files. Paint, bodies and rest shape are not among them"""

    bl_idname = "object.rumple_save_settings"
    bl_label = "Save Settings of Wrinkles"
    preset_menu = "DATA_PT_rumple_saved_settings"

    def add(self, context: bpy.types.Context, filepath: str) -> None:
        """Write the file. Called by AddPresetBase."""
        system = properties.system_of(context.object)
        values = json.dumps(values_of(context.object, context.scene), indent=1)
        Path(filepath).write_text(_FILE.format(label=system.label, method=system.method, values=values),
                                  encoding="utf-8")


class OBJECT_OT_rumple_use_settings(ui_base.OnWrinkled, bpy.types.Operator):
    """Take settings from text: what saved presets call"""

    bl_idname = "object.rumple_use_settings"
    bl_label = "Use Settings of Wrinkles"
    bl_options = {"INTERNAL"}

    method: bpy.props.StringProperty()
    values: bpy.props.StringProperty()

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        if self.method != obj.rumple.method:
            return ui_base.refuse(self, f"{obj.name}: these settings are not of a {properties.system_of(obj).label}")
        try:
            known, refused = checked(obj, self.values)
        except ValueError as error:
            return ui_base.refuse(self, f"{obj.name}: this preset cannot be read: {error}")
        properties.apply_values(obj, context.scene, known)
        bpy.ops.ed.undo_push(message=self.bl_label)  # operators called by a preset file make no undo step themselves
        if refused:
            self.report({"WARNING"}, said(f"{obj.name}: not known here, and left as they were: {', '.join(refused)}"))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (DATA_PT_rumple_saved_settings, OBJECT_OT_rumple_save_settings, OBJECT_OT_rumple_use_settings))
