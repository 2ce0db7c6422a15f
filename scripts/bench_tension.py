# SPDX-License-Identifier: GPL-3.0-or-later
"""The usual wrinkles of a Geometry Nodes tutorial: a tension map on the coarse mesh, Subdivision, noise along the
normal where edges are shorter than at rest. A rival of scripts/bench."""
from __future__ import annotations

import math

import benchmark_tension
import bpy
import numpy as np
from benchmark_tension import REST, STORED, enabled

LEVELS = 2


class DisplacementTree(benchmark_tension.Tree):
    """Moves points along their normals by noise as wide as the wavelength, as high as a sine that has the length
    which the edges lost: wavelength / pi times the root of 1 - tension."""

    def __init__(self, wavelength: float) -> None:
        super().__init__(False)
        nodes, links = self.group.nodes, self.group.links
        begin, end = (next(n for n in nodes if n.type == kind) for kind in ("GROUP_INPUT", "GROUP_OUTPUT"))
        nodes.remove(next(n for n in nodes if n.type == "STORE_NAMED_ATTRIBUTE"))
        move = self.node("GeometryNodeSetPosition")
        links.new(begin.outputs[0], move.inputs["Geometry"])
        links.new(move.outputs[0], end.inputs[0])
        scaled = self.node("ShaderNodeVectorMath", operation="SCALE")
        links.new(self.node("GeometryNodeInputNormal").outputs[0], scaled.inputs[0])
        links.new(self.height(wavelength), scaled.inputs["Scale"])
        links.new(scaled.outputs[0], move.inputs["Offset"])

    def math(self, operation: str, *values: bpy.types.NodeSocket | float) -> bpy.types.NodeSocket:
        """One step of arithmetic."""
        node = self.node("ShaderNodeMath", operation=operation)
        for value, target in zip(values, node.inputs):
            if isinstance(value, float):
                target.default_value = value
            else:
                self.group.links.new(value, target)
        return node.outputs[0]

    def named(self, name: str, data_type: str) -> bpy.types.NodeSocket:
        """An attribute that the mesh has."""
        node = self.node("GeometryNodeInputNamedAttribute", data_type=data_type)
        node.inputs["Name"].default_value = name
        return enabled(node.outputs, "Attribute")

    def height(self, wavelength: float) -> bpy.types.NodeSocket:
        """Metres."""
        lost = self.math("MAXIMUM", self.math("SUBTRACT", 1.0, self.named(STORED, "FLOAT")), 0.0)
        noise = self.node("ShaderNodeTexNoise")
        noise.inputs["Scale"].default_value = 1.0 / wavelength
        noise.inputs["Detail"].default_value = 0.0
        self.group.links.new(self.named(REST, "FLOAT_VECTOR"), noise.inputs["Vector"])
        # Noise keeps within 0.25 and 0.75 mostly.
        wave = self.math("MULTIPLY", self.math("SUBTRACT", noise.outputs[0], 0.5), 4.0)
        return self.math("MULTIPLY", self.math("MULTIPLY", self.math("SQRT", lost), wavelength / math.pi), wave)


def add(garment: bpy.types.Object, wavelength: float) -> None:
    """Behind the garment's Armature. The mesh as it was modelled is its rest shape."""
    rest = np.empty(3 * len(garment.data.vertices), np.float32)
    garment.data.vertices.foreach_get("co", rest)
    garment.data.attributes.new(REST, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", rest)
    garment.modifiers.new("Tension", "NODES").node_group = benchmark_tension.Tree(True).group
    garment.modifiers.new("Fine", "SUBSURF").levels = LEVELS
    garment.modifiers.new("Displacement", "NODES").node_group = DisplacementTree(wavelength).group
