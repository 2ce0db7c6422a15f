# SPDX-License-Identifier: GPL-3.0-or-later
"""A painted map that is made from a material."""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import mesh_reader
from support import sleeve

RADIUS, SMOOTH = "Rumple Radius", "Rumple Keep Smooth"
RING = sleeve.LENGTH / (sleeve.ALONG - 1)  # from one ring of the sleeve to the next


def weights(obj: bpy.types.Object, name: str) -> np.ndarray:
    return mesh_reader.group_weights(obj, obj.data, [name])[:, 0]


class FromMaterial(unittest.TestCase):
    """Three quads in a row: skin, a belt, and one whose material number is too large, which has the last material."""

    def row(self) -> bpy.types.Object:
        sleeve.empty_file()
        mesh = bpy.data.meshes.new("Row")
        mesh.from_pydata([(x, y, 0) for x in range(4) for y in range(2)], [],
                         [(2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1) for k in range(3)])
        for name in ("Skin", "Belt", "Cloth"):
            mesh.materials.append(bpy.data.materials.new(name))
        mesh.polygons.foreach_set("material_index", (0, 1, 7))
        obj = bpy.data.objects.new("Row", mesh)
        bpy.context.scene.collection.objects.link(obj)
        sleeve.make_active(obj)
        bpy.ops.object.rumple_add(method="MESH")
        return obj

    def paint(self, **how: object) -> None:
        self.assertEqual(bpy.ops.object.rumple_paint_from_material(**how), {"FINISHED"})

    def test_its_faces_with_their_border_and_the_rest_stays(self) -> None:
        obj = self.row()
        self.paint(group="smooth", material="Skin")
        np.testing.assert_array_equal(weights(obj, SMOOTH), (1, 1, 1, 1, 0, 0, 0, 0))
        self.paint(group="smooth", material="Cloth", weight=0.25)
        np.testing.assert_array_equal(weights(obj, SMOOTH), (1, 1, 1, 1, 0.25, 0.25, 0.25, 0.25))

    def test_maps_that_are_1_get_0(self) -> None:
        obj = self.row()
        self.paint(group="radius", material="Belt")
        np.testing.assert_array_equal(weights(obj, RADIUS), (1, 1, 0, 0, 0, 0, 1, 1))
        self.paint(group="radius", material="Belt", weight=1.0)
        np.testing.assert_array_equal(weights(obj, RADIUS), np.ones(8))

    def test_a_mask_limits_it(self) -> None:
        obj = self.row()
        obj.data.use_paint_mask_vertex = True
        obj.data.vertices.foreach_set("select", np.arange(8) % 2 == 0)
        self.paint(group="smooth", material="Skin")
        np.testing.assert_array_equal(weights(obj, SMOOTH), (1, 0, 1, 0, 0, 0, 0, 0))

    def test_a_material_of_the_object_counts(self) -> None:
        """Not that of the mesh, in the same slot."""
        obj = self.row()
        obj.material_slots[1].link = "OBJECT"
        obj.material_slots[1].material = bpy.data.materials.new("Strap")
        self.paint(group="smooth", material="Strap")
        np.testing.assert_array_equal(weights(obj, SMOOTH), (0, 0, 1, 1, 1, 1, 0, 0))
        with self.assertRaisesRegex(RuntimeError, "Row: it has no material \"Belt\""):
            bpy.ops.object.rumple_paint_from_material(group="smooth", material="Belt")

    def test_what_is_missing_is_said(self) -> None:
        obj = self.row()
        obj.data.polygons.foreach_set("material_index", (0, 0, 0))
        for name, why in (("", "it has no material \"\": choose one"), ("Belt", "no face has the material \"Belt\"")):
            with self.assertRaisesRegex(RuntimeError, f"Row: {why}"):
                bpy.ops.object.rumple_paint_from_material(group="smooth", material=name)
        obj.data.materials.clear()
        obj.data.materials.append(None)
        with self.assertRaisesRegex(RuntimeError, "Row: it has no material to paint by: give its faces one"):
            bpy.ops.object.rumple_paint_from_material(group="smooth")
        self.assertNotIn(SMOOTH, obj.vertex_groups)

    def test_welded_skin_stays_as_it_is_animated(self) -> None:
        """A sleeve, half of which is skin. From its second ring on it stays; the smooth surface of the first ring is
        bent by the cloth beside it."""
        obj = sleeve.scene(wrinkles=False)
        mesh = obj.data
        mesh.materials.clear()
        for name in ("Cloth", "Skin"):
            mesh.materials.append(bpy.data.materials.new(name))
        skin = np.arange(len(mesh.polygons)) >= len(mesh.polygons) // 2
        mesh.polygons.foreach_set("material_index", skin.astype(np.int32))
        bpy.ops.object.rumple_add(method="MESH")
        obj.rumple.mesh.base_cloth, obj.rumple.mesh.layers = "HANG", "CLOTH"
        for group in ("follow", "smooth"):
            self.paint(group=group, material="Skin")
        sleeve.at(1)
        rest = sleeve.shown(obj) - sleeve.attribute(obj, "rumple_offset")
        sleeve.play()
        moved = np.linalg.norm(sleeve.attribute(obj, "rumple_offset"), axis=1)
        along = int(np.argmax(np.ptp(rest, axis=0)))
        second = compat.positions(mesh)[weights(obj, SMOOTH) == 1.0, along].min() + RING
        of_skin = rest[:, along] > second - 0.1 * RING
        self.assertTrue(0.3 < of_skin.mean() < 0.7)
        self.assertLess(moved[of_skin].max(), 1e-5)
        self.assertGreater(moved[~of_skin].max(), 1e-3)


if __name__ == "__main__":
    unittest.main()
