# SPDX-License-Identifier: GPL-3.0-or-later
"""Connects Blender's Online Manual with Rumple's guide, and draws the help button beside a message."""
from __future__ import annotations

import bpy

from ..core.settings import guide


def _map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """The map that Blender asks for: the base address, and for each property or operator the rest of the address."""
    return f"{guide.address()}#", guide.places() if guide.address() else ()


def draw_more(layout: bpy.types.UILayout, message: str) -> None:
    """Draw a button that opens the guide's section about a message, if there is one."""
    anchor = guide.place_of_message(message)
    if anchor and guide.address():
        layout.operator("wm.url_open", text="", icon="QUESTION", emboss=False).url = guide.address(anchor)


def register() -> None:
    bpy.utils.register_manual_map(_map)


def unregister() -> None:
    bpy.utils.unregister_manual_map(_map)
