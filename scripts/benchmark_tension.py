# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by Blender: what a tension map in Geometry Nodes costs, the rival of the Wrinkle Field's crush.

The usual tree: length of every edge over its length at rest, averaged over the edges of a point, stored as an
attribute. It knows one number and no direction. Timed beside the same tree without the map.
"""
from __future__ import annotations

import time

import bpy
import numpy as np

REST, STORED = "rest", "tension"


def sheet(columns: int, rows: int) -> bpy.types.Object:
    """A squeezed wavy sheet that remembers its flat self."""
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    rest = (np.stack([x, y, 0 * x], -1).reshape(-1, 3) * 0.01).astype(np.float32)
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    pose = rest * np.array([0.7, 1, 1], np.float32)
    pose[:, 2] = 0.02 * np.sin(6 * rest[:, 0])
    mesh = bpy.data.meshes.new("Sheet")
    mesh.from_pydata(pose.tolist(), [], np.stack([first, first + 1, first + columns + 1, first + columns], 1).tolist())
    mesh.attributes.new(REST, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", rest.ravel())
    obj = bpy.data.objects.new("Sheet", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def enabled(sockets: object, name: str) -> bpy.types.NodeSocket:
    return next(socket for socket in sockets if socket.enabled and socket.name == name)


class Tree:
    """Stores a float on points: the tension, or a constant."""

    def __init__(self, with_map: bool) -> None:
        self.group = bpy.data.node_groups.new("Tension", "GeometryNodeTree")
        if hasattr(self.group, "interface"):
            for direction in ("INPUT", "OUTPUT"):
                self.group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
        else:
            self.group.inputs.new("NodeSocketGeometry", "Geometry")
            self.group.outputs.new("NodeSocketGeometry", "Geometry")
        begin, end = self.group.nodes.new("NodeGroupInput"), self.group.nodes.new("NodeGroupOutput")
        store = self.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT", domain="POINT")
        store.inputs["Name"].default_value = STORED
        self.group.links.new(begin.outputs[0], store.inputs["Geometry"])
        self.group.links.new(store.outputs[0], end.inputs[0])
        if with_map:
            self.group.links.new(self.tension(), enabled(store.inputs, "Value"))

    def node(self, kind: str, **properties: object) -> bpy.types.Node:
        node = self.group.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        return node

    def tension(self) -> bpy.types.NodeSocket:
        named = self.node("GeometryNodeInputNamedAttribute", data_type="FLOAT_VECTOR")
        named.inputs["Name"].default_value = REST
        position = self.node("GeometryNodeInputPosition").outputs[0]
        now, rest = self.edge_length(position), self.edge_length(enabled(named.outputs, "Attribute"))
        ratio = self.node("ShaderNodeMath", operation="DIVIDE")
        self.group.links.new(now, ratio.inputs[0])
        self.group.links.new(rest, ratio.inputs[1])
        on_edges = self.node("GeometryNodeFieldOnDomain", data_type="FLOAT", domain="EDGE")
        self.group.links.new(ratio.outputs[0], enabled(on_edges.inputs, "Value"))
        return next(socket for socket in on_edges.outputs if socket.enabled)

    def edge_length(self, place: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        ends = self.node("GeometryNodeInputMeshEdgeVertices")
        distance = self.node("ShaderNodeVectorMath", operation="DISTANCE")
        for end, target in zip(("Vertex Index 1", "Vertex Index 2"), distance.inputs):
            at = self.node("GeometryNodeFieldAtIndex", data_type="FLOAT_VECTOR", domain="POINT")
            self.group.links.new(ends.outputs[end], at.inputs["Index"])
            self.group.links.new(place, enabled(at.inputs, "Value"))
            self.group.links.new(next(socket for socket in at.outputs if socket.enabled), target)
        return distance.outputs["Value"]


def milliseconds(obj: bpy.types.Object, tree: Tree) -> tuple[float, float]:
    """Of the fastest evaluation; and the mean that it stored."""
    modifier = obj.modifiers.new("Tension", "NODES")
    modifier.node_group = tree.group
    times = []
    for _ in range(12):
        obj.data.update_tag()
        began = time.perf_counter()
        bpy.context.view_layer.update()
        times.append(1e3 * (time.perf_counter() - began))
    stored = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.attributes[STORED]
    values = np.empty(len(stored.data), np.float32)
    stored.data.foreach_get("value", values)
    obj.modifiers.remove(modifier)
    return min(times), float(values.mean())


def main() -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    tension, constant = Tree(True), Tree(False)
    for columns, rows in ((13, 35), (43, 139), (316, 317), (1000, 1000)):
        obj = sheet(columns, rows)
        (with_map, mean), (without, _) = milliseconds(obj, tension), milliseconds(obj, constant)
        assert 0.7 < mean < 1.0, mean
        print(f"Tension map in Geometry Nodes, {columns * rows:,} vertices, all threads: {with_map:.2f} ms, "
              f"of that {with_map - without:.2f} ms for the map")
        bpy.data.objects.remove(obj)


if __name__ == "__main__":
    main()
