# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Maps' frame in geometry nodes: evaluated with the mesh itself, where no Python runs.

Two hidden meshes come in (maps_carriers.py): the skeleton, whose points are heads and tails of the bones as they stand
now, and the skin, whose points hold the weights of the vertices. With b bones and the influences I of three poses in
a vector (Dutreve et al. 2009; native/systems/wrinkle_maps.cpp computes the same and tests compare):

    c_i = R^-1 (p_i - o)                     section 5, footnote 1; R from the points of the root bone
    I_i = clamp(slope . (c - neutral))       section 5.1; slope = way / |way|^2, head and tail together
    I_i = share_i  sum of I over its group   section 5.2
    mask_v = lift_v  sum of w_vi I_i         section 5.2; lift: gain and strength

Behind a Wrinkle Mesh (Field, Paths) the fine points get the masks of the coarse corners that they are embedded in.
"""
from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..core.poses import PACKED, ROW
from . import node_tree, versions
from .geometry_nodes import GeometryNodes
from .maps_nodes import MASKS

MASK = "rumple_pose_{}"
CARRIER, COUNT, BONES, WRINKLES = "Carrier", "Vertices", "Bones", "Wrinkles"
INPUTS = (("Geometry", "NodeSocketGeometry"), (CARRIER, "NodeSocketObject"), (COUNT, "NodeSocketInt"),
          (BONES, "NodeSocketObject"), (WRINKLES, "NodeSocketObject"))

# Attributes of the hidden meshes. {} is a pose, a pack of three poses, a column or a further row of the weight table.
NEUTRAL, SLOPE, GROUP, SHARE = "rumple_neutral", "rumple_slope_{}", "rumple_group", "rumple_share_{}"
BONE, WEIGHT, MORE, LIFT = "rumple_bone_{}", "rumple_weight_{}", "rumple_more_{}", "rumple_lift_{}"
INFLUENCES, SUM = "rumple_influences_{}", "rumple_sum_{}"  # on the way, within the tree
ROOT_POINTS = 4  # behind the 2 b points of the bones: the root's head, and one unit along x, y and z

DEAD = 1e-4  # of a way, at both ends: nodes count in single precision, and 0 and 1 are to be exact


@dataclass(frozen=True)
class Shape:
    """What the nodes themselves depend on; all else stands in attributes."""

    poses: tuple[str, ...] = ()
    bones: int = 0
    rows: int = 1  # most rows of weights that a vertex has
    grouped: bool = False  # bones share influences
    fine: bool = False  # other wrinkles stand in front

    @property
    def packs(self) -> range:
        return range((len(self.poses) + PACKED - 1) // PACKED)


class Builder(GeometryNodes):
    """The tree of one object."""

    def __init__(self, group: bpy.types.NodeTree, shape: Shape) -> None:
        super().__init__(group)
        self.shape = shape

    def build(self) -> None:
        inputs = self.node("NodeGroupInput").outputs
        geometry = inputs["Geometry"]
        if self.shape.poses:
            skeleton = self.with_influences(self.mesh_of(inputs[BONES]))
            skin = self.with_masks(self.mesh_of(inputs[CARRIER]), skeleton)
            geometry = self.shown(geometry, skin, inputs)
        self.group.links.new(geometry, self.node("NodeGroupOutput").inputs[0])

    # --- section 5.1
    def in_root_space(self, skeleton: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """By Cramer's rule: the root bone may be scaled."""
        position = self.position()
        head, *ends = (self.at(skeleton, position, 2 * self.shape.bones + n) for n in range(ROOT_POINTS))
        x, y, z = (self.vector("SUBTRACT", end, head) for end in ends)
        crosses = [self.vector("CROSS_PRODUCT", *pair) for pair in ((y, z), (z, x), (x, y))]
        volume = self.vector("DOT_PRODUCT", x, crosses[0])
        place = self.vector("SUBTRACT", position, head)
        return self.combined(*(self.math("DIVIDE", self.vector("DOT_PRODUCT", place, cross), volume)
                               for cross in crosses))

    def with_influences(self, skeleton: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        displaced = self.vector("SUBTRACT", self.in_root_space(skeleton), self.named(NEUTRAL, "FLOAT_VECTOR"))
        tail = self.math("ADD", self.index(), float(self.shape.bones))
        result = skeleton
        for pack in self.shape.packs:
            poses = range(PACKED * pack, min(PACKED * (pack + 1), len(self.shape.poses)))
            parts = self.combined(*(self.vector("DOT_PRODUCT", displaced, self.named(SLOPE.format(k), "FLOAT_VECTOR"))
                                    for k in poses))
            alpha = self.vector("ADD", parts, self.at(skeleton, parts, tail))
            alpha = self.vector("MULTIPLY_ADD", alpha, (1.0 + 2.0 * DEAD,) * 3, (-DEAD,) * 3)
            alpha = self.vector("MINIMUM", self.vector("MAXIMUM", alpha, (0.0,) * 3), (1.0,) * 3)
            if self.shape.grouped:
                summed = self.total("FLOAT_VECTOR", alpha, self.named(GROUP, "INT"))
                alpha = self.vector("MULTIPLY", summed, self.named(SHARE.format(pack), "FLOAT_VECTOR"))
            result = self.store(result, INFLUENCES.format(pack), "FLOAT_VECTOR", alpha)
        return result

    # --- section 5.2
    def with_masks(self, skin: bpy.types.NodeSocket, skeleton: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        bones = [self.named(BONE.format(column), "INT") for column in range(ROW)]
        weights = [self.named(WEIGHT.format(column), "FLOAT") for column in range(ROW)]
        more = [self.named(MORE.format(row), "INT") for row in range(self.shape.rows - 1)]
        for pack in self.shape.packs:
            influences = self.named(INFLUENCES.format(pack), "FLOAT_VECTOR")
            row: object = (0.0,) * 3
            for bone, weight in zip(bones, weights):
                row = self.vector("MULTIPLY_ADD", self.at(skeleton, influences, bone), weight, row)
            skin = self.store(skin, SUM.format(pack), "FLOAT_VECTOR", row)
            summed = first = self.named(SUM.format(pack), "FLOAT_VECTOR")
            for place in more:
                summed = self.vector("ADD", summed, self.at(skin, first, place))
            mask = self.vector("MULTIPLY", summed, self.named(LIFT.format(pack), "FLOAT_VECTOR"))
            skin = self.store(skin, MASKS.format(pack), "FLOAT_VECTOR", self.vector("MINIMUM", mask, (1.0,) * 3))
        return skin

    # --- on the mesh that comes in
    def shown(self, geometry: bpy.types.NodeSocket, skin: bpy.types.NodeSocket, inputs: object
              ) -> bpy.types.NodeSocket:
        """The mesh with its masks; 0 where it has other points than the masks are for.

        The incoming mesh goes to one node only: for a second one Blender would copy it.
        """
        count = self.total("FLOAT", 1.0)
        if self.shape.fine:
            wrinkles = self.mesh_of(inputs[WRINKLES])
            wrinkled = self.math("GREATER_THAN", self.total("FLOAT", self.named(node_tree.BASE_INDEX, "INT")), 0.5)
            fine = self.math("MULTIPLY", wrinkled, self.equal(count, self.element_count(wrinkles, "POINT")))
            coarse = self.math("MULTIPLY", self.math("SUBTRACT", 1.0, wrinkled), self.equal(count, inputs[COUNT]))
            corners = [self.at(wrinkles, self.named(name, "INT"), self.index(), "INT") for name in node_tree.CORNERS]
            place = self.at(wrinkles, self.named(node_tree.BARYCENTRIC, "FLOAT_VECTOR"), self.index())
        else:
            coarse = self.equal(count, inputs[COUNT])
        for pack in self.shape.packs:
            mask = self.named(MASKS.format(pack), "FLOAT_VECTOR")
            here = self.vector("SCALE", self.at(skin, mask, self.index()), coarse)
            if self.shape.fine:
                between = self.between([self.at(skin, mask, corner) for corner in corners], place)
                here = self.vector("ADD", here, self.vector("SCALE", between, fine))
            geometry = self.store(geometry, MASKS.format(pack), "FLOAT_VECTOR", here)
            for name, part in zip(self.shape.poses[PACKED * pack:], self.components(mask)):
                geometry = self.store(geometry, MASK.format(name), "FLOAT", part)
        return geometry

    def between(self, corners: list[bpy.types.NodeSocket], place: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """Linear in a triangle. place: (u, v, 0)."""
        u, v, _ = self.components(place)
        along = [self.vector("SUBTRACT", corner, corners[0]) for corner in corners[1:]]
        return self.vector("ADD", self.vector("MULTIPLY_ADD", along[0], u, corners[0]),
                           self.vector("SCALE", along[1], v))

    def equal(self, a: bpy.types.NodeSocket, b: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """1 or 0, of whole numbers."""
        return self.math("COMPARE", a, b, 0.5)

    def total(self, data_type: str, value: object, group: bpy.types.NodeSocket | None = None) -> bpy.types.NodeSocket:
        """Sum over all points, or over those of the point's group."""
        node = self.node("GeometryNodeAccumulateField", data_type=data_type, domain="POINT")
        self.put(value, versions.socket(node.inputs, "Value"))
        if group is not None:
            self.put(group, versions.socket(node.inputs, versions.GROUP_INPUT))
        return versions.socket(node.outputs, "Total")
