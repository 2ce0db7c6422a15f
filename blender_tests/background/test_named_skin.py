# SPDX-License-Identifier: GPL-3.0-or-later
"""Skin in the mesh of its clothes is found by its material's name and painted by the first click."""
from __future__ import annotations

import unittest

import bmesh
import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import bodies, mesh_reader
from support import sleeve

FOLLOW, SMOOTH = "Rumple Follow", "Rumple Keep Smooth"


def weights(obj: bpy.types.Object, name: str) -> np.ndarray:
    return mesh_reader.group_weights(obj, obj.data, [name])[:, 0]


class Welded(unittest.TestCase):
    """A sleeve that is welded to a hand: its last third, closed at the end. The other end is a closed shoulder."""

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        for settings in (self.obj.rumple.mesh, self.obj.rumple.field, self.obj.rumple.paths):
            settings.property_unset("base_cloth")
        work = bmesh.new()
        work.from_mesh(self.obj.data)
        bmesh.ops.holes_fill(work, edges=work.edges)
        for face in work.faces:
            x = face.calc_center_median().x / sleeve.LENGTH
            face.material_index = int(x > 0.66 or x < 0.1)
        work.to_mesh(self.obj.data)
        work.free()
        self.name_materials("Shirt", "Skin")

    def name_materials(self, *names: str) -> None:
        for slot, name in zip(self.obj.material_slots, names):
            slot.material.name = name

    def click(self, method: str = "MESH") -> str:
        """What it says."""
        return sleeve.click(self.obj, method)

    def skin(self) -> np.ndarray:
        """(n,) bool: the vertices of its faces."""
        mesh = self.obj.data
        faces = np.repeat(compat.indices(mesh.polygons, "material_index") == 1,
                          compat.indices(mesh.polygons, "loop_total"))
        return np.isin(np.arange(len(mesh.vertices)), compat.corner_vertices(mesh)[faces])

    def test_the_rest_becomes_cloth(self) -> None:
        """A figure in one mesh has no opening, and was no cloth: its face folded, and its shirt did not hang."""
        said = self.click()
        self.assertIn("Sleeve: by their names, these materials are not cloth, and stay as they are animated: Skin. "
                      "To change that, paint Pinned and Keep Smooth", said)
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")
        np.testing.assert_array_equal(weights(self.obj, SMOOTH), self.skin())
        follow, along = weights(self.obj, FOLLOW), compat.positions(self.obj.data)[:, 0] / sleeve.LENGTH
        self.assertEqual(follow[self.skin()].min(), 1.0)
        self.assertEqual(follow[np.abs(along - 0.4) < 0.05].max(), 0.0)

    def test_loose_skin_of_any_shape(self) -> None:
        """A body that was deleted under clothes had too many openings to be known by its shape: it folded as cloth."""
        work = bmesh.new()
        work.from_mesh(self.obj.data)
        bmesh.ops.split(work, geom=[face for face in work.faces if face.material_index == 1])
        for vertex in {vertex for face in work.faces if face.material_index == 1 for vertex in face.verts}:
            vertex.co.x += 0.02 if vertex.co.x > 0.5 * sleeve.LENGTH else -0.02
        work.to_mesh(self.obj.data)
        work.free()
        self.assertIn("animated: Skin. To change", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")
        np.testing.assert_array_equal(weights(self.obj, SMOOTH), self.skin())

    def test_under_a_jacket(self) -> None:
        """It was taken for a body, since another garment lies over it. Clicked in any order, each is cloth."""
        for order in ((0, 1), (1, 0)):
            with self.subTest(order):
                self.setUp()
                mesh = sleeve.tube("Jacket")
                for vertex in mesh.vertices:
                    vertex.co.x = 0.15 * sleeve.LENGTH + 0.45 * vertex.co.x
                    vertex.co.yz *= 1.15
                jacket = sleeve.skinned(mesh, bpy.data.objects["Arm"], "Jacket")
                jacket.rumple.mesh.property_unset("base_cloth")
                figure = self.obj
                for number in order:
                    self.obj = (figure, jacket)[number]
                    self.click()
                self.assertEqual([obj.rumple.mesh.base_cloth for obj in (figure, jacket)], ["HANG", "HANG"])
                self.assertEqual([[body.name for body in bodies.of(obj)] for obj in (figure, jacket)], [[], ["Sleeve"]])
                sleeve.play()
                self.assertEqual([figure.rumple.message, jacket.rumple.message], ["", ""])

    def test_a_collar_stays_pinned(self) -> None:
        """As it is without a map: the shoulder is open here, and cloth."""
        work = bmesh.new()
        work.from_mesh(self.obj.data)
        bmesh.ops.delete(work, context="FACES_ONLY", geom=[
            face for face in work.faces if face.calc_center_median().x < 0.01 * sleeve.LENGTH])
        for face in work.faces:
            face.material_index = int(face.calc_center_median().x > 0.66 * sleeve.LENGTH)
        work.to_mesh(self.obj.data)
        work.free()
        self.click()
        follow, along = weights(self.obj, FOLLOW), compat.positions(self.obj.data)[:, 0]
        self.assertGreater(follow[along == 0.0].min(), 0.9)
        self.assertEqual(follow[self.skin()].min(), 1.0)

    def test_the_skin_stays_and_the_cloth_moves(self) -> None:
        self.click()
        self.obj.rumple.mesh.display_steps = 0
        sleeve.at(1)
        rest = sleeve.shown(self.obj) - sleeve.attribute(self.obj, "rumple_offset")
        sleeve.play()
        moved = np.linalg.norm(sleeve.attribute(self.obj, "rumple_offset"), axis=1)
        ring = 1.0 / (sleeve.ALONG - 1)
        hand = rest[:, 0] / sleeve.LENGTH > 0.66 + 2.0 * ring
        self.assertLess(moved[hand].max(), 1e-5)
        self.assertGreater(moved[~hand].max(), 1e-3)

    def test_every_system_that_can_be_pinned(self) -> None:
        for method in ("FIELD", "PATHS"):
            with self.subTest(method):
                self.click(method)
                self.assertEqual(weights(self.obj, FOLLOW)[self.skin()].min(), 1.0)
                np.testing.assert_array_equal(weights(self.obj, SMOOTH), self.skin())
                bpy.ops.object.rumple_remove()
                for name in (FOLLOW, SMOOTH):
                    self.obj.vertex_groups.remove(self.obj.vertex_groups[name])

    def test_other_names_say_nothing(self) -> None:
        for names in (("Shirt", "Body"), ("Shirt", "Hand Band"), ("Skin", "Head")):
            with self.subTest(names):
                self.name_materials(*names)
                self.assertNotIn("by their names", self.click())
                self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")
                self.assertFalse({FOLLOW, SMOOTH} & set(self.obj.vertex_groups.keys()))
                bpy.ops.object.rumple_remove()

    def test_what_is_painted_stays(self) -> None:
        group = self.obj.vertex_groups.new(name=SMOOTH)
        group.add([3], 0.5, "REPLACE")
        self.click()
        self.assertEqual(weights(self.obj, SMOOTH).sum(), 0.5)
        self.assertEqual(weights(self.obj, FOLLOW)[self.skin()].min(), 1.0)
        bpy.ops.object.rumple_remove()
        self.obj.vertex_groups[FOLLOW].add([3], 0.25, "REPLACE")
        self.assertNotIn("by their names", self.click())
        self.assertEqual(weights(self.obj, FOLLOW)[3], 0.25)

    def test_of_half_a_mesh_with_a_mirror(self) -> None:
        """The maps are painted on the artist's half."""
        work = bmesh.new()
        work.from_mesh(self.obj.data)
        bmesh.ops.bisect_plane(work, geom=[*work.verts, *work.edges, *work.faces], plane_co=(0.0, 0.0, 0.0),
                               plane_no=(0.0, 0.0, 1.0), clear_outer=True)
        work.to_mesh(self.obj.data)
        work.free()
        self.obj.modifiers.new("Mirror", "MIRROR").use_axis = (False, False, True)
        sleeve.make_active(self.obj)
        bpy.ops.object.modifier_move_up(modifier="Mirror")
        self.assertIn("by their names", self.click())
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")
        np.testing.assert_array_equal(weights(self.obj, SMOOTH), self.skin())


if __name__ == "__main__":
    unittest.main()
