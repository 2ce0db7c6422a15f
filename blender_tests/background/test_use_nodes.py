# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials with Use Nodes off, until Blender 4: they keep their look with our nodes, and are again as they were
without."""
from __future__ import annotations

import unittest
from typing import Any

import bpy
import numpy as np
from rumple.blender.nodes import field_shader, maps_shader
from support import face, sleeve

LOOK = dict(diffuse_color=(1.0, 0.25, 0.0, 1.0), roughness=0.9, metallic=0.125, specular_intensity=0.0625)


def plain() -> bpy.types.Material:
    """Red, without a tree."""
    material = bpy.data.materials.new("Red")
    for name, value in LOOK.items():
        setattr(material, name, value)
    return material


def switched_off() -> bpy.types.Material:
    """A tree of the artist, green, that is switched off."""
    material = bpy.data.materials.new("Green")
    material.use_nodes = True
    principled(material).inputs["Base Color"].default_value = (0.0, 1.0, 0.0, 1.0)
    material.use_nodes = False
    return material


def principled(material: bpy.types.Material) -> bpy.types.Node:
    return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")


def look(material: bpy.types.Material) -> dict[str, Any]:
    """Of its Principled shader, by the names of LOOK."""
    inputs = principled(material).inputs
    specular = "Specular" if "Specular" in inputs else "Specular IOR Level"
    return dict(diffuse_color=tuple(inputs["Base Color"].default_value), roughness=inputs["Roughness"].default_value,
                metallic=inputs["Metallic"].default_value, specular_intensity=inputs[specular].default_value)


class WithoutNodes(unittest.TestCase):

    def has_look(self, material: bpy.types.Material) -> None:
        self.assertTrue(material.use_nodes)
        for name, value in look(material).items():
            np.testing.assert_array_equal(value, getattr(material, name), err_msg=name)


@unittest.skipIf(bpy.app.version >= (5, 0, 0), "there all materials have nodes")
class OfAField(WithoutNodes):

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)

    def wear(self, material: bpy.types.Material) -> None:
        for slot in self.obj.material_slots:
            slot.material = material

    def waves_go_in_and_out(self, material: bpy.types.Material, between: Any = lambda: None) -> None:
        with sleeve.context():
            bpy.ops.object.rumple_add(method="FIELD")
            self.assertTrue(material.use_nodes and field_shader.shows_waves(material))
            between()
            bpy.ops.object.rumple_remove()
        self.assertFalse(field_shader.shows_waves(material))

    def test_a_plain_material_keeps_its_look_and_is_plain_again(self) -> None:
        """A red garment was rendered grey, and so it stayed when the waves were removed."""
        self.wear(material := plain())
        for red in (1.0, 0.5):  # the tree of the first time is still there at the second
            material.diffuse_color = red, 0.25, 0.0, 1.0
            self.waves_go_in_and_out(material, lambda: self.has_look(material))
            self.assertFalse(material.use_nodes)

    def test_a_tree_that_was_switched_off_is_left_alone(self) -> None:
        self.wear(material := switched_off())
        self.waves_go_in_and_out(material)
        self.assertFalse(material.use_nodes)
        self.assertEqual(look(material)["diffuse_color"], (0.0, 1.0, 0.0, 1.0))

    def test_a_tree_that_was_switched_on_stays_on(self) -> None:
        self.wear(material := switched_off())
        material.use_nodes = True
        self.waves_go_in_and_out(material)
        self.assertTrue(material.use_nodes)

    def test_nodes_that_the_artist_changed_meanwhile_stay_on(self) -> None:
        """Who gives the new shader a colour wants to see it, also without waves and when they come again."""
        self.wear(material := plain())

        def paint() -> None:
            principled(material).inputs["Base Color"].default_value = (0.0, 0.0, 1.0, 1.0)
        self.waves_go_in_and_out(material, paint)
        self.assertTrue(material.use_nodes)
        self.waves_go_in_and_out(material)
        self.assertTrue(material.use_nodes)
        self.assertEqual(look(material)["diffuse_color"], (0.0, 0.0, 1.0, 1.0))


@unittest.skipIf(bpy.app.version >= (5, 0, 0), "there all materials have nodes")
class OfMaps(WithoutNodes):

    def setUp(self) -> None:
        self.obj, rig = face.scene()
        face.two_poses(self.obj, rig)

    def shown(self, material: bpy.types.Material) -> None:
        self.obj.data.materials[0] = material
        self.assertEqual(bpy.ops.rumple.maps_show(), {"FINISHED"})
        self.assertTrue(material.use_nodes)
        self.assertEqual(maps_shader.shown_in(material), self.obj.rumple_maps.group)

    def test_a_plain_material_shows_maps_and_is_plain_again(self) -> None:
        """It was refused."""
        self.shown(material := plain())
        self.has_look(material)
        bpy.ops.rumple.maps_hide()
        self.assertFalse(material.use_nodes)

    def test_a_tree_that_was_switched_off_shows_maps(self) -> None:
        """The button said that it was done, and nothing was seen."""
        self.shown(material := switched_off())
        bpy.ops.rumple.maps_hide()
        self.assertFalse(material.use_nodes)
        self.shown(material)
        material.use_nodes = False  # by hand, and shown again
        self.shown(material)

    def test_what_is_refused_is_not_switched_on(self) -> None:
        material = switched_off()
        material.node_tree.nodes.remove(principled(material))
        self.obj.data.materials[0] = material
        with self.assertRaisesRegex(RuntimeError, "has no shader that takes a normal"):
            bpy.ops.rumple.maps_show()
        self.assertFalse(material.use_nodes)

    def test_while_waves_or_maps_need_its_nodes_they_stay_on(self) -> None:
        self.shown(material := plain())
        field_shader.shade(material, self.obj)
        bpy.ops.rumple.maps_hide()
        self.has_look(material)
        field_shader.unshade(material)
        self.assertFalse(material.use_nodes)
