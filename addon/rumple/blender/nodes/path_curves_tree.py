# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "Rumple Path Curves", built by code: makes curves from the rows in core/systems/curve_rows.py.

The rows are the points of the incoming mesh. Handlers write them, or a Mesh Cache in front plays them. The points of
the curves follow the garment as it enters its wrinkles, in the garment's object space. Attributes of the result:

  rumple_path_id       INT    for each curve, in order of creation, never reused
  rumple_path_height   FLOAT  for each point, object units, signed
  rumple_path_width    FLOAT  for each point, object units

With a radius the curves become tubes.
"""
from __future__ import annotations

import bpy

from ...core.systems.curve_rows import ROWS
from .. import compat
from . import wrinkle_tree
from .builder import GeometryNodes, Socket, empty_modifier_group

VERSION = 1  # increase it when the nodes change: trees in older files are then rebuilt in place
VERSION_KEY = "rumple_path_curves_version"

GARMENT, RADIUS = "Garment", "Radius"
PATH_ID, PATH_HEIGHT, PATH_WIDTH = "rumple_path_id", "rumple_path_height", "rumple_path_width"
# On the points, until they are copied to the curves.
_POINT_ID, _POINT_INDEX = "rumple_point_path", "rumple_point_index"
_INPUTS = (("Geometry", "NodeSocketGeometry"), (GARMENT, "NodeSocketObject"), (RADIUS, "NodeSocketFloat"))


def is_ours(group: bpy.types.NodeTree | None) -> bool:
    """Whether it is this node group, independent of its name and version."""
    return group is not None and VERSION_KEY in group


def ensure() -> bpy.types.NodeTree:
    """The node group of this file. It is created or upgraded if necessary."""
    group = next((g for g in bpy.data.node_groups if is_ours(g) and compat.is_editable(g)), None)
    if group is None:
        group = bpy.data.node_groups.new("Rumple Path Curves", "GeometryNodeTree")
        group[VERSION_KEY] = 0
    upgrade(group)
    return group


def upgrade(group: bpy.types.NodeTree) -> None:
    """Rebuild the nodes of an older version in place, so that modifiers keep their inputs."""
    if group[VERSION_KEY] == VERSION or not compat.is_editable(group):
        return
    empty_modifier_group(group, _INPUTS)
    _Curves(group).build()
    group[VERSION_KEY] = VERSION


class _Curves(GeometryNodes):

    def row(self, geometry: Socket, number: int, index: Socket) -> Socket:
        """One of the rows of the point `index`."""
        capacity = self.math("DIVIDE", self.element_count(geometry, "POINT"), float(ROWS))
        return self.sample(geometry, self.math("MULTIPLY_ADD", capacity, float(number), index))

    def is_number(self, garment: Socket, index: Socket) -> Socket:
        """Whether a coarse point still has its index on the result of the wrinkles."""
        compare = self.node("FunctionNodeCompare", data_type="INT", operation="EQUAL")
        self.link(self.at(garment, self.named(wrinkle_tree.BASE_INDEX, "INT"), index, "INT"), compare, "A")
        self.link(index, compare, "B")
        return compare.outputs[0]

    def is_joined(self, geometry: Socket, garment: Socket) -> Socket:
        """Whether the edge from point i to point i + 1, which is edge i, belongs to a curve. If the garment does not
        show its wrinkles, its points have no index attribute, so there are no curves. Two points are tested, because a
        missing attribute reads as 0, which is the right index of point 0."""
        edge = self.index()
        first, second, _ = self.components(self.row(geometry, 0, edge))
        there = self.both(self.is_number(garment, first), self.is_number(garment, second))
        return self.both(there, self.above(self.components(self.row(geometry, 3, edge))[2], 0.5))

    def tubes(self, curves: Socket, radius: Socket) -> Socket:
        circle = self.node("GeometryNodeCurvePrimitiveCircle")
        circle.inputs["Resolution"].default_value = 8
        self.link(radius, circle, "Radius")
        node = self.node("GeometryNodeCurveToMesh")
        self.link(curves, node, "Curve")
        self.link(circle.outputs["Curve"], node, "Profile Curve")
        node.inputs["Fill Caps"].default_value = True
        return node.outputs[0]

    def build(self) -> None:
        inputs = self.node("NodeGroupInput").outputs
        geometry, garment = inputs["Geometry"], self.mesh_of(inputs[GARMENT])
        to_curve = self.node("GeometryNodeMeshToCurve")  # first, so that the following nodes only run on visible points
        self.link(self.store(geometry, _POINT_INDEX, "INT", self.index()), to_curve, "Mesh")
        self.link(self.is_joined(geometry, garment), to_curve, "Selection")
        index = self.named(_POINT_INDEX, "INT")
        places, weights, offset, shape = (self.row(geometry, number, index) for number in range(ROWS))
        incoming = self.named(wrinkle_tree.BASE_POSITION, "FLOAT_VECTOR")
        posed = [self.at(garment, incoming, corner) for corner in self.components(places)]
        curves = self.moved(to_curve.outputs[0], self.embedded(posed, weights, offset))
        width, height, _ = self.components(shape)
        for name, data_type, value in ((_POINT_ID, "INT", self.components(weights)[2]), (PATH_WIDTH, "FLOAT", width),
                                       (PATH_HEIGHT, "FLOAT", height)):
            curves = self.store(curves, name, data_type, value)
        curves = self.store(curves, PATH_ID, "INT", self.named(_POINT_ID, "INT"), "CURVE")
        for name in (_POINT_ID, _POINT_INDEX):
            curves = self.without(curves, name)
        shown = self.switch(self.above(inputs[RADIUS], 0.0), curves, self.tubes(curves, inputs[RADIUS]))
        output = self.node("NodeGroupOutput")
        self.group.links.new(shown, output.inputs[0])
