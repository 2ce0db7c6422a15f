# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the fabrics and systems, as Blender's own preview icons: in their menus, and large in the panel.

docs/pictures/make_thumbnails.py renders them into thumbnails/. If one is missing or cannot be read, the menu shows only
text.
"""
from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import bpy
import bpy.utils.previews

from ...core.systems.all_systems import SYSTEMS
from ..objects import modifier, properties
from ..translation import said

FOLDER = Path(os.path.abspath(__file__)).parents[2] / "thumbnails"
CHOICE = "rumple_fabric"  # property of the window manager, because it is not saved in files
SCALE, SCALE_IN_POPUP, SCALE_IN_MENU = 2.5, 5.0, 3.0
OF_SYSTEMS = {"MESH": "COTTON", "PATHS": "COTTON"}  # preset whose picture is used for a system with presets

_pictures: Any = None  # bpy.utils.previews.ImagePreviewCollection
_items: dict[str, tuple] = {}  # Blender keeps no copy


def path(method: str, preset: str = "") -> Path:
    """The picture of a preset, or of a system without presets."""
    return FOLDER / (f"{method}_{preset}.png" if preset else f"{method}.png")


def icon(method: str, preset: str = "") -> int:
    """The number of its icon; 0 if there is no picture."""
    global _pictures
    file = path(method, preset)
    if not file.is_file():
        return 0
    if _pictures is None:
        _pictures = bpy.utils.previews.new()
    try:
        return (_pictures.get(file.stem) or _pictures.load(file.stem, str(file), "IMAGE")).icon_id
    except (KeyError, RuntimeError, OSError):
        return 0


def items(method: str) -> tuple[tuple[str, str, str, int, int], ...]:
    """The presets of a system for an enum, with their icons."""
    if method not in _items:
        _items[method] = tuple((key, preset.label, preset.tip, icon(method, key), preset.number)
                               for key, preset in SYSTEMS[method].presets.items())
    return _items[method]


def items_of(obj: bpy.types.Object | None) -> tuple:
    """The same for the system of an object."""
    return items(properties.system_of(obj).method if obj is not None and modifier.find(obj) is not None else "MESH")


def _context_items(_owner: Any, context: bpy.types.Context | None) -> tuple:
    """Blender passes no context when it lists all properties."""
    return items_of(context.object if context is not None else None)


def _chosen(_owner: Any) -> int:
    obj = bpy.context.object
    if obj is None or modifier.find(obj) is None:
        return 0
    settings, presets = properties.group_of(obj), properties.system_of(obj).presets
    return presets[settings.preset].number if presets else 0


def _choose(_owner: Any, number: int) -> None:
    """Choose a fabric as the menu does, with an undo step."""
    obj = bpy.context.object
    presets = properties.system_of(obj).presets if obj is not None and modifier.find(obj) is not None else {}
    for key, preset in presets.items():
        if preset.number == number and bpy.ops.object.rumple_preset.poll():
            bpy.ops.object.rumple_preset("EXEC_DEFAULT", True, preset=key)


def draw(layout: bpy.types.UILayout, obj: bpy.types.Object, icon_of_system: str) -> None:
    """Draw the menu of fabrics, beside the picture of the last chosen one. A click on the picture shows all
    pictures."""
    system = properties.system_of(obj)
    key = properties.group_of(obj).preset
    row = layout.row()
    if icon(system.method, key):
        row.template_icon_view(bpy.context.window_manager, CHOICE, show_labels=True, scale=SCALE,
                               scale_popup=SCALE_IN_POPUP)
        row = row.column()
    row.operator_menu_enum("object.rumple_preset", "preset", icon=icon_of_system, text=said(system.presets[key].label))


def beside_pictures(layout: bpy.types.UILayout, methods: list[str]) -> bpy.types.UILayout:
    """For a menu: a column of pictures of systems, and beside it a column for their entries of the same height."""
    icons = [icon(method, OF_SYSTEMS.get(method, "")) for method in methods]
    if not all(icons):
        return layout
    row = layout.row()  # only one, because menus misalign separate rows
    pictures, entries = row.column(), row.column()
    for number in icons:
        pictures.template_icon(icon_value=number, scale=SCALE_IN_MENU)
    entries.scale_y = SCALE_IN_MENU
    return entries


def register() -> None:
    setattr(bpy.types.WindowManager, CHOICE, bpy.props.EnumProperty(
        name="Fabric", items=_context_items, get=_chosen, set=_choose, options={"SKIP_SAVE"},
        description="The fabric that was chosen last"))


def unregister() -> None:
    global _pictures
    delattr(bpy.types.WindowManager, CHOICE)
    _items.clear()
    if _pictures is not None:
        bpy.utils.previews.remove(_pictures)
        _pictures = None
