# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the output object: the hidden object with the fine mesh and all data that it inherits from the coarse one.

Carried: materials and their slots, smooth shading, UV maps, colours and other attributes (points, corners, faces),
vertex groups, seams, sharp edges, creases and bevel weights, Auto Smooth (3.4); "rest_position" by rest_position.py.
Not carried: custom split normals (they belong to the coarse corners only), edge attributes, strings.
"""
from __future__ import annotations

import functools
import hashlib
import json

import bpy
import numpy as np

from ...core.base.triangles import Embedding, on_shown
from ...core.base.vertices import pair_keys
from ...core.mesh.frame_result import Attribute, FrameResult
from ...core.mesh.shown_mesh import ShownMesh
from .. import compat
from ..nodes import wrinkle_tree
from . import incoming_mesh, mesh_reader

KEY = "rumple_carrier"  # custom property on output and cache objects: identifies our objects
CARRIED_KEY = "rumple_carried"  # custom property on the output mesh: fingerprints of the inherited data, JSON
SUFFIX = ".wrinkles"
WEIGHT_STEPS = 1024.0  # of vertex group weights: each step needs a call, and thousands of calls take half a second


class Inherited:
    """The data that the output objects of one garment inherit. The slow parts are read when they are first needed, once
    for all output objects. Use it only once, because the garment may change later.

    source: the object with the materials, UV maps and attributes: obj, or the artist's own fine mesh.
    """

    def __init__(self, obj: bpy.types.Object, source: bpy.types.Object) -> None:
        self.obj, self.source = obj, source
        self.mesh = incoming_mesh.of(obj) if source == obj else source.data  # attributes of corners, faces and points
        self.group_names = [group.name for group in obj.vertex_groups]

    def read(self) -> None:
        """Read all slow parts now."""
        self.groups, self.surface

    @functools.cached_property
    def weights(self) -> np.ndarray:
        """(n, groups) float32, weights of the vertex groups."""
        return mesh_reader.group_weights(self.obj, incoming_mesh.of(self.obj), self.group_names)

    @functools.cached_property
    def groups(self) -> dict[str, str]:
        """Hash of the weights of every vertex group."""
        return {name: hashlib.sha1(self.weights[:, column].tobytes()).hexdigest()
                for column, name in enumerate(self.group_names)}

    @functools.cached_property
    def surface(self) -> str:
        """Hash of all data that carry() reads, except the vertex groups."""
        digest, mesh = hashlib.sha1(), self.mesh
        digest.update(repr([slot.material and slot.material.name_full for slot in self.source.material_slots]).encode())
        for prop, dtype in (("material_index", np.int32), ("use_smooth", bool)):
            values = np.empty(len(mesh.polygons), dtype)
            mesh.polygons.foreach_get(prop, values)
            digest.update(values.tobytes())
        for layer in mesh.uv_layers:
            digest.update(f"{layer.name} {layer.active} {layer.active_render}".encode()
                          + compat.uv_values(layer).tobytes())
        for attribute in compat.generic_attributes(mesh):
            digest.update(f"{attribute.name} {attribute.domain}".encode() + compat.read_attribute(attribute).tobytes())
        for prop, values in compat.edge_marks(mesh).items():
            digest.update(prop.encode() + values.tobytes())
        digest.update(repr(compat.smoothing(mesh)).encode())
        return digest.hexdigest()


def make(fine: ShownMesh, inherited: Inherited) -> bpy.types.Object:
    """A new output object. It is in no collection; the modifier's input keeps it alive."""
    name = inherited.obj.name + SUFFIX
    output = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    fill(output, fine, inherited)
    return output


def fill(output: bpy.types.Object, fine: ShownMesh, inherited: Inherited) -> None:
    """Give the output object the fine mesh, embedded and at rest, and all carried data."""
    mesh = output.data
    mesh.clear_geometry()
    compat.fill_polygons(mesh, fine.positions_rest, fine.polygon_start, fine.corner_vertex)
    write_embedding(mesh, fine)
    carry(output, fine, inherited)
    mesh.update()


