# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps vectors correct when an artist applies scale, rotation or location (Ctrl A), joins objects (Ctrl J), or rotates
the mesh in Edit Mode. Blender then moves the vertices, but does not change vector attributes. A captured rest shape
would keep its former size, and painted waves would have another direction.

So the undeformed positions that these vectors belong to are stored in another attribute. If one affine map has moved
most vertices since, or those of a loose part, it is applied to the vectors too. Up At Rest is a vector of the object.
For it, a few of the positions are stored with the object.
"""
from __future__ import annotations

import bpy
import numpy as np

from ...core.base import transforms
from ...core.mesh.connected import lowest_connected
from ...core.settings.cloth_settings import direction_of, nearest_up
from ...core.systems.all_systems import SYSTEMS
from .. import compat
from ..nodes.wrinkle_tree import REST_BASIS, REST_POSITION
from . import incoming_mesh, mesh_reader, properties

LEAST = 4  # vertices of a part that show how it was moved
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
    if applied is not None:
        obj.rumple.figure *= abs(transforms.determinant(applied[:, :3])) ** (1.0 / 3.0)
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
    added = _added(mesh, before)
    maps = [] if before is None else _maps(mesh, before, now, np.flatnonzero(~added))
    for name in vectors:
        values = compat.read_attribute(mesh.attributes[name])
        move = transforms.placed if name == REST_POSITION else transforms.redirected
        for rows, applied in maps:
            values[rows] = move(applied, values[rows])
        if name == REST_POSITION:
            values[added] = now[added]
        if maps or added.any():
            compat.write_attribute(mesh, name, "FLOAT_VECTOR", "POINT", values)
    compat.write_attribute(mesh, REST_BASIS, "FLOAT_VECTOR", "POINT", now)
    mesh.update()


def _added(mesh: bpy.types.Mesh, before: np.ndarray | None) -> np.ndarray:
    """(n,) bool: the vertices without a captured rest shape. They were joined, or added in Edit Mode, and Blender has
    set both of their vectors to zero: their rest shape is the undeformed one."""
    captured = mesh.attributes.get(REST_POSITION)
    if before is None or not _is_vector(captured):
        return np.zeros(len(mesh.vertices), bool)
    return ~(before.any(axis=1) | compat.read_attribute(captured).any(axis=1))


def _maps(mesh: bpy.types.Mesh, before: np.ndarray, now: np.ndarray,
          rows: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Which affine map has moved which of these vertices. Usually one has moved all. But Join has moved the parts of
    the other object only."""
    applied = transforms.affine_between(before[rows], now[rows])
    moved = before if applied is None else transforms.placed(applied, before)
    fits = np.abs(moved - now).max(axis=1) <= _tolerance(now)
    parts = [] if fits[rows].all() else _loose_parts(mesh, rows)
    if len(parts) < 2:
        return [] if applied is None else [(rows, applied)]
    found = []
    for part in parts:
        own = applied
        if len(part) >= LEAST and not fits[part].all():
            if np.abs(before[part] - now[part]).max() <= _tolerance(now):
                continue  # it was not moved
            of_part = transforms.affine_between(before[part], now[part])
            own = applied if of_part is None else of_part  # none: it was also edited
        if own is not None:
            found.append((part, own))
    return found


def _tolerance(places: np.ndarray) -> float:
    """How far from its place a vertex may be that a map has moved."""
    return float(transforms.FITTING * np.sqrt((np.ptp(places, axis=0) ** 2).sum()))


def _loose_parts(mesh: bpy.types.Mesh, rows: np.ndarray) -> list[np.ndarray]:
    """These vertices, by the connected part that they are in."""
    first, other = compat.edge_vertices(mesh).T
    label = lowest_connected(np.arange(len(mesh.vertices)), first, other)[rows]
    order = np.argsort(label, kind="stable")
    return np.split(rows[order], np.flatnonzero(np.diff(label[order])) + 1)
