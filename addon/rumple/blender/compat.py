# SPDX-License-Identifier: GPL-3.0-or-later
"""All differences between Blender 3.4 and 5.2 that matter to Rumple.

No other file checks the version. Tested with 3.4.1, 4.3.2 and 5.2.2.
"""
from __future__ import annotations

import math
import threading
from typing import Any, Iterable, Iterator

import bpy
import numpy as np

VERSION: tuple[int, int, int] = bpy.app.version
HAS_MODIFIER_MENU = VERSION >= (4, 0, 0)  # before, no entries can be added to the Add Modifier menu
HAS_AUTO_SMOOTH = VERSION < (4, 1, 0)
SMOOTH_COLOR_SHADER = "SMOOTH_COLOR" if VERSION >= (4, 0, 0) else "3D_SMOOTH_COLOR"
GROUP_INPUT = "Group ID" if VERSION >= (3, 6, 0) else "Group Index"  # of the Accumulate Field node
LINE_SHADER = "POLYLINE_SMOOTH_COLOR" if VERSION >= (4, 0, 0) else "3D_POLYLINE_SMOOTH_COLOR"

# Attribute data types: property of an element, numbers in it, and what foreach_get fills.
ATTRIBUTE_LAYOUT: dict[str, tuple[str, int, type]] = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, bool),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "INT16_2D": ("value", 2, np.int32),
    "INT32_2D": ("value", 2, np.int32),
    "QUATERNION": ("value", 4, np.float32),
    "FLOAT4X4": ("value", 16, np.float32),
}

# Blender's own attributes. They are rebuilt or carried in other ways.
_BUILT_IN = frozenset((
    "position", "material_index", "sharp_face", "sharp_edge", "crease_edge", "crease_vert", "uv_seam",
    "bevel_weight_edge", "bevel_weight_vert", "custom_normal", "freestyle_edge", "freestyle_face", "id", "radius"))


# ---------------------------------------------------------------- node groups
def new_group_socket(group: bpy.types.NodeTree, name: str, in_out: str, socket_type: str) -> None:
    """Add an input or an output to a node group."""
    if hasattr(group, "interface"):
        group.interface.new_socket(name, in_out=in_out, socket_type=socket_type)
    else:
        (group.inputs if in_out == "INPUT" else group.outputs).new(socket_type, name)


def group_sockets(group: bpy.types.NodeTree, in_out: str) -> dict[str, str]:
    """Name -> identifier of the inputs or outputs of a node group."""
    if hasattr(group, "interface"):
        items = (i for i in group.interface.items_tree if i.item_type == "SOCKET" and i.in_out == in_out)
    else:
        items = iter(group.inputs if in_out == "INPUT" else group.outputs)
    return {item.name: item.identifier for item in items}


def socket_identifier(group: bpy.types.NodeTree, name: str) -> str | None:
    """Identifier of an input of a node group; None if it has no such input."""
    if hasattr(group, "interface"):
        return group_sockets(group, "INPUT").get(name)
    return getattr(group.inputs.get(name), "identifier", None)  # a tenth of the time of group_sockets()


def socket(sockets: Any, name: str) -> bpy.types.NodeSocket:
    """The enabled socket with this name. Before 4.0 a node has a hidden socket for each data type."""
    for candidate in sockets:
        if candidate.enabled and candidate.name == name:
            return candidate
    raise KeyError(name)


def uses_nodes(material: bpy.types.Material) -> bool:
    """Whether a material is drawn with its nodes. From 5.0 on it always is, and the property is deprecated."""
    return VERSION >= (5, 0, 0) or material.use_nodes


def use_nodes(material: bpy.types.Material, switch: bool = True) -> None:
    """Give a material a node tree, or draw it without; nothing from 5.0 on."""
    if VERSION < (5, 0, 0):
        material.use_nodes = switch


def mark_as_modifier(group: bpy.types.NodeTree) -> None:
    """Allow a node group as a modifier. Needed from 4.0 on."""
    if hasattr(group, "is_modifier"):
        group.is_modifier = True


def modifier_input(modifier: bpy.types.NodesModifier, identifier: str) -> Any:
    """Value of an input of a nodes modifier; None if it was never set, and for geometry."""
    if hasattr(modifier, "properties"):  # 5.2: modifier["Socket_2"] raises TypeError
        inputs = modifier.properties.inputs
        return getattr(getattr(inputs, identifier, None), "value", None)
    return modifier.get(identifier)