def write_embedding(mesh: bpy.types.Mesh, fine: ShownMesh) -> None:
    """Write the attributes that the node tree reads, with zero offsets."""
    count = fine.vertex_count
    for corner, name in enumerate(wrinkle_tree.CORNERS):
        compat.write_attribute(mesh, name, "INT", "POINT", fine.triangle_vertex[:, corner])
    weights = np.zeros((count, 3), np.float32)
    weights[:, :2] = fine.barycentric
    compat.write_attribute(mesh, wrinkle_tree.BARYCENTRIC, "FLOAT_VECTOR", "POINT", weights)
    compat.write_attribute(mesh, wrinkle_tree.LOCAL_OFFSET, "FLOAT_VECTOR", "POINT", np.zeros((count, 3), np.float32))
    compat.write_attribute(mesh, wrinkle_tree.BASE_INDEX, "INT", "POINT", np.arange(count, dtype=np.int32))
    rest = FrameResult.at_rest(fine.positions_rest, len(fine.corner_vertex), fine.ATTRIBUTES)
    _write_attributes(mesh, rest, fine.ATTRIBUTES)


def is_embedding_of(mesh: bpy.types.Mesh, fine: ShownMesh) -> bool:
    """Whether the output object (perhaps from a file) already is this fine mesh with this embedding."""
    if len(mesh.vertices) != fine.vertex_count or len(mesh.loops) != len(fine.corner_vertex):
        return False
    if not np.array_equal(compat.corner_vertices(mesh), fine.corner_vertex):
        return False
    names = (*wrinkle_tree.CORNERS, wrinkle_tree.BARYCENTRIC, wrinkle_tree.LOCAL_OFFSET, wrinkle_tree.BASE_INDEX,
             *(attribute.name for attribute in fine.ATTRIBUTES))
    if any(name not in mesh.attributes for name in names):
        return False
    stored = np.stack([compat.read_attribute(mesh.attributes[name])[:, 0] for name in wrinkle_tree.CORNERS], 1)
    weights = compat.read_attribute(mesh.attributes[wrinkle_tree.BARYCENTRIC])
    return (np.array_equal(stored, fine.triangle_vertex)
            and np.array_equal(weights[:, :2], fine.barycentric, equal_nan=True))


def write_result(mesh: bpy.types.Mesh, result: FrameResult, attributes: tuple[Attribute, ...]) -> None:
    """Write the result of one frame. Handlers write only this and write_proxy()."""
    compat.write_attribute(mesh, wrinkle_tree.LOCAL_OFFSET, "FLOAT_VECTOR", "POINT", result.local_offset)
    _write_attributes(mesh, result, attributes)
    compat.values_changed(mesh)


def write_proxy(mesh: bpy.types.Mesh, displacements: np.ndarray | None) -> None:
    """Set the mesh that viewports show instead of the fine mesh: the coarse vertices moved by (n, 3). None: the fine
    mesh."""
    uses_proxy = displacements is not None
    known = mesh.attributes.get(wrinkle_tree.SHOWS_PROXY)
    if known is None and not uses_proxy:
        return
    if known is None or bool(known.data[0].value) != uses_proxy:
        compat.write_attribute(mesh, wrinkle_tree.SHOWS_PROXY, "INT", "POINT",
                               np.full(len(mesh.vertices), uses_proxy, np.int32))
    if uses_proxy:
        padded = np.zeros((len(mesh.vertices), 3), np.float32)  # the fine mesh has at least as many vertices
        padded[:len(displacements)] = displacements
        compat.write_attribute(mesh, wrinkle_tree.PROXY_OFFSET, "FLOAT_VECTOR", "POINT", padded)
    compat.values_changed(mesh)


def _write_attributes(mesh: bpy.types.Mesh, result: FrameResult, attributes: tuple[Attribute, ...]) -> None:
    for a in attributes:
        compat.write_attribute(mesh, a.name, a.data_type, a.domain, result.attributes[a.name])


