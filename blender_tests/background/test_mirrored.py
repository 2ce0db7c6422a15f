# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments and bodies that were modelled as one half, with a Mirror modifier that stands behind what poses them: an
armature as parent poses a mesh before all modifiers."""
from __future__ import annotations

import unittest

import bmesh
import bpy
import numpy as np
from mathutils import Matrix
from rumple.blender import compat
from rumple.blender.first_click import body_search, cloth_defaults
from rumple.blender.objects import incoming_mesh, modifier, painted_maps, runtimes
from support import sleeve
from support.arriving import Arriving


def halve(obj: bpy.types.Object, axis: int) -> None:
    """What is below 0 stays, and a Mirror behind all other modifiers makes the whole. The arm bends about z."""
    work = bmesh.new()
    work.from_mesh(obj.data)
    bmesh.ops.delete(work, geom=[v for v in work.verts if v.co[axis] > 1e-5], context="VERTS")
    work.to_mesh(obj.data)
    work.free()
    obj.modifiers.new("Mirror", "MIRROR").use_axis = [number == axis for number in range(3)]


def follow_as_child(obj: bpy.types.Object) -> None:
    obj.modifiers.remove(obj.modifiers["Armature"])
    obj.parent, obj.parent_type = bpy.data.objects["Arm"], "ARMATURE"


class Garments(Arriving, unittest.TestCase):
    """Each was solved as one half, whose edge in the middle hung free; half a skirt counted as a cape."""

    def setUp(self) -> None:
        self.obj = sleeve.to_be_cloth()
        self.vertices = len(self.obj.data.vertices)

    def click(self) -> None:
        self.obj.rumple.mesh.density, self.obj.rumple.mesh.level, self.obj.rumple.mesh.display_steps = "LEVEL", 1, 0
        sleeve.make_active(self.obj)
        self.assertEqual(bpy.ops.object.rumple_add(method="MESH"), {"FINISHED"})
        bpy.context.view_layer.update()

    def check_whole(self) -> None:
        self.check(self.obj)
        self.assertEqual(runtimes.of(self.obj).evaluator.coarse_count, self.vertices)
        self.assertEqual((self.obj.rumple.mesh.base_cloth, self.obj.rumple.body.name), ("HANG", "Human"))
        self.assertTrue(np.isclose(sleeve.shown(self.obj)[:, 2].max(), -sleeve.shown(self.obj)[:, 2].min(), atol=0.03))

    def test_a_child_of_an_armature(self) -> None:
        halve(self.obj, 2)
        follow_as_child(self.obj)
        self.click()
        self.check_whole()

    def test_behind_the_armature(self) -> None:
        halve(self.obj, 2)
        self.click()
        self.assertEqual([m.type for m in self.obj.modifiers], ["ARMATURE", "MIRROR", "NODES"])
        self.check_whole()

    def test_a_child_of_a_bone(self) -> None:
        """It does not bend: it gets folds of its shape keys, on the whole of it."""
        halve(self.obj, 2)
        follow_as_child(self.obj)
        self.obj.parent_type, self.obj.parent_bone = "BONE", "lower"
        self.obj.shape_key_add(name="Basis")
        short = self.obj.shape_key_add(name="Short")
        for point in short.data:
            point.co.x *= 0.7
        short.value = 1.0
        self.click()
        self.check(self.obj)
        self.assertEqual(runtimes.of(self.obj).evaluator.coarse_count, self.vertices)

    def test_a_mirror_that_is_off_counts_for_nothing(self) -> None:
        mirror = self.obj.modifiers.new("Mirror", "MIRROR")
        mirror.show_viewport = mirror.show_render = False
        self.click()
        self.assertEqual([m.type for m in self.obj.modifiers], ["ARMATURE", "NODES", "MIRROR"])


class Bodies(unittest.TestCase):

    def setUp(self) -> None:
        self.obj = sleeve.to_be_cloth()
        self.body = bpy.data.objects["Human"]

    def cut(self, obj: bpy.types.Object, *axes: int, least: float = -1e-5) -> None:
        """What is above stays."""
        work = bmesh.new()
        work.from_mesh(obj.data)
        bmesh.ops.delete(work, geom=[v for v in work.verts if any(v.co[axis] < least for axis in axes)],
                         context="VERTS")
        work.to_mesh(obj.data)
        work.free()

    def test_half_a_body_is_whole_by_whatever_it_is_posed(self) -> None:
        halve(self.body, 1)
        self.cut(self.obj, 1)  # the garment is over the other half
        for as_child in (False, True):
            if as_child:
                follow_as_child(self.body)
            with incoming_mesh.whole([self.body]):
                self.assertEqual(len(incoming_mesh.of(self.body).vertices), sleeve.AROUND * sleeve.ALONG)
                self.assertEqual(body_search.find(self.obj, bpy.context.scene).body, self.body)

    def test_a_mirror_below_its_wrinkles(self) -> None:
        halve(self.body, 1)
        sleeve.make_active(self.body)
        bpy.ops.object.rumple_add(method="MESH")
        place = list(self.body.modifiers).index(modifier.find(self.body))
        compat.move_modifier(self.body, place, place - 1)
        incoming_mesh.update(self.body)
        self.assertTrue(incoming_mesh.is_own(self.body))
        with incoming_mesh.whole([self.body]):
            self.assertEqual(len(incoming_mesh.of(self.body).vertices), sleeve.AROUND * sleeve.ALONG)

    def test_a_cape_over_the_half_that_a_mirror_makes(self) -> None:
        halve(self.body, 1)
        self.cut(self.obj, 1, least=0.2 * sleeve.RADIUS)
        turned = Matrix.Rotation(np.pi / 2.0, 4, "Y")  # x points down
        for obj in (self.obj, self.body, bpy.data.objects["Arm"]):
            obj.matrix_world = turned
        sleeve.make_active(self.obj)
        self.assertEqual(bpy.ops.object.rumple_add(method="MESH"), {"FINISHED"})
        self.assertEqual((self.obj.rumple.body, self.obj.rumple.mesh.base_cloth), (self.body, "HANG"))
        along = compat.positions(self.obj.data)[:, 0]
        pinned = painted_maps.follow_weights(self.obj)
        self.assertEqual((pinned[along == along.min()].min(), pinned[along == along.max()].max()), (1.0, 0.0))

    def test_a_patch_is_no_sheet_of_the_whole(self) -> None:
        """It counted as one, beside half of its wearer: a quarter of that is less."""
        self.body.data.transform(Matrix.Translation((-sleeve.LENGTH, 0.0, 0.0)))  # the other half is as long again
        self.body.modifiers.new("Mirror", "MIRROR").use_axis = (True, False, False)
        self.cut(self.obj, 1)
        self.cut(self.obj, 0, least=0.7 * sleeve.LENGTH)
        bpy.context.view_layer.update()
        self.assertTrue(cloth_defaults.is_sheet(self.obj, self.body))
        with incoming_mesh.whole([self.body]):
            self.assertFalse(cloth_defaults.is_sheet(self.obj, self.body))


if __name__ == "__main__":
    unittest.main()