def set_modifier_input(modifier: bpy.types.NodesModifier, identifier: str, value: Any) -> None:
    """Set an input of a nodes modifier. The caller tags the object."""
    if hasattr(modifier, "properties"):
        getattr(modifier.properties.inputs, identifier).value = value
    else:
        modifier[identifier] = value


def modifier_input_path(modifier: bpy.types.NodesModifier, identifier: str) -> str:
    """Data path of an input of a nodes modifier, as in keys and drivers."""
    ending = f".properties.inputs.{identifier}.value" if hasattr(modifier, "properties") else f'["{identifier}"]'
    return modifier.path_from_id() + ending


def move_modifier(obj: bpy.types.Object, source: int, target: int) -> None:
    """Move a modifier within the stack, by index."""
    if hasattr(obj.modifiers, "move"):
        obj.modifiers.move(source, target)
        return
    with bpy.context.temp_override(object=obj, active_object=obj):
        bpy.ops.object.modifier_move_to_index(modifier=obj.modifiers[source].name, index=target)


# ---------------------------------------------------------------- data-blocks
def session_key(data_block: bpy.types.ID) -> int:
    """A number that identifies a data-block within a session.

    3.4 has only the address, which a later data-block may reuse. So an entry found under the key must be checked before
    it is used (as solve.py does).
    """
    uid = getattr(data_block, "session_uid", None)
    return uid if uid is not None else data_block.as_pointer()


def is_editable(data_block: bpy.types.ID) -> bool:
    """False for linked data, where writing is silently ignored."""
    return data_block.library is None


def holds(items: bpy.types.bpy_prop_collection, data_block: bpy.types.ID) -> bool:
    """Whether a collection has this data-block. A local and a linked one may have the same name, and get() finds only
    the first."""
    found = items.get(data_block.name)
    return found == data_block or (found is not None and any(item == data_block for item in items))


def keyed_curves(user: bpy.types.AnimData | bpy.types.NlaStrip) -> Iterator[bpy.types.FCurve]:
    """The curves of an object's or a strip's action that belong to it. From 4.4 on, an action may also have curves of
    other objects."""
    if user.action is None:
        return
    if not hasattr(user, "action_slot"):
        yield from user.action.fcurves
    elif user.action_slot is not None:
        for layer in user.action.layers:
            for strip in layer.strips:
                bag = strip.channelbag(user.action_slot)
                yield from bag.fcurves if bag is not None else ()


def has_strips(about: bpy.types.AnimData) -> bool:
    """Whether NLA strips animate it. Then a value is not known before the frame is evaluated."""
    return any(track.strips for track in about.nla_tracks)


def animated_paths(obj: bpy.types.Object) -> set[str]:
    """Data paths of the properties that keys, drivers and strips animate."""
    about = obj.animation_data
    if about is None:
        return set()
    strips = [strip for track in about.nla_tracks for strip in _with_those_inside(track.strips)]
    curves = [*about.drivers, *(curve for user in (about, *strips) for curve in keyed_curves(user))]
    return {curve.data_path for curve in curves}


def _with_those_inside(strips: Iterable[bpy.types.NlaStrip]) -> Iterator[bpy.types.NlaStrip]:
    """All strips, also those inside meta strips."""
    for strip in strips:
        yield strip
        yield from _with_those_inside(strip.strips)


def new_curves(data_block: bpy.types.ID, name: str) -> bpy.types.bpy_prop_collection:
    """Give a data-block an empty action of that name. Returns its curves, for new()."""
    action = bpy.data.actions.new(name)
    animation = data_block.animation_data_create()
    animation.action = action
    if not hasattr(action, "slots"):  # new in 4.4, with layers
        return action.fcurves
    slot = action.slots.new(data_block.id_type, data_block.name)
    animation.action_slot = slot
    return action.layers.new("Layer").strips.new(type="KEYFRAME").channelbag(slot, ensure=True).fcurves


def find_curve(about: bpy.types.AnimData, path: str, index: int = 0) -> bpy.types.FCurve | None:
    """The animation curve of one property."""
    return next((curve for curve in keyed_curves(about) if (curve.data_path, curve.array_index) == (path, index)), None)


# ---------------------------------------------------------------- folders
# Options of a property for a folder that may begin with //. Blender needs them from 4.5 on.
FOLDER_OPTIONS = ({"PATH_SUPPORTS_BLEND_RELATIVE"}
                  if "is_path_supports_blend_relative" in bpy.types.Property.bl_rna.properties else set())


