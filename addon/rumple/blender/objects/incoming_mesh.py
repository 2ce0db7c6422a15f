# SPDX-License-Identifier: GPL-3.0-or-later
"""The coarse mesh as it arrives at the wrinkles, undeformed.

This is the object's mesh if no modifier in front changes the number of points. With such modifiers (Mirror, Solidify,
Subdivision, nodes, ...) it is a separate mesh, made by these modifiers at rest and stored with the object. All data of
the coarse mesh (faces, UV maps, groups, attributes, rest shape) is read from this mesh.
"""
from __future__ import annotations

import hashlib
from contextlib import contextmanager
from typing import Any, Iterable, Iterator

import bpy
import numpy as np

from .. import compat, scheduler
from ..nodes import wrinkle_tree
from . import modifier

SUFFIX = ".incoming"
_CAPTURED = (wrinkle_tree.REST_POSITION, wrinkle_tree.REST_BASIS)


_mirrored: dict[bpy.types.Object, bpy.types.Mesh] = {}  # only inside whole()


def of(obj: bpy.types.Object) -> bpy.types.Mesh:
    """The current incoming mesh; see update()."""
    kept = obj.rumple.incoming
    return _mirrored.get(obj, obj.data) if kept is None else kept


def is_own(obj: bpy.types.Object) -> bool:
    """Whether the incoming mesh is the object's own mesh. Then selection and paint on it can be used directly."""
    return obj.rumple.incoming is None


def update(obj: bpy.types.Object) -> None:
    """Make, replace or remove the separate mesh. This is structural work, because it makes and removes data-blocks."""
    if not compat.is_editable(obj):
        return
    kept, made = obj.rumple.incoming, None
    if modifier.topology_changer_before(obj) is not None:
        made = _evaluated_at_rest(obj)
        if _same_faces(made, obj.data):  # for example, a node group that only moves points
            bpy.data.meshes.remove(made)
            made = None
    if made is not None and kept is not None and kept.users == 1 and _content(made) == _content(kept):
        bpy.data.meshes.remove(made)
        return
    if made is not None:
        _keep_captured(kept if kept is not None else obj.rumple.captured, made)
    obj.rumple.incoming = made
    if made is None and kept is not None and wrinkle_tree.REST_POSITION in kept.attributes:
        obj.rumple.captured, kept = kept, obj.rumple.captured  # keep it, because the modifier may come back
    drop(kept)


@contextmanager
def whole(objects: Iterable[bpy.types.Object]) -> Iterator[None]:
    """Inside this context, of() has both halves of a body that was modelled as one half with a Mirror modifier,
    wherever this is in the stack. This is structural work. Cost: some evaluations of each such body."""
    made = []
    try:
        for obj in objects:
            if obj.type == "MESH" and obj.rumple.incoming is None and obj not in _mirrored and any(
                    m.type == "MIRROR" and m.show_viewport for m in obj.modifiers):
                _mirrored[obj] = _evaluated_at_rest(obj, mirrored=True)
                made.append(obj)
        yield
    finally:
        for obj in made:
            bpy.data.meshes.remove(_mirrored.pop(obj))


def forget(obj: bpy.types.Object) -> None:
    """Called when the wrinkles were removed."""
    for name in ("incoming", "captured"):
        mesh = getattr(obj.rumple, name)
        if mesh is not None:
            setattr(obj.rumple, name, None)
            drop(mesh)


def drop(mesh: bpy.types.Mesh | None) -> None:
    """Remove a stored mesh without users."""
    if mesh is not None and mesh.users == 0 and compat.is_editable(mesh):
        bpy.data.meshes.remove(mesh)


def _keep_captured(former: bpy.types.Mesh | None, mesh: bpy.types.Mesh) -> None:
    """Copy a captured rest shape if it still fits."""
    if former is None or len(former.vertices) != len(mesh.vertices):
        return
    for name in _CAPTURED:
        if name in former.attributes:
            compat.write_attribute(mesh, name, "FLOAT_VECTOR", "POINT", compat.read_attribute(former.attributes[name]))


