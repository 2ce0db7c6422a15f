# SPDX-License-Identifier: GPL-3.0-or-later
"""Flags that the handlers set and the node tree reads: coordinates of the locations of hidden output objects.

The location of such an object has no other use. Moving it copies no mesh, and does not count as an edit in Blender. A
flag is one axis of one of the two objects. In files older than a flag, its axis is 0: it is not set.
"""
from __future__ import annotations

from enum import Enum

import bpy

from .. import compat

_SET = 1.0
THRESHOLD = 0.5  # a larger coordinate means that the flag is set, also in the tree


class Flag(Enum):
    """(which output object, axis of its location)."""

    COARSE_ONLY = "OUTPUT", 0  # the first pass of a frame shows the coarse mesh: frame/first_pass.py
    LIVE_FOLDS = "OUTPUT", 2  # instead of a damaged clip: objects/modifier.py
    RENDER_MESH = "VIEWPORT_OUTPUT", 0  # viewports show the mesh of renders: objects/viewport_mesh.py

    @property
    def axis(self) -> int:
        return self.value[1]


def is_set(obj: bpy.types.Object, flag: Flag) -> bool:
    """obj: the output object with the flag."""
    return obj.location[flag.axis] > THRESHOLD


def set_flag(obj: bpy.types.Object, flag: Flag, value: bool) -> bool:
    """Returns False if the flag must not be written: the object is linked, or the thread that ends a window's render
    job sets the frame."""
    if not compat.is_editable(obj):
        return False
    try:
        obj.location[flag.axis] = _SET if value else 0.0
    except AttributeError:
        return False
    return True


def change_flag(obj: bpy.types.Object, flag: Flag, value: bool) -> bool:
    """Set the flag only if it differs, because a write costs an evaluation. Returns whether it was changed."""
    return is_set(obj, flag) != value and set_flag(obj, flag, value)