# ---------------------------------------------------------------- words
def translated_report(text: str) -> str:
    """A message in Blender's language, if messages are translated."""
    words = bpy.app.translations
    return (words.pgettext_rpt if hasattr(words, "pgettext_rpt") else words.pgettext_tip)(text)  # _rpt: 4.1 on


# ---------------------------------------------------------------- meshes
def positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """Vertex positions, (n, 3) float32."""
    flat = np.empty(len(mesh.vertices) * 3, np.float32)
    attribute = mesh.attributes.get("position")  # from 3.5 on; much faster than vertices.co
    if attribute is not None and len(attribute.data) * 3 == len(flat):
        attribute.data.foreach_get("vector", flat)
    else:
        mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def corner_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """The vertex of every corner, (c,) int32."""
    attribute = mesh.attributes.get(".corner_vert")  # from 3.6 on; much faster
    if attribute is None or len(attribute.data) != len(mesh.loops):
        return indices(mesh.loops, "vertex_index")
    return read_attribute(attribute).ravel()


def indices(elements: bpy.types.bpy_prop_collection, prop: str, width: int = 1) -> np.ndarray:
    """(elements * width,) int32: non-negative numbers of other elements. They are read as unsigned, because Blender 3.4
    takes 6 to 40 times as long for signed integers."""
    found = np.empty(len(elements) * width, np.int32)
    elements.foreach_get(prop, found.view(np.uint32))
    return found


def triangle_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """The three vertices of every triangle, (t, 3) int32. It triangulates the polygons."""
    mesh.calc_loop_triangles()
    return indices(mesh.loop_triangles, "vertices", 3).reshape(-1, 3)


def uv_values(layer: bpy.types.MeshUVLoopLayer) -> np.ndarray:
    """(corners, 2) float32 of a UV map."""
    values = np.empty((len(layer.data), 2), np.float32)
    layer.data.foreach_get("uv", values.ravel())
    return values


def edge_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    """The two vertices of every edge, (e, 2) int32."""
    return indices(mesh.edges, "vertices", 2).reshape(-1, 2)


def values_changed(mesh: bpy.types.Mesh) -> None:
    """Let Blender evaluate a mesh again after its attributes or positions were written. Handlers call this, not
    mesh.update(): that also puts a notice into the queue of the windows, which has no lock. A render job that did so in
    its own thread could leave Blender 5.2 in an endless loop."""
    if threading.current_thread() is threading.main_thread():
        mesh.update()
    else:
        mesh.update_tag()


def set_positions(mesh: bpy.types.Mesh, values: np.ndarray) -> None:
    """Write vertex positions, (n, 3). The caller calls values_changed()."""
    flat = np.ascontiguousarray(values, np.float32).ravel()
    attribute = mesh.attributes.get("position")
    if attribute is not None:
        attribute.data.foreach_set("vector", flat)
    else:
        mesh.vertices.foreach_set("co", flat)


def fill_polygons(mesh: bpy.types.Mesh, positions_: np.ndarray, polygon_start: np.ndarray,
                  corner_vertex: np.ndarray) -> None:
    """Give an empty mesh its vertices, polygons and edges."""
    polygon_count = len(polygon_start) - 1
    mesh.vertices.add(len(positions_))
    mesh.loops.add(len(corner_vertex))
    mesh.polygons.add(polygon_count)
    set_positions(mesh, positions_)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(corner_vertex, np.int32))
    mesh.polygons.foreach_set("loop_start", np.ascontiguousarray(polygon_start[:-1], np.int32))
    if VERSION < (4, 0, 0):  # later the sizes follow from the starts
        mesh.polygons.foreach_set("loop_total", np.ascontiguousarray(np.diff(polygon_start), np.int32))
    mesh.update(calc_edges=True)


def generic_attributes(mesh: bpy.types.Mesh) -> list[bpy.types.Attribute]:
    """Attributes of users and modifiers: not the built-in ones, UV maps or Rumple's own."""
    uv_names = {layer.name for layer in mesh.uv_layers}
    return [a for a in mesh.attributes if a.name not in _BUILT_IN and a.name not in uv_names
            and not a.name.startswith((".", "rumple_")) and a.data_type in ATTRIBUTE_LAYOUT]


def read_attribute(attribute: bpy.types.Attribute) -> np.ndarray:
    """Values of an attribute, (elements, numbers)."""
    prop, width, dtype = ATTRIBUTE_LAYOUT[attribute.data_type]
    flat: np.ndarray = np.empty(len(attribute.data) * width, dtype)
    attribute.data.foreach_get(prop, flat)
    return flat.reshape(-1, width)


