# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments hidden by keyed visibility. Blender does not update their mesh while they are hidden, but reports it as
evaluated."""
from __future__ import annotations

import bpy

from .. import compat
from . import bodies, modifier

HIDES = ("hide_viewport", "hide_render")


def is_skipped(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether a depsgraph does not have the mesh of this frame, because the object is hidden and not needed by
    others."""
    evaluated = obj.evaluated_get(depsgraph)
    hidden = evaluated.hide_render if depsgraph.mode == "RENDER" else evaluated.hide_viewport
    return hidden and is_keyed(obj) and not _is_needed(obj)


def is_keyed(obj: bpy.types.Object) -> bool:
    """Whether its visibility is animated. Otherwise a hidden object is in a depsgraph only if another object needs
    it."""
    about = obj.animation_data
    if about is None:
        return False
    return (any(compat.find_curve(about, name) is not None or about.drivers.find(name) is not None for name in HIDES)
            or compat.has_strips(about))


def _is_needed(obj: bpy.types.Object) -> bool:
    """Whether it is worn under another object, or a modifier depends on it."""
    return (any(obj in bodies.of(other) for other, _ours in modifier.wrinkled_objects())
            or any(modifier.depends_on(other, [obj]) is not None for other in bpy.data.objects if other != obj))
