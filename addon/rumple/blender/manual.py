# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Online Manual for what is ours, and the button beside a message that opens the guide."""
from __future__ import annotations

import bpy

from ..core import guide


def _map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """What Blender asks for: the address before, and what comes after it by a property's or operator's name."""
    return f"{guide.address()}#", guide.places() if guide.address() else ()


def draw_more(layout: bpy.types.UILayout, message: str) -> None:
    """A button that opens the guide where it says what to do about a message; none where it says nothing."""
    anchor = guide.place_of_message(message)
    if anchor and guide.address():
        layout.operator("wm.url_open", text="", icon="QUESTION", emboss=False).url = guide.address(anchor)


def register() -> None:
    bpy.utils.register_manual_map(_map)


def unregister() -> None:
    bpy.utils.unregister_manual_map(_map)
