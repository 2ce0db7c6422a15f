# SPDX-License-Identifier: GPL-3.0-or-later
"""The first click finds what a garment is worn over."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import bmesh
import bpy
from mathutils import Euler, Matrix
from rumple.blender.objects import runtimes
from support import sleeve


class FirstClick(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.scene(wrinkles=False)
        for name in ("base_cloth", "layers"):  # the click says
            self.obj.rumple.mesh.property_unset(name)

    def found(self) -> str:
        sleeve.make_active(self.obj)
        self.obj.rumple.mesh.density, self.obj.rumple.mesh.level = "LEVEL", 1
        bpy.ops.object.rumple_add(method="MESH")
        return self.obj.rumple.body.name if self.obj.rumple.body is not None else ""

    def test_the_body_among_clothes_and_props(self) -> None:
        sleeve.under(self.obj, "Human")
        sleeve.under(self.obj, "Another Shirt", 0.9)
        sleeve.under(self.obj, "Zz Shirt", 0.85)
        sleeve.under(self.obj, "Jacket", 1.2)
        sleeve.under(self.obj, "Far").data.transform(Matrix.Translation((0, 3, 0)))
        self.assertEqual(self.found(), "Human")
        sleeve.at(4)
        self.assertIsNotNone(runtimes.of(self.obj).inputs.body)

    def test_a_garment_whose_faces_look_inwards(self) -> None:
        # Trousers of a demo chose the shirt over them as their body: skin came through the thighs.
        sleeve.under(self.obj, "Human")
        sleeve.under(self.obj, "Jacket", 1.2)
        self.obj.data.flip_normals()
        self.assertEqual(self.found(), "Human")

    def test_nothing_under_it_is_none(self) -> None:
        sleeve.under(self.obj, "Jacket", 1.2)
        sleeve.under(self.obj, "Far").data.transform(Matrix.Translation((0, 3, 0)))
        apart = sleeve.under(self.obj, "Unskinned")
        apart.modifiers.clear()
        self.assertEqual(self.found(), "")

    def test_another_garment_is_better_than_nothing(self) -> None:
        sleeve.under(self.obj, "Shirt", 0.9)
        self.assertEqual(self.found(), "Shirt")

    def test_what_is_no_cloth_is_worn_over_nothing(self) -> None:
        # A face would be put out of the teeth, by the thickness of a cloth.
        sleeve.under(self.obj)
        self.obj.rumple.mesh.base_cloth = "OFF"
        self.assertEqual(self.found(), "")

    def test_a_body_is_no_cloth_that_is_worn_over_its_clothes(self) -> None:
        """It hung, and its shirt was refused, for each was worn over the other."""
        body = sleeve.under(self.obj, "Human")
        hidden = [face.index for face in body.data.polygons if abs(face.center.x - 0.5 * sleeve.LENGTH) < 0.1]
        work = bmesh.new()  # what clothes cover is mostly deleted
        work.from_mesh(body.data)
        work.faces.ensure_lookup_table()
        bmesh.ops.delete(work, geom=[work.faces[index] for index in hidden], context="FACES")
        work.to_mesh(body.data)
        work.free()
        self.obj.data.transform(Matrix.Translation((0.5 * sleeve.LENGTH, 0, 0)) @ Matrix.Scale(0.6, 4, (1, 0, 0))
                                @ Matrix.Translation((-0.5 * sleeve.LENGTH, 0, 0)))
        sleeve.make_active(body)
        for name in ("base_cloth", "layers"):
            body.rumple.mesh.property_unset(name)
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual((body.rumple.mesh.base_cloth, body.rumple.body), ("OFF", None))
        bpy.ops.object.rumple_remove()
        self.assertEqual(self.found(), "Human")
        self.assertNotEqual(self.obj.rumple.mesh.base_cloth, "OFF")

    def test_an_override_finds_it_too(self) -> None:
        """In 3.4 and 4.3 every pointer of one counts as set, to nothing: cloth went through the figure."""
        sleeve.under(self.obj, "Human")
        figure = bpy.data.collections.new("Figure")
        for obj in list(bpy.context.scene.objects):
            figure.objects.link(obj)
        with tempfile.TemporaryDirectory() as folder:
            library = str(Path(folder) / "library.blend")
            bpy.data.libraries.write(library, {figure}, fake_user=True)
            sleeve.empty_file()
            with bpy.data.libraries.load(library, link=True) as (_, wanted):
                wanted.collections = ["Figure"]
            wanted.collections[0].override_hierarchy_create(bpy.context.scene, bpy.context.view_layer,
                                                            do_fully_editable=True)
            self.obj = next(obj for obj in bpy.context.scene.objects if obj.name.startswith("Sleeve"))
            self.assertIsNotNone(self.obj.override_library)
            self.assertEqual(self.found(), "Human")

    def test_a_simulated_one_is_worn_over_its_body(self) -> None:
        sleeve.under(self.obj)
        self.obj.modifiers.new("Cloth", "CLOTH")
        self.assertEqual(self.found(), "Human")
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")

    def test_placed_alike(self) -> None:
        body = sleeve.under(self.obj)
        matrix = Matrix.LocRotScale((1, 2, 3), Euler((0.4, 1.0, 0.2)), (-2.0, 2.0, 2.0))
        for obj in (self.obj, body):
            obj.data.transform(matrix.inverted())
            obj.data.flip_normals()  # mirrored by both
            obj.matrix_world = matrix
        self.assertEqual(self.found(), "Human")

    def test_by_the_parent(self) -> None:
        body = sleeve.under(self.obj)
        body.modifiers.clear()
        body.parent = bpy.data.objects["Arm"]
        self.assertEqual(self.found(), "Human")

    def test_what_was_set_stays(self) -> None:
        sleeve.under(self.obj)
        other = sleeve.under(self.obj, "Other")
        self.obj.rumple.body = other
        self.assertEqual(self.found(), "Other")
        bpy.ops.object.rumple_remove()
        self.obj.rumple.body = None
        self.assertEqual(self.found(), "")


if __name__ == "__main__":
    unittest.main()
