# SPDX-License-Identifier: GPL-3.0-or-later
"""Where keyed visibility hides a garment, Blender leaves its mesh as it was in the last frame that showed it, and says
that it is evaluated all the same."""
from __future__ import annotations

import bpy

from .. import compat
from . import bodies, modifier

HIDES = ("hide_viewport", "hide_render")


def is_skipped(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether a depsgraph has not the mesh of this frame: the object is hidden there, and nothing else needs it."""
    evaluated = obj.evaluated_get(depsgraph)
    hidden = evaluated.hide_render if depsgraph.mode == "RENDER" else evaluated.hide_viewport
    return hidden and is_keyed(obj) and not _is_needed(obj)


def is_keyed(obj: bpy.types.Object) -> bool:
    """Without keys or a driver an object that is hidden comes into a depsgraph only where another one needs it."""
    about = obj.animation_data
    if about is None:
        return False
    return (any(compat.find_curve(about, name) is not None or about.drivers.find(name) is not None for name in HIDES)
            or compat.has_strips(about))


def _is_needed(obj: bpy.types.Object) -> bool:
    """Whether it is worn under another one, or a modifier follows it."""
    return (any(obj in bodies.of(other) for other, _ours in modifier.wrinkled_objects())
            or any(modifier.depends_on(other, [obj]) is not None for other in bpy.data.objects if other != obj))
