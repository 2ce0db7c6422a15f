# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps Lock Interface on (menu Render) where handlers write folds into a render.

They do so in the thread of an F12 job. Without the lock the window may evaluate the same meshes at that moment, which
crashed Blender 4.3. The first click sets it in its own scene. But garments are linked and appended into other scenes,
and an artist may switch it off.
"""
from __future__ import annotations

import bpy

from . import compat
from .maps.modifier import mapped_objects
from .objects.modifier import is_baked, wrinkled_objects


def keep_on() -> None:
    """Called by a timer of the window while nothing renders. Cost: a microsecond for each scene; if one is not locked,
    also one for each modifier of the file."""
    unlocked = [scene for scene in bpy.data.scenes
                if compat.is_editable(scene) and not scene.render.use_lock_interface]
    if unlocked and _writes():
        for scene in unlocked:
            scene.render.use_lock_interface = True


def _writes() -> bool:
    """Whether a render may solve something: baked clips are played by Blender alone."""
    return any(not is_baked(nodes_mod) for _obj, nodes_mod in wrinkled_objects()) or any(mapped_objects())
