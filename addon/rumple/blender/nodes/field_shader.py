# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader node group "Rumple Field": the waves of the Wrinkle Field for every pixel, in Cycles and EEVEE.

Source: Loviscach 2006, equation numbers are the paper's. It reads the attributes that core/systems/wrinkle_field.py
writes on the corners of every triangle. Without these attributes the waves have no height, so other objects may use the
material.

    Height  equation (5), in the object's units
    Normal  equations (7) and (8), without the gradient of the barycentric coordinates, which would show the triangles
    UV      the object's UV map, displaced by the parallax of equations (10) and (11)

Input "Normal": the normal of other nodes, if there is one. "Parallax": factor on (10).
"""
from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ...core.systems import wrinkle_field
from .. import compat
from . import builder, field_profile, use_nodes

NAME = "Rumple Field"
VERSION = 2  # increase it when the nodes change: groups in older files are then rebuilt in place
VERSION_KEY, PROFILE_KEY = "rumple_field_version", "rumple_field_profile"
TWO_PI = 2.0 * np.pi
HORIZON = 0.1  # of equation (10): how softly the parallax fades at grazing angles

_INPUTS = (("Normal", "NodeSocketVector"), ("Parallax", "NodeSocketFloat"))
_OUTPUTS = (("Height", "NodeSocketFloat"), ("Normal", "NodeSocketVector"), ("UV", "NodeSocketVector"))


def is_ours(group: bpy.types.NodeTree | None) -> bool:
    return group is not None and PROFILE_KEY in group


def ensure(obj: bpy.types.Object) -> bpy.types.NodeTree:
    """The node group of this file for the profile of an object, used by no other object. It is created or upgraded if
    necessary."""
    profile = field_profile.key(obj)
    for group in bpy.data.node_groups:
        if (is_ours(group) and group[PROFILE_KEY] == profile and compat.is_editable(group)
                and _is_shown_by(obj, group)):
            break
    else:
        group = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
        group[PROFILE_KEY], group[VERSION_KEY] = profile, 0
    if group[VERSION_KEY] != VERSION:
        _rebuild(group, field_profile.table(obj))
        group[VERSION_KEY] = VERSION
    return group


def _rebuild(group: bpy.types.NodeTree, profile: Any) -> None:
    """profile: the native table."""
    group.nodes.clear()
    for direction, sockets in (("INPUT", _INPUTS), ("OUTPUT", _OUTPUTS)):
        present = compat.group_sockets(group, direction)
        for name, socket_type in sockets:
            if name not in present:
                compat.new_group_socket(group, name, direction, socket_type)
    _Builder(group).build(profile.height, profile.slope)


class _Builder(builder.Nodes):
    """The nodes of the group."""

    WIDTH, HEIGHT = 200.0, 180.0

    def attribute(self, name: str) -> bpy.types.NodeSocket:
        return self.node("ShaderNodeAttribute", attribute_name=name).outputs["Vector"]

    def transform(self, vector: bpy.types.NodeSocket, kind: str, into: str) -> bpy.types.NodeSocket:
        node = self.node("ShaderNodeVectorTransform", vector_type=kind, convert_to=into,
                         convert_from="WORLD" if into == "OBJECT" else "OBJECT")
        self.put(vector, node.inputs[0])
        return node.outputs[0]

    def table(self, places: bpy.types.NodeSocket, values: np.ndarray) -> bpy.types.NodeSocket:
        """Three lookups in a table over 0..1, linear between its entries."""
        node = self.node("ShaderNodeVectorCurve")
        node.mapping.use_clip = False
        for curve in node.mapping.curves[:3]:
            for _ in range(len(values) - len(curve.points)):
                curve.points.new(0.5, 0.0)
            for point, x, y in zip(curve.points, np.linspace(0.0, 1.0, len(values)), values):
                point.location, point.handle_type = (float(x), float(y)), "VECTOR"
        node.mapping.update()
        self.put(places, node.inputs["Vector"])
        return node.outputs[0]

    def object_normal(self, given: bpy.types.NodeSocket, geometry: bpy.types.Node) -> bpy.types.NodeSocket:
        """The input normal, or the normal of the surface if there is none; object space, unit."""
        none = self.math("LESS_THAN", self.vector("LENGTH", given), 1e-6)
        world = self.vector("ADD", given, self.vector("SCALE", geometry.outputs["Normal"], none))
        return self.vector("NORMALIZE", self.transform(self.towards_viewer(world, geometry), "NORMAL", "OBJECT"))

    def towards_viewer(self, normal: bpy.types.NodeSocket, geometry: bpy.types.Node) -> bpy.types.NodeSocket:
        """The normal, corrected for back faces: where coarse cloth folds over, it is seen from outside on its back.
        There the renderer reverses the normal, while the normals of the faces around it still face the viewer. Without
        this correction there was a black slit."""
        away = self.math("LESS_THAN", self.vector("DOT_PRODUCT", normal, geometry.outputs["Incoming"]), 0.0)
        turned = self.math("MULTIPLY", away, geometry.outputs["Backfacing"])
        return self.vector("SCALE", normal, self.math("MULTIPLY_ADD", turned, -2.0, 1.0))

    def gradient(self, slopes: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """Equation (8). slopes: h df/dphi of the three waves, weighted."""
        total = None
        for name, slope in zip(wrinkle_field.VECTORS, self.components(slopes)):
            term = self.vector("SCALE", self.attribute(name), slope)
            total = term if total is None else self.vector("ADD", total, term)
        return total

    def parallax(self, normal: bpy.types.NodeSocket, height: bpy.types.NodeSocket, geometry: bpy.types.Node,
                 share: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """Equations (10) and (11): the displacement of texture coordinates."""
        viewer = self.vector("NORMALIZE", self.transform(geometry.outputs["Incoming"], "VECTOR", "OBJECT"))
        facing = self.vector("DOT_PRODUCT", viewer, normal)
        along = self.vector("SUBTRACT", viewer, self.vector("SCALE", normal, facing))
        softened = self.math("DIVIDE", facing, self.math("MULTIPLY_ADD", facing, facing, HORIZON))
        shift = self.vector("SCALE", along, self.math("MULTIPLY", self.math("MULTIPLY", softened, height), share))
        return self.combined(*(self.vector("DOT_PRODUCT", self.attribute(name), shift)
                               for name in (wrinkle_field.U_GRADIENT, wrinkle_field.V_GRADIENT)))

    def build(self, height_table: np.ndarray, slope_table: np.ndarray) -> None:
        inputs, geometry = self.node("NodeGroupInput").outputs, self.node("ShaderNodeNewGeometry")
        weights = self.attribute(wrinkle_field.WEIGHT)
        # Positions of the three phases in the table of half a period: profile_place() of shaders/shared.
        turns = self.vector("FRACTION", self.vector("MULTIPLY_ADD", self.attribute(wrinkle_field.PHASE),
                                                    (1.0 / TWO_PI,) * 3, (0.5,) * 3))
        turns = self.vector("SUBTRACT", turns, (0.5,) * 3)
        away = self.vector("ABSOLUTE", turns)
        places = self.vector("SCALE", away, 2.0)
        height = self.vector("DOT_PRODUCT", weights, self.table(places, height_table))
        slopes = self.vector("MULTIPLY", self.table(places, slope_table), self.vector("DIVIDE", turns, away))
        normal = self.object_normal(inputs["Normal"], geometry)
        tilted = self.vector("SUBTRACT", normal, self.gradient(self.vector("MULTIPLY", weights, slopes)))
        moved = self.parallax(normal, height, geometry, inputs["Parallax"])
        output = self.node("NodeGroupOutput")
        self.put(height, output.inputs["Height"])
        self.put(self.vector("NORMALIZE", self.transform(tilted, "NORMAL", "WORLD")), output.inputs["Normal"])
        self.put(self.vector("ADD", self.node("ShaderNodeUVMap").outputs[0], moved), output.inputs["UV"])


# ---------------------------------------------------------------- materials
def _is_shader(node: bpy.types.Node) -> bool:
    return node.type.startswith("BSDF") or node.type in ("SUBSURFACE_SCATTERING", "EEVEE_SPECULAR")


def shade(material: bpy.types.Material, obj: bpy.types.Object) -> None:
    """Let a material show the waves: connect the group to the normal of every shader, and to textures without
    coordinates."""
    use_nodes.switch_on(material)
    if set_profile(material, obj):
        return
    nodes, links = material.node_tree.nodes, material.node_tree.links
    textures = [n for n in nodes if n.type == "TEX_IMAGE" and not n.inputs["Vector"].is_linked]
    fields: dict[bpy.types.NodeSocket | None, bpy.types.Node] = {}  # one per normal of other nodes
    for shader in [n for n in nodes if _is_shader(n) and "Normal" in n.inputs]:
        target = shader.inputs["Normal"]
        given = target.links[0].from_socket if target.is_linked else None
        if given not in fields:
            fields[given] = field = _add_field(material, ensure(obj), (shader.location.x, shader.location.y - 300.0))
            if given is not None:
                links.new(given, field.inputs["Normal"])
        links.new(fields[given].outputs["Normal"], target)
    for texture in textures if fields else ():
        links.new(next(iter(fields.values())).outputs["UV"], texture.inputs["Vector"])
    _remove_cycles(material)


def _add_field(material: bpy.types.Material, group: bpy.types.NodeTree, place: tuple[float, float]) -> bpy.types.Node:
    """A node with our group, to the left of a place."""
    field = material.node_tree.nodes.new("ShaderNodeGroup")
    field.node_tree, field.name, field.label = group, NAME, NAME
    field.inputs["Parallax"].default_value = 1.0
    field.location = (place[0] - 250.0, place[1])
    return field


def _remove_cycles(material: bpy.types.Material) -> None:
    """Let textures get their coordinates from a node of our group without an input normal. If a normal map uses such a
    texture, the links would otherwise be a cycle, which Blender 5.2 draws black. Older files have such cycles."""
    links, fields = material.node_tree.links, _our_nodes(material)
    in_cycle = [link for field in fields if field.inputs["Normal"].is_linked for link in field.outputs["UV"].links]
    if not in_cycle:
        return
    first = in_cycle[0].from_node
    plain = next((field for field in fields if not field.inputs["Normal"].is_linked), None) or _add_field(
        material, first.node_tree, (first.location.x, first.location.y))
    for target in [link.to_socket for link in in_cycle]:
        links.new(plain.outputs["UV"], target)


def set_profile(material: bpy.types.Material, obj: bpy.types.Object) -> bool:
    """Give a material that shows waves the profile of an object. Returns False if it shows none.

    A group that only this object's materials use is changed in place. Replacing it crashed Blender: if two undo steps
    have the same version of a material, undo does not replace the material in memory, but frees groups that no step
    has.
    """
    fields = _our_nodes(material)
    profile = field_profile.key(obj)
    for group in {field.node_tree for field in fields if field.node_tree[PROFILE_KEY] != profile}:
        if _is_shown_by(obj, group) and compat.is_editable(group):
            _rebuild(group, field_profile.table(obj))
            group[PROFILE_KEY], group[VERSION_KEY] = profile, VERSION
    for field in fields:
        if field.node_tree[PROFILE_KEY] != profile or field.node_tree[VERSION_KEY] != VERSION:
            field.node_tree = ensure(obj)
    if fields:
        _remove_cycles(material)
    return bool(fields)


def _is_shown_by(obj: bpy.types.Object, group: bpy.types.NodeTree) -> bool:
    """Whether only the materials of an object use a group."""
    fields = [field for material in materials_of(obj) for field in _our_nodes(material)]
    return sum(field.node_tree == group for field in fields) == group.users


def unshade(material: bpy.types.Material) -> None:
    """Remove the waves, and restore the former links."""
    for field in _our_nodes(material):
        given = field.inputs["Normal"]
        source = given.links[0].from_socket if given.is_linked else None
        for target in [link.to_socket for link in field.outputs["Normal"].links]:
            if source is not None:
                material.node_tree.links.new(source, target)
        material.node_tree.nodes.remove(field)
    use_nodes.switch_back(material)


def _our_nodes(material: bpy.types.Material) -> list[bpy.types.Node]:
    if material.node_tree is None:
        return []
    return [n for n in material.node_tree.nodes if n.type == "GROUP" and is_ours(n.node_tree)]


def materials_of(obj: bpy.types.Object) -> list[bpy.types.Material]:
    """The editable materials of an object."""
    found = {slot.material for slot in obj.material_slots if slot.material is not None}
    return sorted((m for m in found if compat.is_editable(m)), key=lambda m: m.name_full)


def shows_waves(material: bpy.types.Material) -> bool:
    """Whether it has a node of ours. It has none if all shaders are inside node groups, or if it has no shader."""
    return bool(_our_nodes(material))


def has_shader_groups(material: bpy.types.Material) -> bool:
    """Whether it has a shader that is inside of a node group."""
    return material.node_tree is not None and any(
        node.type == "GROUP" and any(socket.type == "SHADER" for socket in node.outputs)
        for node in material.node_tree.nodes)


def is_shaded(obj: bpy.types.Object) -> bool:
    """Whether a material of an object draws the waves."""
    return any(map(shows_waves, materials_of(obj)))


def shade_object(obj: bpy.types.Object) -> None:
    """Let the materials of an object show its waves. An object without materials gets a new one."""
    if not any(slot.material for slot in obj.material_slots):
        material = bpy.data.materials.new(obj.name)
        compat.use_nodes(material)
        if obj.material_slots:
            obj.material_slots[0].material = material
        else:
            obj.data.materials.append(material)
    if obj.rumple.field.profile == "CURVE":
        field_profile.ensure(obj)
    for material in materials_of(obj):
        shade(material, obj)


def unshade_object(obj: bpy.types.Object, still_waving: list[bpy.types.Object]) -> None:
    """Remove the waves from an object's materials, except those that other objects with waves use."""
    kept = {material for other in still_waving if other != obj for material in materials_of(other)}
    for material in materials_of(obj):
        if material not in kept:
            unshade(material)
    drop_orphans()


def drop_orphans() -> None:
    """Remove groups of profiles that no material uses."""
    for group in [g for g in bpy.data.node_groups if is_ours(g) and g.users == 0 and compat.is_editable(g)]:
        bpy.data.node_groups.remove(group)
