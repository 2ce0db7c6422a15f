# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Field and Wrinkle Paths on a base cloth: the first click, what is shown, played, worn and baked."""
from __future__ import annotations

import unittest
from typing import Any

import bpy
import numpy as np
from rumple.blender import handlers
from rumple.blender.objects import modifier, runtimes
from support import curve_edges, sleeve
from support.cloth_scenes import Cloth, depths, difference, final, forget, hang, off_animation, pictures, played

METHODS = {"FIELD": ("field", {}), "WAVES": ("field", {"output": "GEOMETRY"}), "PATHS": ("paths", {})}


def click(obj: bpy.types.Object, kind: str, **values: Any) -> Any:
    """One click by a method; FIELD is shaded, WAVES is geometry. Its settings."""
    group, own = METHODS[kind]
    settings = getattr(obj.rumple, group)
    for name, value in {**own, **values}.items():
        setattr(settings, name, value)
    sleeve.make_active(obj)
    bpy.ops.object.rumple_add(method="FIELD" if group == "field" else "PATHS")
    bpy.context.view_layer.update()
    return settings


def bare() -> bpy.types.Object:
    """A sleeve that nobody said anything of."""
    obj = sleeve.scene(wrinkles=False)
    for settings in (obj.rumple.field, obj.rumple.paths):
        settings.property_unset("base_cloth")
    return obj


def worn(kind: str, radius: float = 0.8, **values: Any) -> tuple[bpy.types.Object, bpy.types.Object, Any]:
    """By one click: a sleeve of cloth, the body under it, the settings."""
    obj = bare()
    body = sleeve.under(obj, radius=radius)
    return obj, body, click(obj, kind, **values)


class FirstClick(Cloth):

    def test_a_worn_sleeve_becomes_cloth_over_its_body(self) -> None:
        for kind in METHODS:
            obj, body, settings = worn(kind)
            self.assertEqual((settings.base_cloth, obj.rumple.body), ("HANG", body), kind)
            if kind == "PATHS":
                self.assertAlmostEqual(settings.threshold, 1.1, 6)
                self.assertAlmostEqual(settings.width, 0.027, 6)  # 0.7 of the mean edge, 39 mm: more than 25 mm
            else:
                fine = runtimes.of(obj).evaluator
                self.assertAlmostEqual(settings.wavelength, fine.suggested_length(fine.base, 1.0), 6)
            sleeve.play(1, 8)
            self.assertEqual(obj.rumple.message, "")
            self.assertGreater(off_animation(obj), 2e-3, kind)

    def test_what_would_not_be_cloth_for_the_mesh_stays(self) -> None:
        for kind in METHODS:
            for change in (lambda obj: obj.modifiers.clear(), lambda obj: obj.modifiers.new("Cloth", "CLOTH")):
                obj = bare()
                change(obj)
                self.assertEqual(click(obj, kind).base_cloth, "OFF", kind)

    def test_what_was_chosen_before_stays(self) -> None:
        for kind in METHODS:
            self.assertEqual(click(bare(), kind, base_cloth="OFF").base_cloth, "OFF", kind)
            settings = click(bare(), kind, room=0.011, thickness=0.007)
            self.assertEqual(settings.base_cloth, "HANG")
            np.testing.assert_allclose((settings.room, settings.thickness), (0.011, 0.007), rtol=1e-6)
        chosen = click(bare(), "PATHS", width=0.017, threshold=1.3)
        np.testing.assert_allclose((chosen.width, chosen.threshold), (0.017, 1.3), rtol=1e-6)