# ---------------------------------------------------------------- carrying
def carry(output: bpy.types.Object, fine: ShownMesh, inherited: Inherited) -> None:
    """Write all inherited data again, after it changed while the topology did not."""
    mesh = output.data
    _drop_inherited(mesh)
    _carry_materials(mesh, inherited.source)
    _carry_faces(mesh, inherited.mesh, fine)
    _carry_edges(mesh, inherited.mesh, fine)
    _carry_uv_maps(mesh, inherited.mesh, fine)
    _carry_attributes(mesh, inherited.mesh, fine)
    compat.copy_smoothing(inherited.mesh, mesh)
    carry_vertex_groups(output, fine, inherited, inherited.group_names)
    _note_carried(mesh, inherited)


def _drop_inherited(mesh: bpy.types.Mesh) -> None:
    for name in [layer.name for layer in mesh.uv_layers]:
        mesh.uv_layers.remove(mesh.uv_layers[name])
    for name in [attribute.name for attribute in compat.generic_attributes(mesh)]:
        mesh.attributes.remove(mesh.attributes[name])


def _carry_materials(mesh: bpy.types.Mesh, source: bpy.types.Object) -> None:
    """Copy the slots in their order. Only these slots are used in the result, including materials linked to the
    object."""
    mesh.materials.clear()
    for slot in source.material_slots:
        mesh.materials.append(slot.material)


def _carry_faces(mesh: bpy.types.Mesh, inherited: bpy.types.Mesh, fine: ShownMesh) -> None:
    parents = fine.polygon_parent
    for prop, dtype in (("material_index", np.int32), ("use_smooth", bool)):
        values = np.empty(len(inherited.polygons), dtype)
        inherited.polygons.foreach_get(prop, values)
        mesh.polygons.foreach_set(prop, np.ascontiguousarray(values[parents]))


def _find_edges(mesh: bpy.types.Mesh, pairs: np.ndarray) -> np.ndarray:
    """The index of the edge between each pair of vertices. Every pair must be an edge of the mesh."""
    keys = pair_keys(compat.edge_vertices(mesh), len(mesh.vertices))
    order = np.argsort(keys)
    place = np.searchsorted(keys, pair_keys(pairs, len(mesh.vertices)), sorter=order)
    return order[place]


def _carry_edges(mesh: bpy.types.Mesh, inherited: bpy.types.Mesh, fine: ShownMesh) -> None:
    marks = compat.edge_marks(inherited)
    if not marks or not len(fine.edges):
        return
    base_edge = _find_edges(inherited, fine.edge_parent)
    fine_edge = _find_edges(mesh, fine.edges)
    spread = {}
    for prop, values in marks.items():
        spread[prop] = np.zeros(len(mesh.edges), values.dtype)
        spread[prop][fine_edge] = values[base_edge]
    compat.set_edge_marks(mesh, spread)


def _carry_uv_maps(mesh: bpy.types.Mesh, inherited: bpy.types.Mesh, fine: ShownMesh) -> None:
    active, active_render = "", ""
    for name in [layer.name for layer in inherited.uv_layers]:
        layer = inherited.uv_layers[name]
        active, active_render = (name if layer.active else active), (name if layer.active_render else active_render)
        coarse_uv = compat.uv_values(layer)
        mesh.uv_layers.new(name=name, do_init=False)
        fine_uv = np.ascontiguousarray(fine.carry_corners(coarse_uv), np.float32)
        mesh.uv_layers[name].data.foreach_set("uv", fine_uv.ravel())
    if active:
        mesh.uv_layers[active].active = True
    if active_render:
        mesh.uv_layers[active_render].active_render = True


def _carry_attributes(mesh: bpy.types.Mesh, inherited: bpy.types.Mesh, fine: ShownMesh) -> None:
    for name in [attribute.name for attribute in compat.generic_attributes(inherited)]:
        attribute = inherited.attributes[name]
        domain, data_type = attribute.domain, attribute.data_type
        if domain == "EDGE":
            continue
        values = _carried_values(fine, domain, compat.read_attribute(attribute))
        compat.write_attribute(mesh, name, data_type, domain, values)
    colours, target = inherited.color_attributes, mesh.color_attributes
    if colours.active_color is not None and colours.active_color.name in target:
        target.active_color = target[colours.active_color.name]
        target.render_color_index = target.find(colours[colours.render_color_index].name)


