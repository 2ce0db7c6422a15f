# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Maps' frame in geometry nodes: evaluated with the mesh itself, without Python.

Its inputs are two hidden meshes (maps/hidden_meshes.py). The points of the skeleton are the current heads and tails of
the bones, and four points of the root bone that define its space. The points of the skin have the weights of the
vertices. p are positions in root space, in units of the root's axes. The influences I of three poses in a vector are
(Dutreve et al. 2009; native/systems/wrinkle_maps computes the same and tests compare):

    I_i = clamp(slope . (p - neutral))       section 5.1; slope = d / |d|^2, d: displacement, head and tail together
    I_i = share_i  sum of I over its group   section 5.2
    mask_v = sum of w_vi I_i                 section 5.2; gain and strengths are in the weights of each pose

Behind a Wrinkle Mesh (Field, Paths) a fine point interpolates the masks of the coarse corners that it is embedded in.
"""
from __future__ import annotations

from dataclasses import dataclass

import bpy

from ...core.systems.poses import PACKED, ROW
from .. import compat
from . import wrinkle_tree
from .builder import GeometryNodes
from .maps_shader import MASKS

MASK = "rumple_pose_{}"
SKIN, COUNT, BONES, WRINKLES = "Carrier", "Vertices", "Bones", "Wrinkles"
INPUTS = (("Geometry", "NodeSocketGeometry"), (SKIN, "NodeSocketObject"), (COUNT, "NodeSocketInt"),
          (BONES, "NodeSocketObject"), (WRINKLES, "NodeSocketObject"))

# Attributes of the hidden meshes. {} is a pose, a pack of three poses, a column or another row of the weight table.
NEUTRAL, SLOPE, GROUP, SHARE = "rumple_neutral", "rumple_slope_{}", "rumple_group", "rumple_share_{}"
KEY = "rumple_is_key"  # 1 at a point of a shape key, which is in no bone space
BONE, WEIGHTS, MORE = "rumple_bone_{}", "rumple_weights_{}_{}", "rumple_more_{}"
INFLUENCES, SUM = "rumple_influences_{}", "rumple_sum_{}"  # temporary, inside the tree

FRAME = 4  # points of the root bone after the others: its head, and one on each of its axes
DEAD = 1e-4  # share of a displacement, at both ends: node maths has single precision, and 0 and 1 must be exact


@dataclass(frozen=True)
class Shape:
    """The values that the nodes depend on. All others are in attributes."""

    poses: tuple[str, ...] = ()
    bones: int = 0  # with shape keys, which come after the bones
    keys: int = 0  # number of shape keys
    rows: int = 1  # largest number of weight rows of a vertex
    grouped: bool = False  # bones share influences
    fine: bool = False  # there are other wrinkles in front

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
            geometry = self.shown(geometry, self.mesh_of(inputs[SKIN]), skeleton, inputs)
        self.group.links.new(geometry, self.node("NodeGroupOutput").inputs[0])

    # --- footnote 1 of section 5
    def in_root_space(self, skeleton: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """The points of the skeleton in root space, by Cramer's rule. The result does not depend on any common
        rotation, scale or shear."""
        position = self.position()
        if self.shape.bones == self.shape.keys:
            return position
        origin, *ends = (self.at(skeleton, position, 2 * self.shape.bones + point) for point in range(FRAME))
        x, y, z = (self.vector("SUBTRACT", end, origin) for end in ends)
        way = self.vector("SUBTRACT", position, origin)
        normals = [self.vector("CROSS_PRODUCT", *sides) for sides in ((y, z), (z, x), (x, y))]
        volume = self.vector("DOT_PRODUCT", x, normals[0])
        inside = self.vector("SCALE", self.combined(*(self.vector("DOT_PRODUCT", normal, way) for normal in normals)),
                             self.math("DIVIDE", 1.0, volume))
        if not self.shape.keys:
            return inside
        is_key = self.named(KEY, "FLOAT")
        return self.vector("ADD", self.vector("SCALE", position, is_key),
                           self.vector("SCALE", inside, self.math("SUBTRACT", 1.0, is_key)))

    # --- section 5.1
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
    def masks(self, pack: int, skin: bpy.types.NodeSocket, skeleton: bpy.types.NodeSocket
              ) -> tuple[bpy.types.NodeSocket, bpy.types.NodeSocket]:
        """The skin with the necessary attributes, and the mask field on it. In 3.4 every stored attribute copies a
        mesh."""
        influences: bpy.types.NodeSocket = self.named(INFLUENCES.format(pack), "FLOAT_VECTOR")
        summed: object = (0.0,) * 3
        for column in range(ROW):
            bone = self.at(skeleton, influences, self.named(BONE.format(column), "INT"))
            summed = self.vector("MULTIPLY_ADD", bone, self.named(WEIGHTS.format(pack, column), "FLOAT_VECTOR"), summed)
        if self.shape.rows > 1:
            skin = self.store(skin, SUM.format(pack), "FLOAT_VECTOR", summed)
            summed = row = self.named(SUM.format(pack), "FLOAT_VECTOR")
            for further in range(self.shape.rows - 1):
                summed = self.vector("ADD", summed, self.at(skin, row, self.named(MORE.format(further), "INT")))
        return skin, self.vector("MINIMUM", summed, (1.0,) * 3)

    # --- on the mesh that comes in
    def shown(self, geometry: bpy.types.NodeSocket, skin: bpy.types.NodeSocket, skeleton: bpy.types.NodeSocket,
              inputs: bpy.types.NodeOutputs) -> bpy.types.NodeSocket:
        """The mesh with its masks; 0 if its number of points does not fit the masks.

        The incoming mesh is connected to only one node, because Blender would copy it for a second one.
        """
        count = self.total("FLOAT", 1.0)
        if self.shape.fine:
            wrinkles = self.mesh_of(inputs[WRINKLES])
            wrinkled = self.math("GREATER_THAN", self.total("FLOAT", self.named(wrinkle_tree.BASE_INDEX, "INT")), 0.5)
            fine = self.math("MULTIPLY", wrinkled, self.equal(count, self.element_count(wrinkles, "POINT")))
            coarse = self.math("MULTIPLY", self.math("SUBTRACT", 1.0, wrinkled), self.equal(count, inputs[COUNT]))
            corners = [self.at(wrinkles, self.named(name, "INT"), self.index(), "INT") for name in wrinkle_tree.CORNERS]
            place = self.at(wrinkles, self.named(wrinkle_tree.BARYCENTRIC, "FLOAT_VECTOR"), self.index())
        else:
            coarse = self.equal(count, inputs[COUNT])
        for pack in self.shape.packs:
            skin, mask = self.masks(pack, skin, skeleton)
            here = self.vector("SCALE", self.at(skin, mask, self.index()), coarse)
            if self.shape.fine:
                between = self.between([self.at(skin, mask, corner) for corner in corners], place)
                here = self.vector("ADD", here, self.vector("SCALE", between, fine))
            geometry = self.store(geometry, MASKS.format(pack), "FLOAT_VECTOR", here)
            parts = self.components(self.named(MASKS.format(pack), "FLOAT_VECTOR"))
            for name, part in zip(self.shape.poses[PACKED * pack:], parts):
                geometry = self.store(geometry, MASK.format(name), "FLOAT", part)
        return geometry

    def between(self, corners: list[bpy.types.NodeSocket], place: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """Linear interpolation in a triangle. place: (u, v, 0)."""
        u, v, _ = self.components(place)
        along = [self.vector("SUBTRACT", corner, corners[0]) for corner in corners[1:]]
        return self.vector("ADD", self.vector("MULTIPLY_ADD", along[0], u, corners[0]),
                           self.vector("SCALE", along[1], v))

    def equal(self, a: bpy.types.NodeSocket, b: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """1 if two integers are equal, otherwise 0."""
        return self.math("COMPARE", a, b, 0.5)

    def total(self, data_type: str, value: object, group: bpy.types.NodeSocket | None = None) -> bpy.types.NodeSocket:
        """Sum over all points, or over those of the point's group."""
        node = self.node("GeometryNodeAccumulateField", data_type=data_type, domain="POINT")
        self.put(value, compat.socket(node.inputs, "Value"))
        if group is not None:
            self.put(group, compat.socket(node.inputs, compat.GROUP_INPUT))
        return compat.socket(node.outputs, "Total")
