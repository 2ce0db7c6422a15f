# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways in which garments of other makers arrive broken. Each changes the mesh of an object in place and keeps what its
vertices have: weights, shape keys, UV maps. What is broken is chosen by number, always the same."""
from __future__ import annotations

from typing import Any, Callable

import bmesh
import bpy
import numpy as np
from mathutils import Vector

FLAP, SECOND = 0.015, 0.003  # metres: how far a flap stands off, and a second layer


def inner(work: Any, every: int) -> list[Any]:
    """Every so many of the edges with two faces."""
    return [edge for edge in work.edges if len(edge.link_faces) == 2][::every]


def apart(faces: Any) -> list[Any]:
    """As many of these faces as share no vertex."""
    taken, found = set(), []
    for face in faces:
        if taken.isdisjoint(face.verts):
            taken.update(face.verts)
            found.append(face)
    return found


def grown(work: Any, vertex: Any, offset: Any) -> Any:
    """A new vertex beside one, with its weights and keys."""
    made = bmesh.ops.duplicate(work, geom=[vertex])["geom"][0]
    made.co = vertex.co + offset
    for key in work.verts.layers.shape.values():
        made[key] = vertex[key] + offset
    return made


def turned(work: Any) -> None:
    """Patches whose normals look inwards."""
    bmesh.ops.reverse_faces(work, faces=[face for face in work.faces if face.index // 7 % 3 == 0])


def flaps(work: Any) -> None:
    """Edges with three faces, and some with four."""
    work.normal_update()
    for number, edge in enumerate(inner(work, 23)):
        for side in (1.0, -1.0) if number % 4 == 0 else (1.0,):
            offset = side * FLAP * (edge.verts[0].normal + edge.verts[1].normal).normalized()
            one, other = (grown(work, vertex, offset) for vertex in edge.verts)
            work.faces.new((edge.verts[0], edge.verts[1], other, one), edge.link_faces[0])


def doubled(work: Any) -> None:
    """Faces that lie on others: on the same vertices, every other one turned, and some three times."""
    for number, face in enumerate(list(work.faces)[::11]):
        for _ in range(2 if number % 5 == 0 else 1):
            copy = face.copy(verts=False, edges=False)
            if number % 2:
                copy.normal_flip()


def degenerate(work: Any) -> None:
    """Faces without an area: edges without a length, and faces that are a line."""
    for number, face in enumerate(apart(list(work.faces)[::9])):
        corners = list(face.verts)
        pairs = ((0, 1),) if number % 2 else ((0, 1), (2, 3))
        for one, other in pairs:
            if other < len(corners):
                moved(work, corners[one], corners[other])


def moved(work: Any, vertex: Any, to: Any) -> None:
    """Onto another, in every key."""
    vertex.co = to.co
    for key in work.verts.layers.shape.values():
        vertex[key] = to[key]


def holes(work: Any) -> None:
    """Faces that are missing, in places in a chequer, so that others touch at a vertex only."""
    faces = [face for face in work.faces if face.index % 29 == 0 or (face.index // 100 % 4 == 0 and face.index % 2)]
    bmesh.ops.delete(work, geom=faces, context="FACES_ONLY")


def wires(work: Any) -> None:
    """Edges and vertices without faces, on the cloth and beside it."""
    work.normal_update()
    for vertex in list(work.verts)[::37]:
        end = grown(work, vertex, 0.05 * vertex.normal)
        work.edges.new((vertex, end))
        grown(work, vertex, 0.08 * vertex.normal)


def second_layer(work: Any) -> None:
    """The whole garment again inside itself, turned, as thickness that was applied without a rim."""
    work.normal_update()
    normals = {vertex: vertex.normal.copy() for vertex in work.verts}
    copied = bmesh.ops.duplicate(work, geom=[*work.verts, *work.edges, *work.faces])
    for vertex, copy in copied["vert_map"].items():
        if vertex in normals:
            copy.co -= SECOND * normals[vertex]
            for key in work.verts.layers.shape.values():
                copy[key] -= SECOND * normals[vertex]
    bmesh.ops.reverse_faces(work, faces=[part for part in copied["geom"] if isinstance(part, bmesh.types.BMFace)])


def ngons(work: Any) -> None:
    """Faces of five corners and more, triangles between them, and three UV maps, of which one is empty."""
    dissolved: set[Any] = set()
    chosen = []
    for edge in inner(work, 3):
        if dissolved.isdisjoint(edge.link_faces):
            dissolved.update(edge.link_faces)
            chosen.append(edge)
    bmesh.ops.dissolve_edges(work, edges=chosen)
    bmesh.ops.triangulate(work, faces=[face for face in work.faces if len(face.verts) == 4][::2])
    layers = work.loops.layers.uv
    for name in ("Empty", "Islands"):
        layers.new(name)
    first, islands = layers[0], layers["Islands"]
    for face in work.faces:
        for loop in face.loops:
            loop[islands].uv = 2.0 * loop[first].uv + Vector((face.index % 2, 0.0))


def unmerged(work: Any) -> None:
    """No two faces share a vertex, as some programs export."""
    bmesh.ops.split_edges(work, edges=work.edges)


def everything(work: Any) -> None:
    """All at once, but for what is another garment then."""
    for way in (ngons, holes, turned, flaps, degenerate, wires, doubled):
        count(work)
        way(work)


def half(work: Any) -> None:
    """What has x above 0. Slivers stay where the middle is no row of vertices."""
    geometry = [*work.verts, *work.edges, *work.faces]
    bmesh.ops.bisect_plane(work, geom=geometry, plane_co=(0.0, 0.0, 0.0), plane_no=(1.0, 0.0, 0.0), clear_inner=True)


def count(work: Any) -> None:
    for elements in (work.verts, work.edges, work.faces):
        elements.index_update()
        elements.ensure_lookup_table()


def damage(obj: bpy.types.Object, way: Callable[[Any], None]) -> None:
    """Each face then has a number, in the attribute "number". A half gets a Mirror modifier in front."""
    work = bmesh.new()
    work.from_mesh(obj.data)
    count(work)
    way(work)
    work.to_mesh(obj.data)
    work.free()
    numbers = obj.data.attributes.new("number", "INT", "FACE")
    numbers.data.foreach_set("value", np.arange(len(obj.data.polygons), dtype=np.int32))
    obj.data.update()
    if way is half:
        mirror = obj.modifiers.new("Mirror", "MIRROR")
        with bpy.context.temp_override(object=obj):
            while obj.modifiers[0] != mirror:
                bpy.ops.object.modifier_move_up(modifier=mirror.name)
