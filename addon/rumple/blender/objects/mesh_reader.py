# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads coarse meshes, own meshes, painted groups and posed positions as flat arrays."""
from __future__ import annotations

import hashlib

import bpy
import numpy as np

from ...core.base import transforms
from ...core.base.wording import UserError
from ...core.cloth.draped_cloth import PAINTED
from ...core.mesh.base_mesh import BaseMesh
from ...core.paint.fold_guides import DIRECTION, GUIDES, KIND
from ...core.paint.hangs_free import FREE
from ...core.paint.keep_smooth import SMOOTH
from ...core.paint.paint_maps import WIDTH, narrowest_of
from ...core.paint.painted_rigid import RIGID, wholly_painted
from ...core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings, SystemSettings
from .. import compat
from ..nodes import field_profile, wrinkle_tree
from . import guide_curves, incoming_mesh, own_mesh_place, rig_scale

# Painted maps: key of the engine -> vertex group on the coarse mesh.
MESH_GROUPS: dict[str, str] = {
    "radius": "Rumple Radius",
    "prestretch": "Rumple Pre-Stretch",
    "bending": "Rumple Bending",
    "inside": "Rumple Inside",
    "drape": "Rumple Drape",
    "folds": "Rumple Folds",
    "detail": "Rumple Detail",
    "follow": "Rumple Follow",
    "room": "Rumple Room",
    FREE: "Rumple Hangs Free",
    SMOOTH: "Rumple Keep Smooth",
    RIGID: "Rumple Rigid",
    WIDTH: "Rumple Wavelength",
}
MOST_SHARPNESS = 10.0  # of a crease of 1: it always stays sharp, as in Blender's Subdivision
REST_WRINKLE = "rumple_rest_wrinkle"  # painted vectors of the Wrinkle Field, a point attribute of the coarse mesh
LEAST_WAVELENGTH = 0.1  # least painted factor, because a weight of 0 means "nothing painted" in other maps
ATTACHED_GROUP = "Rumple Attached"  # on an own mesh: points with a weight below 0.5 are not attached


_BUSY_MODES = frozenset(("EDIT", "SCULPT"))  # the mesh data does not yet have the edits


def is_busy(obj: bpy.types.Object) -> bool:
    """Whether an object is being edited: itself, through another object with the same mesh, or its own fine mesh. Its
    mesh data is then empty or outdated."""
    own = obj.rumple.own_mesh
    return (obj.mode in _BUSY_MODES or obj.data.is_editmode
            or (own is not None and own.type == "MESH" and own.data.is_editmode))


def base_mesh(obj: bpy.types.Object, rest_shape: str, rest_key: str) -> BaseMesh:
    """The coarse mesh of an object at rest. Raises UserError with a message for the panel."""
    mesh = incoming_mesh.of(obj)
    mesh.calc_loop_triangles()
    base = _flat_mesh(obj.name, mesh, rest_positions(obj, rest_shape, rest_key))
    base.figure = obj.rumple.figure
    rigid = _map_of_every_system(obj, mesh, RIGID)
    base.painted_rigid = None if rigid is None else wholly_painted(base, rigid)
    return base


def material_slots(obj: bpy.types.Object, mesh: bpy.types.Mesh) -> np.ndarray:
    """(polygons,) int32: the material slot of every face of a mesh of this object, which has at least one slot. Blender
    draws faces whose number is too large with the last material."""
    return np.minimum(compat.indices(mesh.polygons, "material_index"), len(obj.material_slots) - 1)


def narrowest(obj: bpy.types.Object, settings: SystemSettings) -> float:
    """BaseMesh.narrowest, for the systems that refine their solved mesh for it."""
    if isinstance(settings, FieldSettings) or (isinstance(settings, MeshSettings) and not settings.layered):
        return 1.0
    return narrowest_of(_map_of_every_system(obj, incoming_mesh.of(obj), WIDTH))


def _map_of_every_system(obj: bpy.types.Object, mesh: bpy.types.Mesh, key: str) -> np.ndarray | None:
    """(n,), a map of paint() that is the same for every system."""
    name = MESH_GROUPS[key]
    if name in obj.vertex_groups:
        return group_weights(obj, mesh, [name])[:, 0]
    values = _point_attribute(mesh, name, "FLOAT")
    return None if values is None else values[:, 0]


def render_uv(mesh: bpy.types.Mesh) -> np.ndarray | None:
    """The UV map that renders use, (corners, 2) float32; None if there is none."""
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    return None if layer is None else compat.uv_values(layer)


