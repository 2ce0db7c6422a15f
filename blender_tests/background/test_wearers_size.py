# SPDX-License-Identifier: GPL-3.0-or-later
"""The lengths of clothes follow the height of the figure that wears them."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path

import bpy
from rumple.blender.objects import runtimes
from support import figure, sleeve

ADULT = 1.75


def factor(obj: bpy.types.Object) -> float:
    """The factor on the lengths of its base cloth, as it is solved."""
    bpy.context.view_layer.update()
    return runtimes.of(obj).evaluator.draped_cloth().cloth.size_factor


class Sizes(unittest.TestCase):
    """A garment on figures of several heights, and one click."""

    def click(self, obj: bpy.types.Object, expected: float) -> None:
        sleeve.click(obj)
        settings = obj.rumple.mesh
        self.assertEqual(settings.base_cloth, "HANG")
        self.assertAlmostEqual(factor(obj) / expected, 1.0, 3)
        for name, length in (("wavelength", 0.04), ("room", 0.03), ("thickness", 0.003)):
            shown = getattr(settings, name) * bpy.context.scene.unit_settings.scale_length
            self.assertAlmostEqual(shown / (length * expected), 1.0, 1, name)

    def test_clothes_of_people_are_not_scaled(self) -> None:
        for height in (1.0, 1.4, 1.8, 2.5):
            for low, high in ((1.3, 1.45), (0.8, 1.5), (0.05, 1.5)):
                with self.subTest(height=height, low=low):
                    obj = figure.dressed(height, low, high)
                    sleeve.click(obj)
                    self.assertEqual(factor(obj), 1.0)
                    self.assertAlmostEqual(obj.rumple.mesh.wavelength, 0.04, 6)

    def test_a_figure_in_other_units(self) -> None:
        for height in (4.6, 180.0):
            self.click(figure.dressed(height), height / ADULT)

    def test_a_doll(self) -> None:
        self.click(figure.dressed(0.3), 0.3 / ADULT)

    def test_without_a_body_the_bones_tell(self) -> None:
        for height, expected in ((1.8, 1.0), (4.6, 0.92 * 4.6 / ADULT), (0.3, 0.92 * 0.3 / ADULT)):
            obj = figure.dressed(height, 1.3, 1.45)
            bpy.data.objects.remove(bpy.data.objects["Body"])
            sleeve.click(obj)
            self.assertAlmostEqual(factor(obj) / expected, 1.0, 1)

    def test_controls_far_away_do_not_count(self) -> None:
        for deform, grouped in ((False, False), (True, False), (True, True)):
            with self.subTest(deform=deform, grouped=grouped):
                obj = figure.dressed(0.3)
                rig = bpy.data.objects["Figure"]
                sleeve.make_active(rig)
                bpy.ops.object.mode_set(mode="EDIT")
                for name, place in (("look_at", (0.0, -2.0, 2.0)), ("ground", (0.0, 0.0, -3.0))):
                    figure.add_bone(rig, name, "root", place)
                bpy.ops.object.mode_set(mode="OBJECT")
                for name in ("look_at", "ground"):
                    rig.data.bones[name].use_deform = deform
                    if grouped:
                        obj.vertex_groups.new(name=name)
                sleeve.click(obj)
                self.assertAlmostEqual(factor(obj) * ADULT / 0.3, 1.0, 2)

    def test_a_long_thing_in_a_hand_does_not_count(self) -> None:
        obj = figure.dressed(1.8)
        pole = figure.tube(bpy.data.objects["Figure"], "Banner", 0.02, 0.0, 6.0)
        sleeve.click(obj)
        self.assertEqual(factor(obj), 1.0)
        bpy.ops.object.rumple_remove()
        pole.modifiers.clear()
        pole.parent, pole.parent_type, pole.parent_bone = bpy.data.objects["Figure"], "BONE", "hand.L"
        sleeve.click(obj)
        self.assertEqual(factor(obj), 1.0)

    def test_other_figures_do_not_count(self) -> None:
        obj = figure.dressed(1.8)
        giant = figure.skeleton(9.0)
        figure.tube(giant, "Giant", 0.6, 0.0, 9.0)
        sleeve.click(obj)
        self.assertEqual(factor(obj), 1.0)

    def test_a_part_of_a_figure_says_nothing(self) -> None:
        obj = sleeve.to_be_cloth()
        sleeve.click(obj)
        self.assertEqual(obj.rumple.figure, 0.0)
        self.assertEqual(factor(obj), 1.0)


class Stored(unittest.TestCase):
    """The height is found once."""

    def setUp(self) -> None:
        self.obj = figure.dressed(4.6)
        sleeve.click(self.obj)
        self.expected = factor(self.obj)
        self.assertGreater(self.expected, 2.0)

    def test_it_stays_when_others_change(self) -> None:
        bpy.data.objects.remove(bpy.data.objects["Body"])
        sleeve.at(3)
        self.obj.data.vertices[0].co.z += 0.01
        self.obj.data.update()
        sleeve.at(4)
        self.assertEqual(factor(self.obj), self.expected)

    def test_it_is_saved(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "figure.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.open_mainfile(filepath=path)
        self.assertEqual(factor(bpy.data.objects["Dress"]), self.expected)

    def test_it_follows_the_scale_and_applied_scales(self) -> None:
        self.obj.scale = (0.3,) * 3
        sleeve.play(2, 3)
        self.assertEqual(factor(self.obj), 1.0)
        self.obj.scale = (2.0,) * 3
        sleeve.play(4, 5)
        self.assertAlmostEqual(factor(self.obj) / (2.0 * self.expected), 1.0, 5)
        sleeve.make_active(self.obj)
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
        sleeve.play(6, 7)
        self.assertAlmostEqual(factor(self.obj) / (2.0 * self.expected), 1.0, 4)

    def test_units_of_the_scene(self) -> None:
        obj = figure.dressed(180.0)
        bpy.context.scene.unit_settings.scale_length = 0.01
        sleeve.click(obj)
        self.assertEqual(factor(obj), 1.0)


if __name__ == "__main__":
    unittest.main()
