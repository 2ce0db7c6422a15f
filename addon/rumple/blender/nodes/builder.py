# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers that build node trees by code."""
from __future__ import annotations

from typing import Any, Iterable

import bpy

from .. import compat

Socket: Any = bpy.types.NodeSocket


def empty_modifier_group(group: bpy.types.NodeTree, inputs: Iterable[tuple[str, str]]) -> None:
    """Remove the nodes of a modifier's group, and add missing sockets: the inputs, and a geometry as output. inputs:
    names and socket types. Existing sockets stay, so that modifiers keep their values."""
    group.nodes.clear()
    present = compat.group_sockets(group, "INPUT")
    for name, socket_type in inputs:
        if name not in present:
            compat.new_group_socket(group, name, "INPUT", socket_type)
    if not compat.group_sockets(group, "OUTPUT"):
        compat.new_group_socket(group, "Geometry", "OUTPUT", "NodeSocketGeometry")
    compat.mark_as_modifier(group)


class Nodes:
    """Adds nodes from left to right. Every method returns the output socket of its node."""

    ROWS = 6  # nodes below one another
    WIDTH, HEIGHT = 180.0, 160.0  # of a node with the free space around it

    def __init__(self, group: bpy.types.NodeTree) -> None:
        self.group = group
        self.count = 0

    def node(self, kind: str, **properties: object) -> bpy.types.Node:
        node = self.group.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        node.location = (self.WIDTH * (self.count // self.ROWS), -self.HEIGHT * (self.count % self.ROWS))
        self.count += 1
        return node

    def put(self, value: object, target: Socket) -> None:
        """Connect a socket, or set a constant."""
        if isinstance(value, Socket):
            self.group.links.new(value, target)
        else:
            target.default_value = value

    def vector(self, operation: str, *operands: object) -> Socket:
        """Operands: sockets or three numbers; the second of SCALE is a number."""
        node = self.node("ShaderNodeVectorMath", operation=operation)
        targets = [node.inputs[0], node.inputs["Scale"]] if operation == "SCALE" else node.inputs
        for operand, target in zip(operands, targets):
            self.put(operand, target)
        return node.outputs["Value" if operation in ("DOT_PRODUCT", "LENGTH") else "Vector"]

    def math(self, operation: str, *operands: object) -> Socket:
        node = self.node("ShaderNodeMath", operation=operation)
        for operand, target in zip(operands, node.inputs):
            self.put(operand, target)
        return node.outputs[0]

    def components(self, vector: Socket) -> list[Socket]:
        node = self.node("ShaderNodeSeparateXYZ")
        self.put(vector, node.inputs[0])
        return list(node.outputs)

    def combined(self, *values: object) -> Socket:
        node = self.node("ShaderNodeCombineXYZ")
        for value, target in zip(values, node.inputs):
            self.put(value, target)
        return node.outputs[0]


class GeometryNodes(Nodes):
    """Like Nodes, for geometry nodes."""

    def link(self, output: Socket, node: bpy.types.Node, name: str) -> None:
        self.group.links.new(output, compat.socket(node.inputs, name))

    # --- values
    def index(self) -> Socket:
        return self.node("GeometryNodeInputIndex").outputs[0]

    def position(self) -> Socket:
        return self.node("GeometryNodeInputPosition").outputs[0]

    def named(self, name: str, data_type: str) -> Socket:
        node = self.node("GeometryNodeInputNamedAttribute", data_type=data_type)
        node.inputs["Name"].default_value = name
        return compat.socket(node.outputs, "Attribute")

    def at(self, geometry: Socket, value: Socket, index: Socket | int, data_type: str = "FLOAT_VECTOR") -> Socket:
        """A value at the point `index` of a geometry; zero if there is no such point."""
        node = self.node("GeometryNodeSampleIndex", data_type=data_type, domain="POINT")
        self.link(geometry, node, "Geometry")
        self.link(value, node, "Value")
        self.put(index, compat.socket(node.inputs, "Index"))
        return compat.socket(node.outputs, "Value")

    def largest(self, geometry: Socket, value: Socket) -> Socket:
        """The largest number at a point of a geometry; 0 if it has none. Unlike at() it copies no mesh in 3.4, where
        each Sample Index node copies the mesh of an object or of the modifier's input before it reads it."""
        node = self.node("GeometryNodeAttributeStatistic", data_type="FLOAT", domain="POINT")
        self.link(geometry, node, "Geometry")
        self.link(value, node, "Attribute")
        return compat.socket(node.outputs, "Max")

    def sample(self, geometry: Socket, index: Socket) -> Socket:
        """Position of the point `index` of a geometry."""
        return self.at(geometry, self.position(), index)

    def added(self, *terms: Socket) -> Socket:
        result = terms[0]
        for term in terms[1:]:
            result = self.vector("ADD", result, term)
        return result

    def both(self, a: Socket, b: Socket) -> Socket:
        node = self.node("FunctionNodeBooleanMath", operation="AND")
        self.group.links.new(a, node.inputs[0])
        self.group.links.new(b, node.inputs[1])
        return node.outputs[0]

    def above(self, value: Socket, limit: float) -> Socket:
        node = self.node("FunctionNodeCompare", data_type="FLOAT", operation="GREATER_THAN")
        self.link(value, node, "A")
        compat.socket(node.inputs, "B").default_value = limit
        return node.outputs[0]

    def embedded(self, points: list[Socket], weights: Socket, offset: Socket) -> Socket:
        """The formula at the top of wrinkle_tree.py. points: the positions p0 p1 p2."""
        p0, p1, p2 = points
        edge_1, edge_2 = self.vector("SUBTRACT", p1, p0), self.vector("SUBTRACT", p2, p0)
        tangent = self.vector("NORMALIZE", edge_1)
        normal = self.vector("NORMALIZE", self.vector("CROSS_PRODUCT", edge_1, edge_2))
        bitangent = self.vector("CROSS_PRODUCT", normal, tangent)
        u, v, _ = self.components(weights)
        x, y, z = self.components(offset)
        return self.added(p0, self.vector("SCALE", edge_1, u), self.vector("SCALE", edge_2, v),
                          self.vector("SCALE", tangent, x), self.vector("SCALE", bitangent, y),
                          self.vector("SCALE", normal, z))

    # --- geometries
    def store(self, geometry: Socket, name: str, data_type: str, value: Socket, domain: str = "POINT") -> Socket:
        node = self.node("GeometryNodeStoreNamedAttribute", data_type=data_type, domain=domain)
        self.link(geometry, node, "Geometry")
        node.inputs["Name"].default_value = name
        self.link(value, node, "Value")
        return node.outputs[0]

    def moved(self, fine: Socket, position: Socket) -> Socket:
        node = self.node("GeometryNodeSetPosition")
        self.link(fine, node, "Geometry")
        self.link(position, node, "Position")
        return node.outputs[0]

    def switch(self, condition: Socket, no: Socket, yes: Socket) -> Socket:
        node = self.node("GeometryNodeSwitch", input_type="GEOMETRY")
        self.link(condition, node, "Switch")
        self.link(no, node, "False")
        self.link(yes, node, "True")
        return compat.socket(node.outputs, "Output")

    def without(self, fine: Socket, name: str) -> Socket:
        """Remove an attribute that only this tree reads, so that later modifiers need not carry it."""
        node = self.node("GeometryNodeRemoveAttribute")
        self.link(fine, node, "Geometry")
        node.inputs["Name"].default_value = name
        return node.outputs[0]

    def element_count(self, geometry: Socket, domain: str) -> Socket:
        size = self.node("GeometryNodeAttributeDomainSize", component="MESH")
        self.group.links.new(geometry, size.inputs[0])
        return size.outputs["Point Count" if domain == "POINT" else "Face Corner Count"]

    def object_info(self, obj: Socket) -> bpy.types.NodeOutputs:
        """Outputs about an object: "Geometry" in its own space, "Location" in the space of its parent or the world."""
        info = self.node("GeometryNodeObjectInfo")
        self.link(obj, info, "Object")
        return info.outputs

    def mesh_of(self, obj: Socket) -> Socket:
        """An object's mesh in its own space."""
        return self.object_info(obj)["Geometry"]