def _carried_values(fine: ShownMesh, domain: str, values: np.ndarray) -> np.ndarray:
    """Interpolated values. Integers and booleans are rounded, so that a value that is constant around a point does not
    change."""
    if domain == "FACE":
        return values[fine.polygon_parent]
    spread = fine.carry_points if domain == "POINT" else fine.carry_corners
    result = spread(np.ascontiguousarray(values, np.float32))
    return result if values.dtype == np.float32 else np.rint(result).astype(values.dtype)


def carry_vertex_groups(output: bpy.types.Object, fine: ShownMesh, inherited: Inherited, names: list[str]) -> None:
    """Write the weights of the named groups. Every group is created, because a modifier without its group acts on
    everything."""
    wanted = inherited.group_names
    for group in [group for group in output.vertex_groups if group.name not in wanted or group.name in names]:
        output.vertex_groups.remove(group)
    for name in wanted:
        if name not in output.vertex_groups:
            output.vertex_groups.new(name=name)
    if not names:
        return
    for name in names:  # these groups are new and empty
        steps = weight_steps(fine, inherited.weights[:, wanted.index(name)])
        write_steps(output.vertex_groups[name], steps, np.zeros(len(steps), np.int32))


def weight_steps(fine: ShownMesh, weights: np.ndarray) -> np.ndarray:
    """(n,) weights of the coarse mesh -> (m,) of the fine one, in steps too small to be visible: 0 if a point is not in
    the group, otherwise 1 to WEIGHT_STEPS. Cost: little where most weights are 0, as those of a bone."""
    corners, is_member = fine.triangle_vertex, weights > 0.0
    rows = np.flatnonzero(is_member[corners[:, 0]] | is_member[corners[:, 1]] | is_member[corners[:, 2]])
    # an own mesh has other points than carry_points() expects
    spread = on_shown(weights, Embedding(corners[rows], fine.barycentric[rows]))
    steps = np.zeros(len(corners), np.int32)
    steps[rows] = np.where(spread > 0.0, np.maximum(np.rint(spread * WEIGHT_STEPS), 1.0), 0.0)
    return steps


def write_steps(group: bpy.types.VertexGroup, steps: np.ndarray, had: np.ndarray | None = None) -> None:
    """Write (m,) from weight_steps(). had: the group's current values; None: unknown. All points of one weight need one
    call, because Blender has no other interface for weights."""
    members = np.flatnonzero(np.ones(len(steps), bool) if had is None else steps != had)
    order = members[np.argsort(steps[members], kind="stable")]
    ordered, places = steps[order], order.tolist()
    ends = [*(np.flatnonzero(np.diff(ordered)) + 1).tolist(), len(places)]
    for begin, end in zip([0, *ends], ends if places else ()):
        step = int(ordered[begin])
        if step:
            group.add(places[begin:end], step / WEIGHT_STEPS, "REPLACE")
        else:
            group.remove(places[begin:end])


# ---------------------------------------------------------------- what changed
def carry_changes(output: bpy.types.Object, fine: ShownMesh, inherited: Inherited) -> bool:
    """Carry the data that differs from the output object's data. Returns whether there was any."""
    mesh, groups = output.data, inherited.groups
    stored = json.loads(mesh.get(CARRIED_KEY, "{}"))
    stored_groups = stored.get("groups", {})
    changed = [name for name in groups if groups[name] != stored_groups.get(name)]
    if inherited.surface != stored.get("surface"):
        carry(output, fine, inherited)
    elif changed or groups.keys() != stored_groups.keys():
        carry_vertex_groups(output, fine, inherited, changed)
        _note_carried(mesh, inherited)
    else:
        return False
    mesh.update()
    return True


def _note_carried(mesh: bpy.types.Mesh, inherited: Inherited) -> None:
    mesh[CARRIED_KEY] = json.dumps(dict(surface=inherited.surface, groups=inherited.groups))


def copy_for(obj: bpy.types.Object, shared: bpy.types.Object) -> bpy.types.Object:
    """A separate output object for an object that shares one (a duplicate) or whose output object is linked."""
    mesh = shared.data.copy()
    output = shared.copy()
    output.data = mesh
    output.name = mesh.name = obj.name + SUFFIX
    return output
