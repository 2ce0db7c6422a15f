# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared base of operators and panels."""
from __future__ import annotations

import re
import unicodedata

import bpy

from . import compat, manual
from .frame import path_curves
from .objects import mesh_reader, modifier, properties
from .translation import said

LETTER_PIXELS = 8.0  # average width of a letter of a label, including icon and margin
LABEL_SHARE = 0.4  # share of a column's width, as in Blender
NARROW = 22  # letters per line: in narrower regions, names beside values would be cut off
LINKED_OBJECT = "This object is linked from another file: make a library override or append it"
LINKED_MESH = "This mesh is linked from another file: append it, or make it local"
WRINKLED = "This object has wrinkles already: press Remove in their panel first"
# Chinese and Japanese letters are twice as wide. A line may break after each of them, but not before a full stop.
_WORDS = re.compile("(?:[\u3040-\u9fff\uff00-\uffef][\u3001\u3002\uff01-\uff0f\uff1a-\uff1f\u300d\u30fc]*)|"
                    "[^\\s\u3040-\u9fff\uff00-\uffef]+|\\s+")


# ---------------------------------------------------------------- operators
def refusal(obj: bpy.types.Object | None, wrinkled: bool) -> str:
    """Why an operator cannot run on an object; empty if it can. wrinkled: it must already have wrinkles."""
    if obj is None or obj.type != "MESH":
        return "Choose a mesh object first"
    if not compat.is_editable(obj):
        return LINKED_OBJECT
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
    """Operators for an object with wrinkles."""

    bl_options = {"REGISTER", "UNDO"}
    method: str | None = None  # the required method; None: any
    other_method = ""  # the message for an object with another method

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        why = refusal(context.object, wrinkled=True)
        if not why and cls.method is not None and context.object.rumple.method != cls.method:
            why = cls.other_method
        return may_run(cls, why)


def may_run(operator: type, why: str) -> bool:
    """The answer of a poll(): whether there is no reason against it. A reason is shown in the button's tooltip."""
    if why:
        operator.poll_message_set(said(why))
    return not why


def refuse(operator: bpy.types.Operator, why: str | Exception) -> set[str]:
    """The result of an operator that could not do its work. The reason is reported."""
    operator.report({"ERROR"}, said(str(why)))
    return {"CANCELLED"}


def warn(operator: bpy.types.Operator, text: str) -> None:
    """Report a warning, unless it is empty."""
    if text:
        operator.report({"WARNING"}, said(text))


class ModalWork:
    """Operators that work between redraws. They show how far they are at the mouse and in the status bar."""

    _timer: bpy.types.Timer

    def begin_modal(self, context: bpy.types.Context, most: int, seconds: float) -> set[str]:
        """most: the number at which all is done. seconds: between two events of type TIMER."""
        manager = context.window_manager
        manager.progress_begin(0, most)
        self._timer = manager.event_timer_add(seconds, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def show_status(self, context: bpy.types.Context, text: str) -> None:
        if context.workspace is not None:
            context.workspace.status_text_set(text)

    def end_modal(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        for workspace in bpy.data.workspaces:  # the artist may have changed to another one
            workspace.status_text_set(None)


# ---------------------------------------------------------------- panels
class Panel:
    """A panel below DATA_PT_rumple."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "modifier"
    bl_parent_id = "DATA_PT_rumple"
    method: str | None = None  # the method that it belongs to; None: all

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.object
        return obj is not None and obj.type == "MESH" and modifier.find(obj) is not None and (
            cls.method is None or obj.rumple.method == cls.method)


def property_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """A column with names on the left and values on the right."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout.column()


def settings_column(layout: bpy.types.UILayout, obj: bpy.types.Object) -> bpy.types.UILayout:
    """The same, for settings that a bake depends on. It is greyed out while the bake is shown."""
    column = property_column(layout)
    column.enabled = not modifier.is_baked(modifier.find(obj))
    return column


def draw_setting(column: bpy.types.UILayout, group: bpy.types.PropertyGroup, name: str) -> bpy.types.UILayout:
    """Draw a setting, and return its row, to which more can be added. In a narrow editor the name is above. A length is
    drawn as a slider, because it moves by its width. A number with a unit would move by a whole millimetre or
    centimetre per pixel."""
    setting, words = group.bl_rna.properties[name], {}
    if is_narrow():
        column.label(text=setting.name)
        words["text"] = ""
    row = column.row(align=True)
    row.use_property_split = not words
    row.prop(group, name, slider=getattr(setting, "unit", "") == "LENGTH", **words)
    return row


def labelled_row(column: bpy.types.UILayout, label: str) -> bpy.types.UILayout:
    """A row with a label, aligned with a column of properties. Such a column itself cannot grey out a part of a row."""
    split = column.split(factor=LABEL_SHARE)
    name = split.row()
    name.alignment = "RIGHT"
    name.label(text=label)
    return split.row(align=True)


def named_paint(column: bpy.types.UILayout, obj: bpy.types.Object, name: str, group: str) -> None:
    """Draw the name of a vertex group or an attribute, and the button that paints the group."""
    settings = properties.group_of(obj)
    wanted = getattr(settings, name)
    exists = wanted in obj.vertex_groups
    row = labelled_row(column, settings.bl_rna.properties[name].name)
    field = row.row(align=True)
    field.active = exists or wanted in obj.data.attributes  # greyed out if nothing has this name
    field.prop(settings, name, text="")
    row.operator("object.rumple_paint", text="", icon="WPAINT_HLT" if exists else "BRUSH_DATA").group = group


def draw_message(layout: bpy.types.UILayout, text: str) -> None:
    """Draw an error message, in lines that fit a narrow panel."""
    if not text:
        return
    box = layout.box()
    box.alert = True
    _draw_lines(box, text, "ERROR")


def draw_note(layout: bpy.types.UILayout, text: str, icon: str = "INFO") -> None:
    """The same for a message that is not an error."""
    _draw_lines(layout.column(align=True), text, icon)


def _draw_lines(column: bpy.types.UILayout, text: str, icon: str) -> None:
    for number, line in enumerate(wrapped(said(text))):
        row = column.row()
        row.label(text=line, icon=icon if number == 0 else "BLANK1", translate=False)
        if number == 0:
            manual.draw_more(row, text)


def wrapped(text: str) -> list[str]:
    """Lines that fit the region being drawn, because Blender's labels do not wrap."""
    width = max(24, letters_across())
    lines = [""]
    for word in _WORDS.findall(text):
        if lines[-1] and letters(lines[-1]) + letters(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]}{word}".lstrip()
    return [line.rstrip() for line in lines if line.strip()] or [""]


def letters_across() -> int:
    """The number of letters per line in the region being drawn."""
    region, scale = bpy.context.region, bpy.context.preferences.system.ui_scale
    return 60 if region is None else int(region.width / (LETTER_PIXELS * scale))


def is_narrow() -> bool:
    """Whether the region being drawn is too narrow for names beside values."""
    return letters_across() < NARROW


def shortened(text: str, most: int) -> str:
    """The text, cut to this number of letters, because Blender draws the text of a header over its buttons."""
    if letters(text) <= most:
        return text
    kept = next((kept for kept in range(len(text), 0, -1) if letters(text[:kept]) < most), 0)
    return f"{text[:kept]}\u2026" if kept else ""


def letters(text: str) -> int:
    """The width of a text in Latin letters."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)
