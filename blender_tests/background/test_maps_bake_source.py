# SPDX-License-Identifier: GPL-3.0-or-later
"""Which wrinkles are baked to Wrinkle Maps where nobody has chosen any."""
from __future__ import annotations

import unittest
from unittest import mock

import bmesh
import bpy
import numpy as np
from mathutils import Vector
from rumple.blender.first_click import cloth_defaults, set_up
from rumple.blender.maps import bake_source
from rumple.core.systems import wrinkle_mesh
from support import face, sleeve


class Source(unittest.TestCase):
    """What is baked where nobody has chosen anything: it was the Wrinkle Mesh for skin, too, and hardly to be seen."""

    def source_of(self, obj: bpy.types.Object) -> str:
        with sleeve.context():
            sleeve.make_active(obj)
            self.assertEqual(bpy.ops.rumple.maps_add(), {"FINISHED"})
        return obj.rumple_maps.bake_source

    def test_skin_gets_the_field_with_creases(self) -> None:
        obj, _ = face.scene(maps=False)
        self.assertEqual(self.source_of(obj), "FIELD")
        values = bake_source.skin_settings(obj, bpy.context.scene, "FIELD")
        self.assertEqual((values["profile"], values["base_cloth"]), ("PENCIL_PLEATS", "OFF"))
        self.assertAlmostEqual(values["wavelength"], 0.02, places=6)  # two edges

    def test_what_the_artist_has_set_stays(self) -> None:
        obj, _ = face.scene(maps=False)
        obj.rumple.mesh.radius = 0.5
        self.assertEqual(self.source_of(obj), "MESH")
        obj.rumple.field.irregularity = 0.1
        for source in ("MESH", "FIELD", "PATHS"):
            self.assertEqual(bake_source.skin_settings(obj, bpy.context.scene, source), {})

    def test_a_face_with_open_eyes_is_no_garment(self) -> None:
        """Two openings make a shirt: folds of hanging cloth were baked on it."""
        obj, _ = face.scene(maps=False)
        skin = bmesh.new()
        skin.from_mesh(obj.data)
        sockets = [one for one in skin.faces if min((one.calc_center_median() - Vector((x, 0.0, 0.02))).length
                                                    for x in (-0.03, 0.03)) < 0.011]
        bmesh.ops.delete(skin, geom=sockets, context="FACES")
        skin.to_mesh(obj.data)
        skin.free()
        self.assertTrue(wrinkle_mesh.suits_cloth(cloth_defaults.cloth_at_rest(obj)))
        self.assertEqual(self.source_of(obj), "FIELD")

    def test_a_garment_with_closed_ends_is_one(self) -> None:
        obj = sleeve.to_be_cloth()
        cloth = bmesh.new()
        cloth.from_mesh(obj.data)
        bmesh.ops.holes_fill(cloth, edges=cloth.edges)
        cloth.to_mesh(obj.data)
        cloth.free()
        bpy.data.objects.remove(bpy.data.objects["Human"])  # what goes into a closed end is no body in it
        with mock.patch.object(set_up.cloth_defaults, "is_closed", return_value=True):
            self.assertEqual(self.source_of(obj), "MESH")

    def test_a_captured_rest_shape_has_no_folds(self) -> None:
        """The copy that is baked lost it, and its folds were those from the shape as it is modelled."""
        obj, rig = face.scene(maps=False)
        face.pose(rig, brow_L=-0.012)
        sleeve.click(obj, "FIELD")
        self.assertEqual(bpy.ops.object.rumple_capture_rest(), {"FINISHED"})
        self.assertEqual(self.source_of(obj), "FIELD")
        bpy.ops.rumple.pose_add(name="Captured")
        obj.rumple_maps.bake_size = 64
        self.assertEqual(bpy.ops.rumple.maps_bake(), {"FINISHED"})
        image = obj.rumple_maps.poses["Captured"].image
        texels = np.reshape(image.pixels, (-1, 4))[:, :2]
        self.assertLess(np.abs(texels - 0.5).max(), 0.02)

    def test_a_garment_gets_the_mesh(self) -> None:
        self.assertEqual(self.source_of(sleeve.to_be_cloth()), "MESH")

    def test_other_wrinkles_of_the_object_are_taken(self) -> None:
        obj = sleeve.scene(wrinkles=False)
        sleeve.click(obj, "PATHS")
        self.assertEqual(self.source_of(obj), "PATHS")

    def test_a_choice_that_was_made_stays(self) -> None:
        obj, _ = face.scene(maps=False)
        obj.rumple_maps.bake_source = "PATHS"
        self.assertEqual(self.source_of(obj), "PATHS")


if __name__ == "__main__":
    unittest.main()
