# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface of a baked garment, for garments over it. It is read from the clip. The garment itself may still be
evaluated with live folds, in the frame in which its clip begins or goes on. Only reads, so any handler may call it."""
from __future__ import annotations

import bpy
import numpy as np

from .. import compat
from . import modifier


def of(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier,
       depsgraph: bpy.types.Depsgraph) -> tuple[bpy.types.Mesh, np.ndarray] | None:
    """The mesh and its positions in the frame of a depsgraph, of an object that plays its clip. None if something else
    is shown: the modifier is off, or others follow."""
    cache, output = modifier.cache_object(nodes_mod), modifier.output_object(nodes_mod)
    on = [m for m in obj.modifiers if modifier.is_on(m, depsgraph)]
    if cache is None or output is None or on[-1:] != [nodes_mod]:
        return None
    points = compat.positions(cache.evaluated_get(depsgraph).data)  # first those of the mesh, then its attributes
    count = len(output.data.vertices)
    return (output.data, np.ascontiguousarray(points[:count])) if len(points) >= count else None
