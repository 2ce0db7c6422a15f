# SPDX-License-Identifier: GPL-3.0-or-later
"""Other objects that hold on to the points of a garment: bound to them, parented to them, instanced on them.

A fine mesh has other points than the mesh that they were bound to. Blender says nothing of it, or only in the modifier
of the other object.
"""
from __future__ import annotations

from typing import Iterator

import bpy

from . import runtimes

_TARGETS = {"SURFACE_DEFORM": "target", "MESH_DEFORM": "object"}  # modifiers that are bound, and what they are bound to

Bound = tuple[str, str]  # names of an object and of its modifier


def notes(garment: bpy.types.Object) -> list[str]:
    """Warnings about the first object of each kind. Only reads. It visits all objects."""
    runtime = runtimes.known(garment)
    lost = runtime.lost_bound if runtime is not None else []
    if lost:
        lost = [bound for bound in _bound_to(garment) if bound in lost]
    return _of_vertices(garment) + _of_instances(garment) + _of_bound(garment, lost)


def note_other_points(garment: bpy.types.Object) -> None:
    """Called when other points are shown: what is bound to the former ones must be bound again."""
    runtimes.of(garment).lost_bound = list(_bound_to(garment))


def note_updates(garment: bpy.types.Object, runtime: runtimes.Runtime) -> None:
    """Called after updates: what was unbound meanwhile can only be bound to the points that are shown now."""
    if runtime.lost_bound:
        runtime.lost_bound = [bound for bound in _bound_to(garment) if bound in runtime.lost_bound]


def after_removal(garment: bpy.types.Object) -> list[str]:
    """The same warning for a garment that loses its fine mesh."""
    evaluator = runtimes.of(garment).evaluator
    if evaluator is None or evaluator.vertex_count == evaluator.coarse_count:
        return []
    return _of_bound(garment, list(_bound_to(garment)))


def _bound_to(garment: bpy.types.Object) -> Iterator[Bound]:
    for obj in bpy.data.objects:
        for m in obj.modifiers:
            if m.type in _TARGETS and m.is_bound and getattr(m, _TARGETS[m.type]) == garment:
                yield obj.name, m.name


def _of_bound(garment: bpy.types.Object, bound: list[Bound]) -> list[str]:
    return [f"{garment.name}: the object \"{name}\" is bound to it by \"{modifier}\", and its vertices are other ones "
            "now: unbind that modifier, and bind it again" for name, modifier in bound][:1]


def _of_vertices(garment: bpy.types.Object) -> list[str]:
    """Children of vertices move to the garment's origin, because vertices that nodes make have no index in the mesh
    before."""
    return [f"{garment.name}: the object \"{child.name}\" is parented to vertices of it, which are other ones now: "
            "give it a Copy Location constraint with a vertex group in place of the parent"
            for child in bpy.data.objects
            if child.parent == garment and child.parent_type in ("VERTEX", "VERTEX_3")][:1]


def _of_instances(garment: bpy.types.Object) -> list[str]:
    if garment.instance_type not in ("VERTS", "FACES"):
        return []
    return [f"{garment.name}: the object \"{child.name}\" is instanced on its vertices or faces, of which the fine "
            "mesh has more: let another object without wrinkles be its parent"
            for child in bpy.data.objects if child.parent == garment][:1]