def _faces(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """The vertices of all corners, and how many corners each face has."""
    return compat.corner_vertices(mesh), compat.indices(mesh.polygons, "loop_total")


def _same_faces(one: bpy.types.Mesh, other: bpy.types.Mesh) -> bool:
    return len(one.vertices) == len(other.vertices) and all(map(np.array_equal, _faces(one), _faces(other)))


def _content(mesh: bpy.types.Mesh) -> str:
    """Hash of faces, positions, groups and attributes, without the captured ones."""
    digest = hashlib.sha1()
    for values in (compat.positions(mesh), *_faces(mesh)):
        digest.update(values.tobytes())
    for attribute in mesh.attributes:
        if (attribute.data_type in compat.ATTRIBUTE_LAYOUT and not attribute.name.startswith(".")
                and attribute.name not in _CAPTURED):
            digest.update(attribute.name.encode() + compat.read_attribute(attribute).tobytes())
    for layer in mesh.uv_layers:
        digest.update(layer.name.encode() + compat.uv_values(layer).tobytes())
    for prop, values in compat.edge_marks(mesh).items():  # in 3.4 these are not attributes
        digest.update(prop.encode() + values.tobytes())
    digest.update(repr([[(group.group, group.weight) for group in vertex.groups] for vertex in mesh.vertices]).encode())
    return digest.hexdigest()


# ---------------------------------------------------------------- at rest
def _evaluated_at_rest(obj: bpy.types.Object, mirrored: bool = False) -> bpy.types.Mesh:
    """A new mesh: the result of the non-deforming modifiers in front for the rest shape. A node group counts as
    deforming if the faces are the same without it. mirrored: also apply a Mirror behind."""
    with _bare_copy(obj, mirrored) as bare:
        mesh = _evaluated(bare)
        for nodes_mod in [m for m in bare.modifiers if m.type == "NODES"]:
            nodes_mod.show_viewport = False
            without = _evaluated(bare)
            deforms = _same_faces(without, mesh)
            nodes_mod.show_viewport = not deforms
            bpy.data.meshes.remove(mesh if deforms else without)
            mesh = without if deforms else mesh
    mesh.name = obj.name + SUFFIX
    return mesh


def _evaluated(bare: bpy.types.Object) -> bpy.types.Mesh:
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return bpy.data.meshes.new_from_object(bare.evaluated_get(depsgraph), preserve_all_data_layers=True,
                                           depsgraph=depsgraph)


@contextmanager
def _bare_copy(obj: bpy.types.Object, mirrored: bool) -> Iterator[bpy.types.Object]:
    """A copy of the object with the non-deforming modifiers in front, at the shape key that is its rest shape.
    mirrored: also with every Mirror."""
    with scheduler.suspended():
        bare = obj.copy()
        try:
            for m in [m for m in modifier.deforming_and_behind(bare) if not (mirrored and m.type == "MIRROR")]:
                bare.modifiers.remove(m)
            bare.animation_data_clear()
            bare.hide_viewport = False  # hidden objects are not evaluated
            place = obj.matrix_world.copy()  # keep the place, because Mirror and others may use other objects
            bare.parent = None  # because an armature, lattice or curve as a parent deforms
            bare.constraints.clear()
            bare.matrix_world = place
            bare.show_only_shape_key, bare.active_shape_key_index = True, _rest_key(obj)
            bpy.context.scene.collection.objects.link(bare)
            yield bare
        finally:
            bpy.data.objects.remove(bare)
            bpy.context.view_layer.update()  # inside suspended(), so that these updates do not count as edits


def _rest_key(obj: bpy.types.Object) -> int:
    """Index of the shape key that is the rest shape; 0: the basis."""
    keys = obj.data.shape_keys
    settings = getattr(obj.rumple, obj.rumple.method.lower(), None)
    if keys is None or getattr(settings, "rest_shape", "") != "SHAPE_KEY":
        return 0
    return max(keys.key_blocks.find(obj.rumple.rest_key), 0)


# ---------------------------------------------------------------- changes
def stack_fingerprint(obj: bpy.types.Object) -> str:
    """The settings of the non-deforming modifiers in front as a text, to detect changes. Animated settings are left
    out."""
    animated = compat.animated_paths(obj)
    rows = []
    for m in modifier.in_front(obj):
        if modifier.deforms(m):
            continue
        path = m.path_from_id()
        values = {name: _plain(getattr(m, name)) for name in m.bl_rna.properties.keys()
                  if f"{path}.{name}" not in animated and name not in ("execution_time", "is_active")}
        if m.type == "NODES" and m.node_group is not None:
            values.update({key: _plain(compat.modifier_input(m, key)) for key in
                           compat.group_sockets(m.node_group, "INPUT").values()
                           if compat.modifier_input_path(m, key) not in animated})
        rows.append(sorted(values.items()))
    return repr(rows)


def _plain(value: Any) -> str:
    """A text that is the same as long as the value is."""
    if isinstance(value, bpy.types.ID):
        return value.name_full
    if isinstance(value, bpy.types.bpy_struct):
        return ""  # its text has an address
    if isinstance(value, bpy.types.bpy_prop_collection):
        return str(len(value))
    return repr(tuple(value) if hasattr(value, "__len__") and not isinstance(value, (str, set)) else value)