def own_mesh(obj: bpy.types.Object, own: bpy.types.Object) -> BaseMesh:
    """The artist's own fine mesh, undeformed, in the object space of obj."""
    mesh = own.data
    mesh.calc_loop_triangles()
    into = np.array(own_mesh_place.of(obj, own), np.float32)
    return _flat_mesh(own.name, mesh, transforms.placed(into, basis_positions(mesh)))


def _flat_mesh(name: str, mesh: bpy.types.Mesh, positions: np.ndarray) -> BaseMesh:
    polygon_start = np.append(compat.indices(mesh.polygons, "loop_start"), np.int32(len(mesh.loops)))
    triangle_corner = compat.indices(mesh.loop_triangles, "loops", 3)
    crease_edge, crease_sharpness = _creases(mesh)
    return BaseMesh(name=name, positions=np.ascontiguousarray(positions, np.float32), polygon_start=polygon_start,
                    corner_vertex=compat.corner_vertices(mesh), triangle_corner=triangle_corner.reshape(-1, 3),
                    crease_edge=crease_edge, crease_sharpness=crease_sharpness)


def _creases(mesh: bpy.types.Mesh) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Edges with a crease, and for how many subdivisions they stay sharp, as in Blender's Subdivision."""
    values = compat.edge_creases(mesh)
    creased = np.flatnonzero(values > 0.0)  # an attribute may have any value; this leaves out NaN
    if not len(creased):
        return None, None
    crease = np.minimum(values[creased], np.float32(1.0))
    return compat.edge_vertices(mesh)[creased], np.float32(MOST_SHARPNESS) * crease * crease


# ---------------------------------------------------------------- rest shapes
def rest_positions(obj: bpy.types.Object, rest_shape: str, rest_key: str) -> np.ndarray:
    """Positions without wrinkles, (n, 3) float32."""
    mesh = incoming_mesh.of(obj)
    if rest_shape == "FRAME":
        attribute = mesh.attributes.get(wrinkle_tree.REST_POSITION)
        if attribute is None:
            raise UserError(f"{obj.name}: no rest shape is captured yet: press Capture")
        return compat.read_attribute(attribute)
    if rest_shape == "SHAPE_KEY":
        blocks = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
        if rest_key not in blocks:
            raise UserError(f"{obj.name}: it has no shape key named \"{rest_key}\" to rest at: choose another")
        if incoming_mesh.is_own(obj):
            return key_positions(blocks[rest_key])
    return basis_positions(mesh)  # the incoming mesh was made from this shape key


def basis_positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """Positions of the undeformed mesh, (n, 3) float32."""
    keys = mesh.shape_keys
    return key_positions(keys.reference_key) if keys else compat.positions(mesh)


def key_positions(key: bpy.types.ShapeKey) -> np.ndarray:
    """Positions of the vertices in a shape key, (n, 3) float32."""
    flat = np.empty(len(key.data) * 3, np.float32)
    key.data.foreach_get("co", flat)
    return flat.reshape(-1, 3)


# ---------------------------------------------------------------- vertex groups
def group_weights(obj: bpy.types.Object, mesh: bpy.types.Mesh, names: list[str]) -> np.ndarray:
    """Weights of the named vertex groups of obj, (n, groups) float32, 0 to 1; 0 if a vertex is not in the group.

    Blender's own tools may leave weights above 1: a Remesh of 5.2 carries groups to the new vertices, and does.
    Blender has no fast access to deform weights: this visits all vertices, 1 ms per 1000.
    """
    column = {group.index: names.index(group.name) for group in obj.vertex_groups if group.name in names}
    weights = np.zeros((len(mesh.vertices), len(names)), np.float32)
    if not column:
        return weights
    for index, vertex in enumerate(mesh.vertices):
        for element in vertex.groups:
            place = column.get(element.group)
            if place is not None:
                weights[index, place] = element.weight
    return np.clip(weights, 0.0, 1.0, out=weights)


def paint_groups(settings: SystemSettings) -> dict[str, str]:
    """Key of the engine -> name of the vertex group or float attribute that paints it."""
    cloth = {key: MESH_GROUPS[key] for key in (*PAINTED, RIGID)}
    if isinstance(settings, FieldSettings):
        return {"mask": settings.mask, WIDTH: settings.wavelength_scale, **cloth}
    if isinstance(settings, PathsSettings):
        return {"mask": settings.mask, WIDTH: MESH_GROUPS[WIDTH], **cloth}
    return MESH_GROUPS


def painted_groups(obj: bpy.types.Object, settings: SystemSettings) -> list[str]:
    """The names of the vertex groups that are painted maps, each once."""
    return [name for name in dict.fromkeys(paint_groups(settings).values()) if name in obj.vertex_groups]


