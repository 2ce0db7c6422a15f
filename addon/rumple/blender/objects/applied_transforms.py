# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps vectors correct when an artist applies scale, rotation or location (Ctrl A), or rotates the mesh in Edit Mode.
Blender then moves the vertices, but does not change vector attributes. A captured rest shape would keep its former
size, and painted waves would have another direction.

So the undeformed positions that these vectors belong to are stored in another attribute. If one affine map has moved
most vertices since, it is applied to the vectors too. Up At Rest is a vector of the object. For it, a few of the
positions are stored with the object.
"""
from __future__ import annotations

import bpy
import numpy as np

from ...core import transforms
from ...core.cloth_settings import direction_of, nearest_up
from ...core.systems import SYSTEMS
from .. import compat
from ..nodes.wrinkle_tree import REST_BASIS, REST_POSITION
from . import incoming_mesh, mesh_reader, properties

GOLDEN_RATIO = 0.6180339887


def follow(obj: bpy.types.Object) -> None:
    """Update the vectors of an object's meshes. This is structural work, because it writes attributes."""
    for mesh in {obj.data, incoming_mesh.of(obj)}:
        if compat.is_editable(mesh) and not mesh.is_editmode:
            _follow(mesh)
    if compat.is_editable(obj) and not obj.data.is_editmode:
        _follow_up(obj)


def _follow_up(obj: bpy.types.Object) -> None:
    places = mesh_reader.basis_positions(obj.data)
    if not len(places):
        return
    spread = np.arange(properties.UP_PLACES) * GOLDEN_RATIO % 1.0  # spread over the mesh; not all on one line of a grid
    some = places[(spread * len(places)).astype(np.int64)]
    now = np.append(some.ravel(), np.float32(len(places)))
    before = np.array(obj.rumple.up_places, np.float32)
    if np.array_equal(before, now):
        return
    applied = transforms.affine_between(before[:-1].reshape(-1, 3), some) if before[-1] == now[-1] else None
    for system in SYSTEMS.values() if applied is not None else ():
        group = getattr(obj.rumple, system.group)
        if group.is_property_set("up") or system.method == obj.rumple.method:
            group.up = nearest_up(transforms.turned_one(applied[:, :3], direction_of(group.up)))
    obj.rumple.up_places = now


def _is_vector(attribute: bpy.types.Attribute | None) -> bool:
    return attribute is not None and (attribute.data_type, attribute.domain) == ("FLOAT_VECTOR", "POINT")


def _follow(mesh: bpy.types.Mesh) -> None:
    vectors = [name for name in (REST_POSITION, mesh_reader.REST_WRINKLE) if _is_vector(mesh.attributes.get(name))]
    known = mesh.attributes.get(REST_BASIS)
    if not vectors:
        if known is not None:
            mesh.attributes.remove(known)
        return
    before, now = None if known is None else compat.read_attribute(known), mesh_reader.basis_positions(mesh)
    if before is not None and np.array_equal(before, now):
        return
    applied = None if before is None else transforms.affine_between(before, now)
    for name in vectors if applied is not None else ():
        values = compat.read_attribute(mesh.attributes[name])
        moved = transforms.placed(applied, values) if name == REST_POSITION else transforms.redirected(applied, values)
        compat.write_attribute(mesh, name, "FLOAT_VECTOR", "POINT", moved)
    compat.write_attribute(mesh, REST_BASIS, "FLOAT_VECTOR", "POINT", now)
    mesh.update()