def write_attribute(mesh: bpy.types.Mesh, name: str, data_type: str, domain: str, values: np.ndarray) -> None:
    """Make or overwrite an attribute. The caller calls values_changed()."""
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.data_type, attribute.domain) != (data_type, domain):
        mesh.attributes.remove(attribute)
        attribute = None
    if attribute is None:
        mesh.attributes.new(name, data_type, domain)
    prop, _width, dtype = ATTRIBUTE_LAYOUT[data_type]
    # Looked up again, because adding a layer moves the others. 3.4 refuses strided arrays. float64 is 2 to 37 times
    # slower.
    mesh.attributes[name].data.foreach_set(prop, np.ascontiguousarray(values, dtype).ravel())


_EDGE_FLOATS = (("crease", "crease_edge"), ("bevel_weight", "bevel_weight_edge"))


def edge_marks(mesh: bpy.types.Mesh) -> dict[str, np.ndarray]:
    """Marks of edges: seams, sharp edges, creases, bevel weights. Only kinds that are used."""
    count = len(mesh.edges)
    marks: dict[str, np.ndarray] = {}
    for prop in ("use_seam", "use_edge_sharp"):
        values = np.empty(count, bool)
        mesh.edges.foreach_get(prop, values)
        marks[prop] = values
    for prop, attribute_name in _EDGE_FLOATS:
        marks[prop] = _edge_floats(mesh, prop, attribute_name)
    return {prop: values for prop, values in marks.items() if values.any()}


def _edge_floats(mesh: bpy.types.Mesh, prop: str, attribute_name: str) -> np.ndarray:
    """Values of edges. Until 3.6 they are a property, later an attribute."""
    values = np.zeros(len(mesh.edges), np.float32)
    if VERSION < (4, 0, 0):
        mesh.edges.foreach_get(prop, values)
    elif attribute_name in mesh.attributes:
        attribute = mesh.attributes[attribute_name]
        if (attribute.domain, attribute.data_type) == ("EDGE", "FLOAT"):
            attribute.data.foreach_get("value", values)
    return values


def edge_creases(mesh: bpy.types.Mesh) -> np.ndarray:
    """(edges,) float32 in 0..1."""
    return _edge_floats(mesh, *_EDGE_FLOATS[0])


def set_edge_marks(mesh: bpy.types.Mesh, marks: dict[str, np.ndarray]) -> None:
    """Write what edge_marks() read, one value for every edge of this mesh."""
    names = dict(_EDGE_FLOATS)
    for prop, values in marks.items():
        if prop in names and VERSION >= (4, 0, 0):
            write_attribute(mesh, names[prop], "FLOAT", "EDGE", values)
            continue
        if prop == "crease":
            _allow_crease_3(mesh)
        mesh.edges.foreach_set(prop, np.ascontiguousarray(values))


def _allow_crease_3(mesh: bpy.types.Mesh) -> None:
    """Make the layer of edge creases, which 3.4 needs."""
    if not mesh.edge_creases:
        # There is no function for this, but writing one value makes the layer.
        mesh.edges[0].crease = 1.0
        mesh.edges[0].crease = 0.0


def copy_smoothing(source: bpy.types.Mesh, target: bpy.types.Mesh) -> None:
    """Copy Auto Smooth. Before 4.1 it is a setting of the mesh, later a modifier of the object."""
    if HAS_AUTO_SMOOTH:
        target.use_auto_smooth, target.auto_smooth_angle = smoothing(source)


def smoothing(mesh: bpy.types.Mesh) -> tuple:
    """The values that copy_smoothing() copies, for comparison. With custom normals Blender ignores the angle. The copy
    has no custom normals, so its angle must have no effect: skin of a glTF import had many flat faces otherwise."""
    if not HAS_AUTO_SMOOTH:
        return ()
    return mesh.use_auto_smooth, math.pi if mesh.has_custom_normals else mesh.auto_smooth_angle


def shade_smooth(mesh: bpy.types.Mesh) -> None:
    """Shade a mesh smooth all over, whatever faces, edges, Auto Smooth and custom normals say."""
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    if HAS_AUTO_SMOOTH:
        mesh.use_auto_smooth = False  # without it neither sharp edges nor custom normals count
        return
    mesh.edges.foreach_set("use_edge_sharp", np.zeros(len(mesh.edges), bool))
    if mesh.has_custom_normals:
        mesh.normals_split_custom_set_from_vertices(np.zeros((len(mesh.vertices), 3)))  # zeros: no custom normal