def weights_by_name(obj: bpy.types.Object, names: list[str]) -> dict[str, np.ndarray]:
    """Name of a vertex group -> (n,) float32, as group_weights()."""
    weights = group_weights(obj, incoming_mesh.of(obj), names) if names else None
    return {name: np.ascontiguousarray(weights[:, column]) for column, name in enumerate(names)}


def paint(obj: bpy.types.Object, settings: SystemSettings,
          weights: dict[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
    """All existing painted maps for the solver: (n,) or (n, 3) float32. weights: weights_by_name() of
    painted_groups(); None: they are read."""
    names, mesh = paint_groups(settings), incoming_mesh.of(obj)
    if weights is None:
        weights = weights_by_name(obj, painted_groups(obj, settings))
    painted = {key: weights[name] for key, name in names.items() if name in weights}
    guides = guide_curves.read(obj, lambda: rest_positions(obj, settings.rest_shape, obj.rumple.rest_key))
    if guides is not None:
        guides[:, :3] *= np.float32(rig_scale.of_rest(obj, settings.rest_shape))  # their points
    if guides is not None and isinstance(settings, FieldSettings) and settings.output == "SHADING":
        guides = guides[guides[:, KIND] == DIRECTION]  # shading shows no geometric folds
    if guides is not None and len(guides):
        painted[GUIDES] = guides
    if WIDTH in painted and not isinstance(settings, MeshSettings):
        painted[WIDTH] = np.maximum(painted[WIDTH], np.float32(LEAST_WAVELENGTH))
    for key in names.keys() - painted.keys():
        values = _point_attribute(mesh, names[key], "FLOAT")
        if values is not None:
            painted[key] = np.ascontiguousarray(values[:, 0])
    if isinstance(settings, FieldSettings):
        vectors = _point_attribute(mesh, REST_WRINKLE, "FLOAT_VECTOR")
        if vectors is not None:
            painted["rest_wrinkle"] = vectors
        if settings.profile == "CURVE":
            painted["profile"] = field_profile.heights(obj)
    return painted


def _point_attribute(mesh: bpy.types.Mesh, name: str, data_type: str) -> np.ndarray | None:
    found = mesh.attributes.get(name)
    if found is None or (found.domain, found.data_type) != ("POINT", data_type):
        return None
    return compat.read_attribute(found)


def attached(own: bpy.types.Object) -> np.ndarray | None:
    """Which points of an own mesh are attached, (n,) bool; None if all are."""
    if ATTACHED_GROUP not in own.vertex_groups:
        return None
    return group_weights(own, own.data, [ATTACHED_GROUP])[:, 0] >= 0.5


# ---------------------------------------------------------------- posed positions
def posed_positions(evaluated: bpy.types.Object, count: int) -> np.ndarray | None:
    """Incoming coarse positions in this depsgraph's frame, (count, 3); None if the tree did not run, or points are
    missing.

    The tree stored them on its result, in the first points. If a later modifier has reordered the points, the stored
    indices give the new order.
    """
    attributes = evaluated.data.attributes
    stored, numbers = attributes.get(wrinkle_tree.BASE_POSITION), attributes.get(wrinkle_tree.BASE_INDEX)
    if stored is None or numbers is None or stored.domain != "POINT":
        return None
    values, index = compat.read_attribute(stored), compat.read_attribute(numbers)[:, 0]
    expected = np.arange(count, dtype=np.int32)
    if len(index) >= count and np.array_equal(index[:count], expected):
        return np.ascontiguousarray(values[:count])
    where = np.full(count, -1, np.int64)
    usable = (index >= 0) & (index < count)
    where[index[usable][::-1]] = np.flatnonzero(usable)[::-1]  # of several copies, the first is used
    if (where < 0).any():
        return None
    return np.ascontiguousarray(values[where])


def plain_positions(evaluated: bpy.types.Object, count: int) -> np.ndarray | None:
    """Positions of an evaluated mesh that is still the coarse one, because the modifier did not change it."""
    if len(evaluated.data.vertices) != count:
        return None
    return compat.positions(evaluated.data)


# ---------------------------------------------------------------- fingerprints
def shape_fingerprint(base: BaseMesh) -> str:
    """Hash of all inputs of the fine mesh."""
    digest = hashlib.sha1()
    for array in (base.positions, base.polygon_start, base.corner_vertex, base.triangle_corner, base.uv,
                  base.crease_edge, base.crease_sharpness, base.painted_rigid, np.array(base.narrowest)):
        if array is not None:
            digest.update(np.ascontiguousarray(array).tobytes())
    if base.figure > 0.0:  # not in files from before it was known, whose bakes must stay valid
        digest.update(f"{base.figure:.5g}".encode())
    return digest.hexdigest()
