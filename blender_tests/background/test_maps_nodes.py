# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "Rumple Maps": what it computes, and how it goes into a material and out again."""
from __future__ import annotations

import unittest
from typing import Any

import bpy
import numpy as np
from rumple.blender.nodes import maps_shader
from rumple.core.base.wording import UserError
from support import maps_renders


def links(material: bpy.types.Material) -> Any:
    """All that a node tree is: nodes, their values, and links by name."""
    tree = material.node_tree
    wires = sorted((link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
                   for link in tree.links)
    values = {(node.name, entry.identifier): tuple(entry.default_value) if hasattr(entry.default_value, "__len__")
              else entry.default_value for node in tree.nodes for entry in node.inputs
              if hasattr(entry, "default_value")}
    return wires, values


class Blend(unittest.TestCase):

    def test_cycles_shows_the_native_blend(self) -> None:
        maps_renders.check(self, "CYCLES")

    def test_a_pose_without_an_image_does_not_count(self) -> None:
        quad = maps_renders.Quad(3, "WRINKLES")
        textures = [node for node in quad.group.nodes if node.type == "TEX_IMAGE"]
        images = sorted({node.image for node in textures}, key=lambda image: image.name)
        maps_shader.fill(quad.group, [images[0], None, images[2]], "WRINKLES", "")
        quad.wrinkles[1] = np.full_like(quad.wrinkles[1], 128)
        quad.slopes[1] = 0.0
        self.assertLessEqual(np.abs(quad.rendered("CYCLES") - quad.expected()).max(), maps_renders.STEP)

    def test_without_poses_the_neutral_map_is_left(self) -> None:
        quad = maps_renders.Quad(1, "WRINKLES")
        maps_shader.fill(quad.group, (), "WRINKLES", "")
        self.assertLessEqual(np.abs(quad.rendered("CYCLES") - quad.neutral / 255.0).max(), 2 * maps_renders.STEP)


class InAMaterial(unittest.TestCase):

    def setUp(self) -> None:
        self.group = maps_shader.new_group("Face")
        self.material = bpy.data.materials.new("Skin")
        if bpy.app.version < (5, 0, 0):
            self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.shader = next(node for node in self.tree.nodes if node.type == "BSDF_PRINCIPLED")

    def node(self, kind: str, **properties: object) -> bpy.types.Node:
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        return node

    def goes_in_and_out(self) -> None:
        before = links(self.material)
        maps_shader.insert(self.material, self.group)
        within = links(self.material)
        self.assertNotEqual(within, before)
        self.assertEqual(maps_shader.shown_in(self.material), self.group)
        maps_shader.insert(self.material, self.group)    # once more: nothing new
        self.assertEqual(links(self.material), within)
        self.assertTrue(maps_shader.remove(self.material))
        self.assertEqual(links(self.material), before)
        self.assertIsNone(maps_shader.shown_in(self.material))
        self.assertFalse(maps_shader.remove(self.material))
        maps_shader.insert(self.material, self.group)

    def behind(self, node: bpy.types.Node, name: str) -> bpy.types.Node:
        return node.inputs[name].links[0].from_node

    def test_with_an_image(self) -> None:
        image, normal_map = self.node("ShaderNodeTexImage"), self.node("ShaderNodeNormalMap")
        self.tree.links.new(image.outputs["Color"], normal_map.inputs["Color"])
        self.tree.links.new(normal_map.outputs["Normal"], self.shader.inputs["Normal"])
        self.goes_in_and_out()
        ours = self.behind(self.behind(self.shader, "Normal"), "Color")
        self.assertEqual(ours.node_tree, self.group)
        self.assertEqual(self.behind(ours, maps_shader.INPUT), image)

    def test_without_a_normal_map_one_is_made(self) -> None:
        self.goes_in_and_out()
        ours = self.behind(self.behind(self.shader, "Normal"), "Color")
        self.assertEqual(tuple(ours.inputs[maps_shader.INPUT].default_value), maps_shader.FLAT)

    def test_a_bump_lies_on_the_wrinkles(self) -> None:
        bump, reroute = self.node("ShaderNodeBump"), self.node("NodeReroute")
        self.tree.links.new(bump.outputs["Normal"], reroute.inputs[0])
        self.tree.links.new(reroute.outputs[0], self.shader.inputs["Normal"])
        self.goes_in_and_out()
        self.assertEqual(self.behind(bump, "Normal").type, "NORMAL_MAP")

    def test_two_shaders_share_a_normal_map_or_have_none(self) -> None:
        mixed, other, normal_map = (self.node(kind) for kind in ("ShaderNodeMixShader", "ShaderNodeBsdfDiffuse",
                                                                 "ShaderNodeNormalMap"))
        output = self.tree.get_output_node("ALL")
        self.tree.links.new(self.shader.outputs[0], mixed.inputs[1])
        self.tree.links.new(other.outputs[0], mixed.inputs[2])
        self.tree.links.new(mixed.outputs[0], output.inputs["Surface"])
        self.goes_in_and_out()
        self.assertEqual(self.behind(self.shader, "Normal"), self.behind(other, "Normal"))
        maps_shader.remove(self.material)
        for shader in (self.shader, other):
            self.tree.links.new(normal_map.outputs["Normal"], shader.inputs["Normal"])
        self.goes_in_and_out()
        self.assertEqual(len([node for node in self.tree.nodes if node.type == "GROUP"]), 1)

    def refused(self, word: str, group: str | None = None) -> None:
        before = links(self.material)
        with self.assertRaisesRegex(UserError, word):
            maps_shader.insert(self.material, group or self.group)
        self.assertEqual(links(self.material), before)

    def test_what_cannot_be_blended_is_refused_and_left_alone(self) -> None:
        normal_map = self.node("ShaderNodeNormalMap", space="OBJECT")
        self.tree.links.new(normal_map.outputs["Normal"], self.shader.inputs["Normal"])
        self.refused(f"{self.material.name}: the normal of Principled BSDF comes from Normal Map, which is no Normal")
        geometry = self.node("ShaderNodeNewGeometry")
        self.tree.links.new(geometry.outputs["Normal"], self.shader.inputs["Normal"])
        self.refused("comes from Geometry")
        self.tree.nodes.remove(self.shader)
        self.refused(f"{self.material.name} has no shader that takes a normal")

    def test_the_maps_of_another_object_are_not_replaced(self) -> None:
        maps_shader.insert(self.material, self.group)
        self.refused("shows the maps of another object", maps_shader.new_group("Other"))
