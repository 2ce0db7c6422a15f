# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets a fabric. thumbnails.py has the pictures."""
from __future__ import annotations

import json
from typing import Any

import bpy

from ...core.settings.presets import Preset, touched
from .. import ui_base
from ..first_click.set_up import slack_of_cut
from ..objects import properties
from ..translation import said
from . import thumbnails


def _preset_items(_operator: bpy.types.Operator, context: bpy.types.Context | None) -> tuple:
    """The presets of the active object. Blender passes no context when it lists all operators."""
    return thumbnails.items_of(context.object if context is not None else None)


class OBJECT_OT_rumple_preset(ui_base.OnWrinkled, bpy.types.Operator):
    """Set the fabric: how wide, high and stiff folds are, and where they form. Rest shape and paint stay"""

    bl_idname = "object.rumple_preset"
    bl_label = "Fabric Preset"

    preset: bpy.props.EnumProperty(name="Fabric", items=_preset_items)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        system = properties.system_of(context.object)
        return ui_base.may_run(cls, "" if system.presets else f"The {said(system.label)} has no presets")

    def execute(self, context: bpy.types.Context) -> set[str]:
        use(context.object, context.scene, self.preset)
        return {"FINISHED"}


def use(obj: bpy.types.Object, scene: bpy.types.Scene, name: str) -> None:
    """Set the fabric, as the button does."""
    system, settings = properties.system_of(obj), properties.group_of(obj)
    chosen, former = system.presets[name], system.presets[settings.preset]
    restored, former_width = _taken_back(obj, former)
    now = {**vars(properties.settings_of(obj, scene)), **restored}
    properties.apply_values(obj, scene, {**restored, **properties.defaults(obj, touched(system.presets)),
                                         **slack_of_cut(obj, scene), **chosen.values, **chosen.replaced})
    replaced = {key: now[key] for key in chosen.replaced}
    settings.preset_replaced = json.dumps(replaced) if replaced else ""
    length = system.wrinkles.SUGGESTED
    scaled = {length: now[length] * chosen.fold_width / former_width}
    if "threshold" in now:
        scaled["threshold"] = 1.0 + (now["threshold"] - 1.0) * chosen.threshold / former.threshold
    # A float has seven digits, so switching back is exact.
    properties.apply_values(obj, scene, {key: float(f"{value:.7g}") for key, value in scaled.items()})
    settings.preset = name


def _taken_back(obj: bpy.types.Object, former: Preset) -> tuple[dict[str, Any], float]:
    """The settings to restore from before the former preset, and the former preset's factor on the width of folds."""
    settings = properties.group_of(obj)
    if settings.is_property_set("preset_replaced"):
        return json.loads(settings.preset_replaced or "{}"), former.fold_width
    # In files from before fabrics had weights, presets did not set base cloth and layers.
    replaced = former.replaced.keys() - {"base_cloth", "layers"}
    return properties.defaults(obj, replaced), former.old_fold_width or former.fold_width


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_rumple_preset,))
