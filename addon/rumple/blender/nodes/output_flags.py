# SPDX-License-Identifier: GPL-3.0-or-later
"""Flags that the handlers set and the node tree reads: coordinates of the hidden output objects.

The place of such an object means nothing else, moving it copies no mesh, and Blender does not take it for an edit. A
flag is one axis of one of the two objects. In files that are older than a flag its axis is 0: it is not set.
"""
from __future__ import annotations

from enum import Enum

import bpy

from .. import compat

_SET = 1.0
THRESHOLD = 0.5  # above it a flag is set, here and in the tree


class Flag(Enum):
    """(which output object, axis of its place)."""

    COARSE_ONLY = "OUTPUT", 0  # the first pass of a frame hands on the coarse mesh: frame/first_pass.py
    LIVE_FOLDS = "OUTPUT", 2  # in place of a clip that is damaged: objects/modifier.py
    RENDER_MESH = "VIEWPORT_OUTPUT", 0  # viewports show the mesh of renders: objects/viewport_mesh.py

    @property
    def axis(self) -> int:
        return self.value[1]


def is_set(obj: bpy.types.Object, flag: Flag) -> bool:
    """obj: the output object that has the flag."""
    return obj.location[flag.axis] > THRESHOLD


def set_flag(obj: bpy.types.Object, flag: Flag, value: bool) -> bool:
    """False where nobody may write: it is linked, or the thread that ends a render job of a window sets the frame."""
    if not compat.is_editable(obj):
        return False
    try:
        obj.location[flag.axis] = _SET if value else 0.0
    except AttributeError:
        return False
    return True


def change_flag(obj: bpy.types.Object, flag: Flag, value: bool) -> bool:
    """The same where it is another one now; a write costs an evaluation. Whether it was changed."""
    return is_set(obj, flag) != value and set_flag(obj, flag, value)
