# SPDX-License-Identifier: GPL-3.0-or-later
"""The first click finds what a garment is worn over."""
from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import bmesh
import bpy
from mathutils import Euler, Matrix, Vector
from rumple.blender import compat
from rumple.blender.first_click import body_search
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

    def test_what_comes_after_a_click_is_found_by_the_next(self) -> None:
        """To Blender a pointer that was read is set: no click looked for a body again."""
        self.assertEqual(self.found(), "")
        bpy.ops.object.rumple_remove()
        sleeve.under(self.obj, "Human")
        self.assertEqual(self.found(), "Human")
        self.obj.rumple.body = None
        bpy.ops.object.rumple_remove()
        self.assertEqual(self.found(), "")  # the artist wants none

    def test_a_thing_that_hangs_on_a_bone_is_no_body(self) -> None:
        """A book at the belt of a robe was its body; what fills a garment, as the parts of a puppet, is one."""
        for length, shift, body in ((0.05, -0.04, ""), (1.0, 0.0, "Thing")):
            with self.subTest(length):
                thing, rig = sleeve.under(self.obj, "Thing", 0.9), bpy.data.objects["Arm"]
                thing.data.transform(Matrix.Translation((shift, 0, 0)) @ Matrix.Scale(length, 4, Vector((1, 0, 0))))
                thing.modifiers.clear()
                thing.parent, thing.parent_type, thing.parent_bone = rig, "BONE", "upper"
                bpy.context.view_layer.update()
                thing.matrix_world = Matrix.Identity(4)
                bpy.context.view_layer.update()
                self.assertEqual(self.found(), body)
                bpy.ops.object.rumple_remove()
                bpy.data.objects.remove(thing)

    def test_another_garment_is_better_than_nothing(self) -> None:
        sleeve.under(self.obj, "Shirt", 0.9)
        self.assertEqual(self.found(), "Shirt")

    def test_clothes_with_a_thickness_are_worn_over_one_another(self) -> None:
        # As much of the inner side of the trousers lay over the shirt as of the shirt over the trousers: they came
        # through it.
        sleeve.under(self.obj, "Human", 0.7)
        trousers = sleeve.under(self.obj, "Trousers", 0.85)
        trousers.data.transform(Matrix.Translation((0.8 * sleeve.LENGTH, 0.0, 0.0)))
        for garment in (self.obj, trousers):
            solidify = garment.modifiers.new("Thickness", "SOLIDIFY")
            solidify.thickness, solidify.offset = 0.004, -1.0
            compat.move_modifier(garment, len(garment.modifiers) - 1, 0)
            sleeve.make_active(garment)
            bpy.ops.object.modifier_apply(modifier="Thickness")
        worn_over = body_search.find(self.obj, bpy.context.scene)
        self.assertEqual((worn_over.body.name, sleeve.names(worn_over.garments)), ("Human", ["Trousers"]))
        self.assertEqual(body_search.find(trousers, bpy.context.scene).garments, [])

    def test_what_is_no_cloth_is_worn_over_nothing(self) -> None:
        # A face would be put out of the teeth, by the thickness of a cloth.
        sleeve.under(self.obj)
        self.obj.rumple.mesh.base_cloth = "OFF"
        self.assertEqual(self.found(), "")

    def deleted_under_the_garment(self) -> bpy.types.Object:
        """A body with a garment over its middle, where it is mostly deleted. Its hands are dense and wider than cuffs:
        more of it lies over the garment than of the garment over it."""
        body = sleeve.under(self.obj, "Human")
        self.obj.data.transform(Matrix.Translation((0.5 * sleeve.LENGTH, 0, 0)) @ Matrix.Scale(0.6, 4, (1, 0, 0))
                                @ Matrix.Translation((-0.5 * sleeve.LENGTH, 0, 0)))

        def off_middle(place: Vector) -> float:
            return abs(place.x / sleeve.LENGTH - 0.5)

        work = bmesh.new()
        work.from_mesh(body.data)
        hands = [vertex for vertex in work.verts if off_middle(vertex.co) > 0.31]
        for vertex in hands:
            vertex.co.yz *= 1.35
        bmesh.ops.subdivide_edges(work, cuts=2, use_grid_fill=True, edges=[
            edge for edge in work.edges if all(0.3 < off_middle(vertex.co) < 0.42 for vertex in edge.verts)])
        bmesh.ops.delete(work, context="FACES", geom=[
            face for face in work.faces if off_middle(face.calc_center_median()) < 0.2])
        work.to_mesh(body.data)
        work.free()
        bpy.context.view_layer.update()
        return body

    def test_a_body_that_was_deleted_under_its_clothes_is_found(self) -> None:
        body = self.deleted_under_the_garment()
        one, other = ((body_search._cloth(a), body_search.tree_of(b)) for a, b in ((body, self.obj), (self.obj, body)))
        self.assertGreater(body_search._share_over(*one), body_search._share_over(*other))
        near = body_search.tree_of(self.obj, near=one[0])  # what is farther does not change the share
        self.assertEqual(body_search._share_over(one[0], near), body_search._share_over(*one))
        self.assertEqual(self.found(), "Human")
        self.assertNotEqual(self.obj.rumple.mesh.base_cloth, "OFF")

    def test_a_body_is_no_cloth_that_is_worn_over_its_clothes(self) -> None:
        """It hung, and its shirt was refused, for each was worn over the other."""
        body = self.deleted_under_the_garment()
        sleeve.make_active(body)
        for name in ("base_cloth", "layers"):
            body.rumple.mesh.property_unset(name)
        bpy.ops.object.rumple_add(method="MESH")
        self.assertEqual((body.rumple.mesh.base_cloth, body.rumple.body), ("OFF", None))

    def trimming(self, name: str, first: float, last: float) -> bpy.types.Object:
        """Over the sleeve, from a share of its length to another."""
        over = sleeve.under(self.obj, name, 1.08)
        along = Matrix.Translation((first * sleeve.LENGTH, 0, 0)) @ Matrix.Scale(last - first, 4, (1, 0, 0))
        over.data.transform(along)
        bpy.context.view_layer.update()
        return over

    def test_a_belt_or_a_badge_makes_no_body_of_a_skirt(self) -> None:
        """Without a body in the scene, what a small garment lay over wholly was one, and was not made cloth."""
        belt = self.trimming("Belt", 0.1, 0.16)
        badge = self.trimming("Badge", 0.5, 0.7)
        work = bmesh.new()
        work.from_mesh(badge.data)
        bmesh.ops.delete(work, geom=[v for v in work.verts if v.co.y < 0.8 * sleeve.RADIUS], context="VERTS")
        work.to_mesh(badge.data)
        work.free()
        for over in (belt, badge):
            cloth, tree = body_search._cloth(over), body_search.tree_of(self.obj)
            self.assertGreater(body_search._share_over(cloth, tree), 0.9)
        self.assertEqual(self.found(), "")
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "HANG")

    def test_what_is_taken_for_a_body_by_its_clothes_is_told_so(self) -> None:
        """Nothing was said of a skirt with a wide sash."""
        self.trimming("Sash", 0.1, 0.3)
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            self.assertEqual(self.found(), "")
        self.assertEqual(self.obj.rumple.mesh.base_cloth, "OFF")
        self.assertIn("Sleeve: Sash lies over it, so it is taken for a body and is not made cloth: if it is a garment, "
                      "set Base Cloth to Hang", said.getvalue())

    def test_a_body_of_which_little_is_left(self) -> None:
        """Jeans of MakeHuman had a body under a seventh of their vertices, and found none."""
        body = sleeve.under(self.obj, "Human")
        work = bmesh.new()
        work.from_mesh(body.data)
        bmesh.ops.delete(work, context="FACES", geom=[
            face for face in work.faces if face.calc_center_median().x < 0.9 * sleeve.LENGTH])
        work.to_mesh(body.data)
        work.free()
        body.data.transform(Matrix.Translation((0.1 * sleeve.LENGTH, 0, 0)))
        share = body_search._share_over(body_search._cloth(self.obj), body_search.tree_of(body))
        self.assertTrue(0.05 < share < 0.15, share)
        self.assertEqual(self.found(), "Human")

    def test_the_inner_side_of_a_waistband_does_not_lie_over_the_shirt(self) -> None:
        """A shirt over trousers with a thick waistband was not worn over them: as much lay over it as under it."""
        sleeve.under(self.obj, "Human")
        self.obj.data.transform(Matrix.Translation((0.3 * sleeve.LENGTH, 0, 0)))
        trousers = sleeve.under(self.obj, "Trousers", 0.95)
        trousers.data.transform(Matrix.Scale(0.45, 4, (1, 0, 0)))
        lining = sleeve.tube("Lining")
        lining.transform(Matrix.Translation((0.3 * sleeve.LENGTH, 0, 0)) @ Matrix.Diagonal((0.15, 0.9, 0.9, 1)))
        lining.flip_normals()
        work = bmesh.new()
        for mesh in (trousers.data, lining):
            work.from_mesh(mesh)
        work.to_mesh(trousers.data)
        work.free()
        bpy.context.view_layer.update()
        self.assertEqual([other.name for other in body_search.find(self.obj, bpy.context.scene).garments], ["Trousers"])

    def overridden(self, editable: bool) -> None:
        """self.obj is of a figure that is overridden."""
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
                                                            do_fully_editable=editable)
        self.obj = next(obj for obj in bpy.context.scene.objects if obj.name.startswith("Sleeve"))
        self.assertEqual(self.obj.override_library.is_system_override, not editable)

    def test_an_override_finds_it_too(self) -> None:
        """In 3.4 and 4.3 every pointer of one counts as set, to nothing: cloth went through the figure."""
        self.overridden(editable=True)
        self.assertEqual(self.found(), "Human")

    def test_an_override_that_may_not_be_edited_is_refused_in_words(self) -> None:
        """With a Subdivision it ended in a traceback."""
        self.obj.modifiers.new("Subdivision", "SUBSURF")
        self.overridden(editable=False)
        with self.assertRaisesRegex(RuntimeError, "This library override is not editable: make it so first"):
            self.found()
        self.assertNotIn("NODES", [m.type for m in self.obj.modifiers])

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