class Shown(Cloth):

    def test_shading_moves_the_coarse_mesh_to_the_cloth(self) -> None:
        obj, _body, _settings = worn("FIELD")
        for frame in (1, 2, 3, 12, 20, 7):
            sleeve.at(frame)
            runtime = runtimes.of(obj)
            cloth = runtime.evaluator.solved_over(float(frame), runtime.inputs.positions)
            np.testing.assert_allclose(sleeve.shown(obj), cloth, atol=2e-6)
        self.assertGreater(off_animation(obj), 2e-3)

    def test_geometry_and_folds_lie_over_the_cloth(self) -> None:
        for kind in ("WAVES", "PATHS"):
            obj, _body, settings = worn(kind)
            for frame in (1, 2, 3, 12):
                sleeve.at(frame)
                np.testing.assert_allclose(sleeve.shown(obj), sleeve.picture(obj).positions, atol=2e-6, err_msg=kind)
            seen = sleeve.shown(obj)
            settings.base_cloth = "OFF"
            sleeve.at(12)
            self.assertGreater(difference(sleeve.shown(obj), seen), 2e-3)

    def test_nothing_is_deeper_inside_the_body_than_the_bare_sleeve(self) -> None:
        for kind in METHODS:
            obj, body, settings = worn(kind, 0.9)
            found = depths(obj, body, range(1, 11))
            settings.base_cloth = "OFF"
            setattr(settings, "strength" if kind != "PATHS" else "height", 0.0)
            self.check_no_deeper(found, depths(obj, body, found), kind)

    def test_without_a_base_cloth_they_come_out_of_a_body_that_stands_out_of_the_sleeve(self) -> None:
        for kind in ("WAVES", "PATHS"):
            obj = bare()
            body = sleeve.under(obj, radius=1.04)
            click(obj, kind, base_cloth="OFF")
            obj.rumple.body = body
            found = depths(obj, body, range(1, 13))
            self.assertEqual(obj.rumple.message, "")
            obj.rumple.body = None
            self.assertGreater(min(depths(obj, body, found).values()), 3e-3, kind)
            self.assertLess(max(found.values()), 1e-3, kind)  # 0.74 mm, of the waves where the arm is bent most

    def test_curves_ride_on_the_folds_over_the_cloth(self) -> None:
        obj, _body, _settings = worn("PATHS")
        bpy.ops.object.rumple_curves_add()
        child = curve_edges.child_of(obj)
        sleeve.play()
        self.assertGreater(curve_edges.same(self, obj, child), 1)
        shown = sleeve.shown(obj)
        _curves, positions, _values = curve_edges.seen(child)
        away = np.linalg.norm(shown[None] - positions[:, None], axis=2).min(axis=1)
        self.assertLess(float(np.median(away)), 0.25 * obj.rumple.paths.width)


class Played(Cloth):

    def test_scrubbed_jumped_to_and_played_again(self) -> None:
        for kind in METHODS:
            obj, _body, _settings = worn(kind)
            first = played(obj, 12)
            self.same(first, pictures(obj, (9, 2, 12, 5)))
            forget(obj)
            pictures(obj, (10,))
            self.assertFalse(final(obj, 10.0))
            self.same(first, played(obj, 12))
            self.assertTrue(final(obj, 10.0))

    def test_saved_and_opened(self) -> None:
        for kind in METHODS:
            obj, _body, _settings = worn(kind)
            first = played(obj, 6)
            bpy.ops.wm.open_mainfile(filepath=self.saved())
            self.same(first, played(bpy.data.objects["Sleeve"], 6))

    def test_a_clip_is_what_was_played(self) -> None:
        for kind in METHODS:
            obj, _body, _settings = worn(kind)
            obj.rumple.bake_end = 10
            first = played(obj, 10)
            self.saved()
            sleeve.make_active(obj)
            self.assertEqual(bpy.ops.object.rumple_bake(), {"FINISHED"})
            handlers.unregister()
            try:
                for frame, positions in pictures(obj, (9, 1, 4)).items():
                    np.testing.assert_allclose(positions, first[frame], atol=2e-6, err_msg=kind)
            finally:
                handlers.register()
            self.assertTrue(modifier.is_baked(modifier.find(obj)))


class PaintedAndWorn(Cloth):

    def test_painted_follow_and_room_hold_the_cloth(self) -> None:
        for kind in METHODS:
            for word, value, most in (("follow", 1.0, 2e-4), ("room", 0.0, 1e-6)):
                obj = bare()
                click(obj, kind)
                sleeve.play(1, 5)
                self.assertGreater(off_animation(obj), 1e-3)
                bpy.ops.object.rumple_paint(group=word)
                obj.vertex_groups.active.add(range(len(obj.data.vertices)), value, "REPLACE")
                sleeve.play(1, 5)
                self.assertLess(off_animation(obj), most, f"{kind} {word}")

    def test_a_garment_over_it_lies_on_its_cloth(self) -> None:
        for kind in METHODS:
            inner, _body, settings = worn(kind, 0.7)
            outer = sleeve.under(inner, "Coat", 1.2)
            hang(outer, level=1)
            outer.rumple.body, outer.rumple.body_collection = inner, None
            bpy.context.view_layer.update()
            for frame in (1, 2, 3, 4):
                sleeve.at(frame)
                fine, inputs = runtimes.of(inner).evaluator, runtimes.of(inner).inputs
                under = runtimes.of(outer).inputs.body.positions
                raised = fine.worn_surface(float(frame), inputs.positions, inputs.settings)
                np.testing.assert_array_equal(under, raised.positions)
                if kind == "FIELD":  # waves that materials draw have no height
                    np.testing.assert_array_equal(under, fine.solved_over(float(frame), inputs.positions))
            self.assertGreater(off_animation(inner), 1e-3)
            self.assertEqual((inner.rumple.message, outer.rumple.message), ("", ""))


if __name__ == "__main__":
    unittest.main()
