# SPDX-License-Identifier: GPL-3.0-or-later
"""A wrinkled object whose nodes read another wrinkled one, as a strap that lies on a shirt."""
from __future__ import annotations

import unittest
from typing import Any

import bpy
from rumple.blender import compat
from rumple.blender.objects import modifier
from support import sleeve
from test_layers import Follower


def nodes_that_lie_on(kind: str) -> bpy.types.NodeTree:
    """A group that moves its points to the closest ones of an object, or of those in a collection."""
    group = bpy.data.node_groups.new("Lie On", "GeometryNodeTree")
    for name, way, socket in (("Geometry", "INPUT", "Geometry"), ("On", "INPUT", kind),
                              ("Geometry", "OUTPUT", "Geometry")):
        compat.new_group_socket(group, name, way, f"NodeSocket{socket}")
    row = [group.nodes.new(name) for name in ("NodeGroupInput", "GeometryNodeSetPosition", "NodeGroupOutput")]
    for before, after in zip(row, row[1:]):
        group.links.new(before.outputs[0], after.inputs[0])
    read, whole, closest = (group.nodes.new(name) for name in (
        f"GeometryNode{kind}Info", "GeometryNodeRealizeInstances", "GeometryNodeProximity"))
    read.transform_space = "RELATIVE"
    group.links.new(row[0].outputs["On"], read.inputs[kind])
    group.links.new(next(out for out in read.outputs if out.type == "GEOMETRY"), whole.inputs[0])
    group.links.new(whole.outputs[0], closest.inputs[0])
    group.links.new(compat.socket(closest.outputs, "Position"), row[1].inputs["Position"])
    return group


def strap(name: str, other: Any, kind: str) -> bpy.types.Object:
    """A wrinkled tube that lies on an object, or on what is in a collection."""
    obj = sleeve.another(name, 1.3)
    made = obj.modifiers.new("Lie On", "NODES")
    made.node_group = group = nodes_that_lie_on(kind)
    compat.set_modifier_input(made, compat.group_sockets(group, "INPUT")["On"], other)
    made.node_group = group  # Blender makes the new relation
    compat.move_modifier(obj, 2, 1)
    sleeve.make_active(obj)
    bpy.context.view_layer.update()
    return obj


class ByNodes(Follower, unittest.TestCase):
    """Only the targets of Shrinkwrap and the like counted: a strap was baked on the folds of the frame before, and it
    was not said that renders have it so without a bake."""

    def follower(self, name: str) -> bpy.types.Object:
        return strap(name, self.sleeve, "Object")


class Recognized(unittest.TestCase):

    def test_by_a_collection(self) -> None:
        other = sleeve.scene()
        inside = bpy.data.collections.new("Under")
        inside.objects.link(other)
        self.assertEqual(modifier.depends_on_wrinkled(strap("Strap", inside, "Collection")), other)

    def test_nodes_below_the_wrinkles_make_nobody_wait(self) -> None:
        obj = strap("Strap", sleeve.scene(), "Object")
        compat.move_modifier(obj, 1, 2)
        self.assertIsNone(modifier.depends_on_wrinkled(obj))
