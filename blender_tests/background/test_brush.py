# SPDX-License-Identifier: GPL-3.0-or-later
"""Rest-pose wrinkles without a hand: scatter, clear, what is refused, and what is left alone."""
from __future__ import annotations

import os
import tempfile
import unittest

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.brush import canvas as brush_canvas, operators as brush_operators
from rumple.blender.objects import mesh_reader, runtimes
from support import sleeve


def field() -> bpy.types.Object:
    """The sleeve with a Wrinkle Field."""
    obj = sleeve.scene(wrinkles=False)
    bpy.ops.object.rumple_add(method="FIELD")
    return obj


def painted(obj: bpy.types.Object) -> np.ndarray:
    return compat.read_attribute(obj.data.attributes[mesh_reader.REST_WRINKLE])


class Scatter(unittest.TestCase):
    def test_the_seed_decides_and_the_folds_appear(self) -> None:
        obj = field()
        self.assertEqual(bpy.ops.object.rumple_scatter(seed=3, density=0.5, length=0.8), {"FINISHED"})
        first = painted(obj)
        self.assertEqual(np.any(first != 0.0, axis=1).sum(), round(0.5 * len(first)))
        sleeve.at(1)
        amplitude = sleeve.attribute(obj, "rumple_amplitude")[:len(first), 0]
        lengths = np.linalg.norm(first, axis=1)
        self.assertTrue((amplitude[lengths > 0.2] > 1e-3 * obj.rumple.field.wavelength).all())
        self.assertTrue((amplitude[lengths == 0.0] < 1e-4).all())
        bpy.ops.object.rumple_scatter(seed=4, density=0.5, length=0.8)
        self.assertFalse(np.array_equal(painted(obj), first))
        bpy.ops.object.rumple_scatter(seed=3, density=0.5, length=0.8)
        np.testing.assert_array_equal(painted(obj), first)
        self.assertEqual(obj.rumple.message, "")

    def test_clear_leaves_nothing(self) -> None:
        obj = field()
        bpy.ops.object.rumple_scatter()
        sleeve.at(1)
        self.assertGreater(sleeve.attribute(obj, "rumple_amplitude").max(), 1e-3)
        bpy.ops.object.rumple_clear_rest_wrinkles()
        self.assertNotIn(mesh_reader.REST_WRINKLE, obj.data.attributes)
        sleeve.at(1)
        self.assertLess(sleeve.attribute(obj, "rumple_amplitude").max(), 1e-4)

    def test_what_is_painted_survives_removing_and_adding(self) -> None:
        obj = field()
        bpy.ops.object.rumple_scatter()
        kept = painted(obj)
        bpy.ops.object.rumple_remove()
        bpy.ops.object.rumple_add(method="FIELD")
        np.testing.assert_array_equal(painted(obj), kept)

    def test_an_attribute_of_that_name_that_is_not_ours_is_kept(self) -> None:
        obj = field()
        obj.data.attributes.new(mesh_reader.REST_WRINKLE, "FLOAT", "POINT")
        with self.assertRaisesRegex(RuntimeError, "is not a vector for each point"):
            bpy.ops.object.rumple_scatter()
        self.assertEqual(obj.data.attributes[mesh_reader.REST_WRINKLE].data_type, "FLOAT")


class Refusals(unittest.TestCase):
    def test_only_a_wrinkle_field_is_painted(self) -> None:
        obj = sleeve.scene()  # a Wrinkle Mesh
        self.assertIn("no Wrinkle Field", brush_operators.refusal(obj))
        self.assertFalse(bpy.ops.object.rumple_scatter.poll())
        self.assertFalse(bpy.ops.object.rumple_brush.poll())
        bpy.ops.object.rumple_remove()
        self.assertIn("no Wrinkle Field", brush_operators.refusal(obj))

    def test_a_linked_mesh_is_never_touched(self) -> None:
        field()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "library.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            sleeve.empty_file()
            with bpy.data.libraries.load(path, link=True) as (_there, here):
                here.objects = ["Sleeve"]
            linked = bpy.data.objects["Sleeve"]
            bpy.context.scene.collection.objects.link(linked)
            sleeve.make_active(linked)
            self.assertIn("linked", brush_operators.refusal(linked))
            for operator in (bpy.ops.object.rumple_scatter, bpy.ops.object.rumple_clear_rest_wrinkles):
                self.assertFalse(operator.poll())
            self.assertNotIn(mesh_reader.REST_WRINKLE, linked.data.attributes)

    def test_a_baked_field_says_so(self) -> None:
        obj = field()
        with tempfile.TemporaryDirectory() as folder:
            obj.rumple.bake_folder = folder
            obj.rumple.bake_end = 2
            bpy.ops.object.rumple_bake()
            with self.assertRaisesRegex(RuntimeError, "baked"):
                bpy.ops.object.rumple_scatter()
            bpy.ops.object.rumple_bake_free()
            self.assertEqual(bpy.ops.object.rumple_scatter(), {"FINISHED"})

    def test_in_edit_mode_there_is_no_brush(self) -> None:
        obj = field()
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertIn("Object Mode", brush_operators.refusal(obj))
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assertEqual(brush_operators.refusal(obj), "")


class Units(unittest.TestCase):

    def test_a_size_that_nobody_gave_is_the_same_in_any_unit(self) -> None:
        """In a scene of centimetres the patches were of a millimetre."""
        obj, found = field(), []
        for unit in (1.0, 1 / 128):
            obj.scale = bpy.data.objects["Arm"].scale = (1 / unit,) * 3
            bpy.context.scene.unit_settings.scale_length = unit
            bpy.context.view_layer.update()
            self.assertEqual(bpy.ops.object.rumple_scatter(), {"FINISHED"})
            found.append(brush_canvas.read(obj.data).copy())
        self.assertTrue(found[0].any())
        np.testing.assert_allclose(found[1], found[0], atol=1e-4)


class Switch(unittest.TestCase):
    def test_off_and_on_again(self) -> None:
        import rumple
        rumple.unregister()
        self.assertFalse(hasattr(bpy.types.Scene, "rumple_brush"))
        rumple.register()
        obj = field()
        self.assertEqual(bpy.ops.object.rumple_scatter(), {"FINISHED"})
        self.assertEqual(runtimes.message(obj), "")
