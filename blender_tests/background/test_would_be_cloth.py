# SPDX-License-Identifier: GPL-3.0-or-later
"""Skinned objects with the shape of a garment that the first click does not make cloth."""
from __future__ import annotations

import unittest

import bpy
from rumple.blender import compat
from support import sleeve


class NotCloth(unittest.TestCase):
    """A sleeve over an arm: two openings, so it has the shape of a garment."""

    def setUp(self) -> None:
        self.obj = sleeve.to_be_cloth()

    def click(self, method: str = "MESH") -> str:
        """What it says."""
        return sleeve.click(self.obj, method)

    def name_materials(self, *names: str) -> None:
        for slot, name in zip(self.obj.material_slots, names):
            slot.material.name = name

    def shrink(self, factor: float) -> None:
        """Make it that much of its size, beside an arm of the former size."""
        rest = compat.positions(self.obj.data)
        self.obj.data.vertices.foreach_set("co", (factor * rest).ravel())
        self.obj.data.update()

    def one_bone(self) -> None:
        self.obj.vertex_groups["lower"].remove(range(len(self.obj.data.vertices)))
        self.obj.vertex_groups["upper"].add(range(len(self.obj.data.vertices)), 1.0, "REPLACE")

    def test_what_is_all_skin_by_name(self) -> None:
        """Bare arms and locks of hair are tubes as well: they hung and folded as sleeves."""
        for names in (("Skin", "Nails"), ("Hair", "Hair"), ("Boots", "Sole"), ("Metal", "Steel")):
            with self.subTest(names):
                self.name_materials(*names)
                self.assertIn("Sleeve: all of its materials name skin, hair, shoes or metal, so it is not made cloth: "
                              "if it is, set Base Cloth to Hang", self.click())
                self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")
                bpy.ops.object.rumple_remove()

    def test_what_is_partly_cloth_is_cloth(self) -> None:
        self.name_materials("Shirt", "Metal")
        self.assertIn("these materials are not cloth, and stay as they are animated: Metal", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")
        self.assertIn("Rumple Keep Smooth", self.obj.vertex_groups)

    def test_a_small_thing_that_one_bone_moves(self) -> None:
        """A lamp in a hand is open at both ends: it sagged and folded."""
        for obj in bpy.data.objects:
            obj.rotation_euler.y = -1.5707964  # X points up: the figure is as tall as the arm is long
        self.one_bone()
        self.shrink(0.2)
        self.assertIn("Sleeve: it is small and one bone moves it, so it is not made cloth", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")

    def test_a_large_one_and_one_that_bends_are_cloth(self) -> None:
        for obj in bpy.data.objects:
            obj.rotation_euler.y = -1.5707964
        self.shrink(0.2)
        self.click()
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG", "a sleeve with two bones")
        bpy.ops.object.rumple_remove()
        self.obj.rumple.mesh.property_unset("base_cloth")
        self.obj.rumple.mesh.property_unset("layers")
        self.shrink(5.0)
        self.one_bone()
        self.click()
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG", "a coat of a doll with one bone")

    def test_what_the_artist_has_set_stays(self) -> None:
        self.name_materials("Skin", "Skin")
        self.obj.rumple.mesh.base_cloth = "HANG"
        self.assertNotIn("not made cloth", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")


if __name__ == "__main__":
    unittest.main()
