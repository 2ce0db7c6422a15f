# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that share a mesh: linked duplicates (Alt D). A captured rest shape and paint are data of the mesh, so they
change on all of them."""
from __future__ import annotations

import bpy

from . import incoming_mesh, modifier, properties


def note(obj: bpy.types.Object) -> str:
    """A sentence after something was painted on an object: on which wrinkled objects it changes as well. Empty if on
    none."""
    return _sentence(obj, [other for other, _ours in modifier.wrinkled_objects()
                           if other != obj and other.data == obj.data])


def note_of_capture(obj: bpy.types.Object) -> str:
    """The same after a rest shape was captured: it counts where the rest shape is a captured one."""
    mesh = incoming_mesh.of(obj)
    return _sentence(obj, [other for other, _ours in modifier.wrinkled_objects()
                           if other != obj and incoming_mesh.of(other) == mesh
                           and properties.group_of(other).rest_shape == "FRAME"])


def _sentence(obj: bpy.types.Object, others: list[bpy.types.Object]) -> str:
    if not others:
        return ""
    names = ", ".join(other.name for other in others)
    return (f"{obj.name}: its mesh is also that of {names}, so this changes there too: Object > Relations > Make "
            "Single User gives it a mesh of its own")
