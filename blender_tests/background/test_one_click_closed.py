# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment in an object of its own whose ends are closed, as in kits of characters for games."""
from __future__ import annotations

import unittest

import bmesh
import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import painted_maps
from support import sleeve


class Closed(unittest.TestCase):
    """A sleeve whose ends are closed. It points down from a head that shares its armature."""

    def setUp(self) -> None:
        self.obj = sleeve.to_be_cloth()
        work = bmesh.new()
        work.from_mesh(self.obj.data)
        bmesh.ops.holes_fill(work, edges=work.edges)
        work.to_mesh(self.obj.data)
        work.free()
        for name in ("Arm", "Human", "Sleeve"):
            bpy.data.objects[name].rotation_euler = (0.0, np.pi / 2.0, 0.0)  # x points down
        self.lift(1.0)
        bpy.context.view_layer.update()

    def lift(self, share: float) -> None:
        """Move the body upwards by a share of the sleeve's length. 1: it is a head above it."""
        arm = bpy.data.objects["Human"]
        rest = compat.positions(arm.data)
        rest[:, 0] -= share * sleeve.LENGTH
        arm.data.vertices.foreach_set("co", rest.ravel())
        arm.data.update()

    def click(self, method: str = "MESH") -> str:
        """What it says."""
        return sleeve.click(self.obj, method)

    def test_it_is_cloth_that_is_held_by_its_upper_end(self) -> None:
        self.assertIn("its ends are closed, so it is cloth that is held by its upper end", self.click())
        settings = self.obj.rumple.mesh
        self.assertEqual((settings.base_cloth, settings.layers, self.obj.rumple.body), ("HANG", "CLOTH", None))
        held, along = painted_maps.follow_weights(self.obj), compat.positions(self.obj.data)[:, 0]
        self.assertEqual(held[along == 0.0].min(), 1.0)
        self.assertEqual(held[along > 0.2 * sleeve.LENGTH].max(), 0.0)
        sleeve.play()
        self.assertEqual(self.obj.rumple.message, "")
        self.assertGreater(np.abs(sleeve.attribute(self.obj, "rumple_offset")).max(), 1e-3)

    def test_with_a_body_in_it_it_is_none(self) -> None:
        """Its closed end would be inside of the body, and pull the waist below the skin."""
        self.lift(-0.7)
        self.assertIn("fewer than two openings", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")

    def test_every_system(self) -> None:
        for method in ("FIELD", "PATHS"):
            with self.subTest(method):
                self.assertIn("its ends are closed", self.click(method))
                self.assertEqual(getattr(self.obj.rumple, method.lower()).base_cloth, "HANG")
                bpy.ops.object.rumple_remove()

    def test_skin_by_the_names_of_all_its_materials_is_none(self) -> None:
        for slot in self.obj.material_slots:
            slot.material.name = "Skin"
        self.assertNotIn("its ends are closed", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")

    def test_without_a_head_it_is_none(self) -> None:
        bpy.data.objects.remove(bpy.data.objects["Human"])
        self.assertNotIn("its ends are closed", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")

    def test_what_one_bone_moves_is_none(self) -> None:
        self.obj.vertex_groups["lower"].remove(range(len(self.obj.data.vertices)))
        self.assertNotIn("its ends are closed", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")
