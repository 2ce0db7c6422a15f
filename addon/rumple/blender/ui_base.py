# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators and panels have in common."""
from __future__ import annotations

import re
import unicodedata

import bpy

from . import compat, manual
from .frame import path_curves
from .objects import mesh_reader, modifier, properties
from .translation import said

LETTER_PIXELS = 8.0  # of a label, on average, with room for icon and margin
LABEL_SHARE = 0.4  # of a column, as Blender has it
NARROW = 22  # letters across: less, and names beside values would be cut off
WRINKLED = "This object has wrinkles already: press Remove in their panel first"
# Chinese and Japanese letters are twice as wide, and a line may break behind each, but not in front of a full stop.
_WORDS = re.compile("(?:[\u3040-\u9fff\uff00-\uffef][\u3001\u3002\uff01-\uff0f\uff1a-\uff1f\u300d\u30fc]*)|"
                    "[^\\s\u3040-\u9fff\uff00-\uffef]+|\\s+")


# ---------------------------------------------------------------- operators
def refusal(obj: bpy.types.Object | None, wrinkled: bool) -> str:
    """Why an operator cannot run on an object; empty when it can. wrinkled: it must have wrinkles already."""
    if obj is None or obj.type != "MESH":
        return "Choose a mesh object first"
    if not compat.is_editable(obj):
        return "This object is linked from another file: make a library override or append it"
    if not wrinkled and obj.override_library is not None and obj.override_library.is_system_override:
        return "This library override is not editable: make it so first (Outliner, Library Override)"
    if obj.mode == "EDIT":
        return "Leave Edit Mode first"
    if not wrinkled and mesh_reader.is_busy(obj):
        return "Leave Sculpt Mode first, or Edit Mode of another object with this mesh"
    if path_curves.find(obj) is not None:
        return "This object shows the paths of a garment: choose that one"
    found = modifier.find(obj) is not None
    if wrinkled and not found:
        return "This object has no wrinkles: add them first"
    if not wrinkled and found:
        return WRINKLED
    return ""


class OnWrinkled:
    """Operators for an object that has wrinkles."""

    bl_options = {"REGISTER", "UNDO"}
    method: str | None = None  # that they are for; None: all
    other_method = ""  # what to say of an object with another one

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        why = refusal(context.object, wrinkled=True)
        if not why and cls.method is not None and context.object.rumple.method != cls.method:
            why = cls.other_method
        if why:
            cls.poll_message_set(said(why))
        return not why


# ---------------------------------------------------------------- panels
class Panel:
    """A panel below DATA_PT_rumple."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "modifier"
    bl_parent_id = "DATA_PT_rumple"
    method: str | None = None  # that it belongs to; None: all

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        return obj is not None and obj.type == "MESH" and modifier.find(obj) is not None and (
            cls.method is None or obj.rumple.method == cls.method)


def property_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """Names on the left, values on the right."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout.column()


def settings_column(layout: bpy.types.UILayout, obj: bpy.types.Object) -> bpy.types.UILayout:
    """The same of settings that a bake was made with: greyed while it is shown."""
    column = property_column(layout)
    column.enabled = not modifier.is_baked(modifier.find(obj))
    return column


def draw_setting(column: bpy.types.UILayout, group: bpy.types.PropertyGroup, name: str) -> bpy.types.UILayout:
    """The row of one, for more to stand in; in a narrow editor its name stands above. A length is a slider, which moves
    by its width: of a number with a unit, Blender moves a whole millimetre or centimetre a pixel."""
    setting, words = group.bl_rna.properties[name], {}
    if is_narrow():
        column.label(text=setting.name)
        words["text"] = ""
    row = column.row(align=True)
    row.use_property_split = not words
    row.prop(group, name, slider=getattr(setting, "unit", "") == "LENGTH", **words)
    return row


def labelled_row(column: bpy.types.UILayout, label: str) -> bpy.types.UILayout:
    """A row behind a label, where a column of properties has its values: such a column cannot grey a part of a row."""
    split = column.split(factor=LABEL_SHARE)
    name = split.row()
    name.alignment = "RIGHT"
    name.label(text=label)
    return split.row(align=True)


def named_paint(column: bpy.types.UILayout, obj: bpy.types.Object, name: str, group: str) -> None:
    """The name of a vertex group or an attribute, and the button that paints the group."""
    settings = properties.group_of(obj)
    wanted = getattr(settings, name)
    exists = wanted in obj.vertex_groups
    row = labelled_row(column, settings.bl_rna.properties[name].name)
    field = row.row(align=True)
    field.active = exists or wanted in obj.data.attributes  # greyed: a name that nothing has yet
    field.prop(settings, name, text="")
    row.operator("object.rumple_paint", text="", icon="WPAINT_HLT" if exists else "BRUSH_DATA").group = group


def draw_message(layout: bpy.types.UILayout, text: str) -> None:
    """What is wrong, broken into lines that fit a narrow panel."""
    if not text:
        return
    box = layout.box()
    box.alert = True
    _draw_lines(box, text, "ERROR")


def draw_note(layout: bpy.types.UILayout, text: str, icon: str = "INFO") -> None:
    """The same, of what is not wrong."""
    _draw_lines(layout.column(align=True), text, icon)


def _draw_lines(column: bpy.types.UILayout, text: str, icon: str) -> None:
    for number, line in enumerate(wrapped(said(text))):
        row = column.row()
        row.label(text=line, icon=icon if number == 0 else "BLANK1", translate=False)
        if number == 0:
            manual.draw_more(row, text)


def wrapped(text: str) -> list[str]:
    """Lines that fit the region that is drawn: Blender's labels do not wrap."""
    width = max(24, letters_across())
    lines = [""]
    for word in _WORDS.findall(text):
        if lines[-1] and letters(lines[-1]) + letters(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]}{word}".lstrip()
    return [line.rstrip() for line in lines if line.strip()] or [""]


def letters_across() -> int:
    """How many letters fit beside one another in the region that is drawn."""
    region, scale = bpy.context.region, bpy.context.preferences.system.ui_scale
    return 60 if region is None else int(region.width / (LETTER_PIXELS * scale))


def is_narrow() -> bool:
    """Whether the region that is drawn has no room for names beside values."""
    return letters_across() < NARROW


def shortened(text: str, most: int) -> str:
    """At most so many letters: Blender draws the words of a header over its buttons."""
    if letters(text) <= most:
        return text
    kept = next((kept for kept in range(len(text), 0, -1) if letters(text[:kept]) < most), 0)
    return f"{text[:kept]}\u2026" if kept else ""


def letters(text: str) -> int:
    """How many Latin letters are as wide."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)
