# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's attribute "rest_position", which hair curves on a garment and its materials read.

If an object has "Add Rest Position" on (adding hair curves switches it on), Blender stores the undeformed positions on
its mesh before the first modifier. The wrinkles replace that mesh, so the output objects need the attribute as well.
"""
from __future__ import annotations

from typing import Iterator

import bpy
import numpy as np

from ...core.base.triangles import Embedding, on_shown
from .. import compat
from ..nodes import wrinkle_tree
from . import incoming_mesh, modifier

NAME = "rest_position"


def is_outdated(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether the object was set to have the attribute, or not to have it, since the last carry()."""
    return any((NAME in mesh.attributes) != obj.add_rest_position_attribute for mesh in _to_fill(obj, nodes_mod))


def carry(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> None:
    """Write the attribute to the output objects, or remove it. This is structural work. A baked clip keeps its points:
    nothing else of the output objects changes."""
    for mesh in _to_fill(obj, nodes_mod):
        known = mesh.attributes.get(NAME)
        if not obj.add_rest_position_attribute:
            if known is not None:
                mesh.attributes.remove(known)
                compat.values_changed(mesh)
            continue
        values = _rest_positions(obj, mesh)
        if known is None or not np.array_equal(compat.read_attribute(known), values):
            compat.write_attribute(mesh, NAME, "FLOAT_VECTOR", "POINT", values)
            compat.values_changed(mesh)


def _to_fill(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> Iterator[bpy.types.Mesh]:
    """The meshes of the output objects. None if the incoming mesh has the attribute: it is carried like any other."""
    if NAME in incoming_mesh.of(obj).attributes or NAME in obj.data.attributes:
        return
    for output in modifier.outputs(nodes_mod):
        mesh = output.data
        if output.type == "MESH" and compat.is_editable(mesh) and wrinkle_tree.BARYCENTRIC in mesh.attributes:
            yield mesh


def _rest_positions(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> np.ndarray:
    """(n, 3) undeformed positions of the coarse mesh under the points of an output object's mesh."""
    corners = np.stack([compat.read_attribute(mesh.attributes[name])[:, 0] for name in wrinkle_tree.CORNERS], 1)
    weights = compat.read_attribute(mesh.attributes[wrinkle_tree.BARYCENTRIC])
    return on_shown(compat.positions(incoming_mesh.of(obj)), Embedding(corners, weights[:, :2]))
