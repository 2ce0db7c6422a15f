# SPDX-License-Identifier: GPL-3.0-or-later
"""What the curves of a garment's paths are: Python cannot read evaluated curves before 5.0, so a modifier behind
turns them into edges, which keep points, order and attributes."""
from __future__ import annotations

import unittest
from typing import Any

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.frame import path_curves
from rumple.blender.objects import runtimes
from support import sleeve

NAME = "Wires"
ATTRIBUTES = ("rumple_path_id", "rumple_path_height", "rumple_path_width")


def to_edges(child: bpy.types.Object) -> None:
    """Let the object show its curves as edges."""
    group = bpy.data.node_groups.get(NAME)
    if group is None:
        group = bpy.data.node_groups.new(NAME, "GeometryNodeTree")
        for in_out in ("INPUT", "OUTPUT"):
            compat.new_group_socket(group, "Geometry", in_out, "NodeSocketGeometry")
        compat.mark_as_modifier(group)
        start, convert, end = (group.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeCurveToMesh",
                                                                  "NodeGroupOutput"))
        group.links.new(start.outputs[0], convert.inputs[0])
        group.links.new(convert.outputs[0], end.inputs[0])
    if NAME not in child.modifiers:
        child.modifiers.new(NAME, "NODES").node_group = group


def seen(child: bpy.types.Object) -> Any:
    """(curves, positions, attributes) as the viewport has them: curves as index ranges [first, end)."""
    to_edges(child)
    mesh = sleeve.evaluated(child).data
    pairs = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", pairs)
    joined = np.zeros(len(mesh.vertices) + 1, bool)  # whether point i goes on to point i + 1
    pairs = np.sort(pairs.reshape(-1, 2), axis=1)
    assert (pairs[:, 1] == pairs[:, 0] + 1).all(), "points are not in order"
    joined[pairs[:, 0]] = True
    ends = np.flatnonzero(~joined[:len(mesh.vertices)]) + 1
    starts = np.concatenate([[0], ends[:-1]]) if len(ends) else ends
    values = {name: compat.read_attribute(mesh.attributes[name])[:, 0] for name in ATTRIBUTES
              if name in mesh.attributes}
    return np.stack([starts, ends], 1), compat.positions(mesh).copy(), values


def solved(garment: bpy.types.Object) -> Any:
    """The curves of the frame that was solved last."""
    runtime = runtimes.of(garment)
    return runtime.evaluator.curves(runtime.inputs.frame, runtime.inputs.positions, runtime.inputs.settings)


def same(test: unittest.TestCase, garment: bpy.types.Object, child: bpy.types.Object) -> int:
    """What is seen is what was solved, to rounding; numbers and sizes to the bit. Returns how many curves there are."""
    curves, positions, values = seen(child)
    expected = solved(garment)
    test.assertEqual(len(curves), len(expected.id))
    if not len(curves):
        return 0
    np.testing.assert_array_equal(curves[:, 0], expected.start[:-1])
    np.testing.assert_allclose(positions, expected.positions, atol=2e-6)
    np.testing.assert_array_equal(values["rumple_path_id"], np.repeat(expected.id, np.diff(expected.start)))
    np.testing.assert_array_equal(values["rumple_path_height"], expected.height)
    np.testing.assert_array_equal(values["rumple_path_width"], expected.width)
    return len(curves)


def child_of(garment: bpy.types.Object) -> bpy.types.Object:
    """Its curves; there must be one object."""
    child, = path_curves.of(garment)
    return child
