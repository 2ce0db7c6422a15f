# SPDX-License-Identifier: GPL-3.0-or-later
"""The hand and the easel, without Blender. What a dab does to the paint is tested natively."""
from __future__ import annotations

import math
import unittest

import numpy as np
from rumple.core.base.wording import UserError
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.settings.system_settings import FieldSettings
from rumple.core.systems.brush import LEAST_SPACING, Easel, Hand
from rumple.core.systems.wrinkle_field import WrinkleField
from support.meshes import rotated, sheet, tube

ABOVE = dict(normal=(0.0, 0.0, 1.0), view=(0.0, 0.0, -1.0))


class HandLaws(unittest.TestCase):
    def places(self, points: list[tuple[float, float, float]], spacing: float = 20.0) -> list:
        hand = Hand(spacing)
        hand.press(*points[0])
        return [place for point in points[1:] for place in hand.move(*point)]

    def test_it_does_not_matter_how_many_events_a_straight_stroke_has(self) -> None:
        few = self.places([(0.0, 0.0, 0.0), (300.0, 400.0, 1.0)])
        many = self.places([(0.0, 0.0, 0.0)] + [(3.0 * k, 4.0 * k, 0.01 * k) for k in range(1, 101)])
        self.assertEqual(len(few), 26)  # 500 pixels, 20 apart, both ends
        for one, other in zip(few, many):
            self.assertAlmostEqual(one.x, other.x, delta=0.01)
            self.assertAlmostEqual(one.y, other.y, delta=0.01)
            self.assertAlmostEqual(one.pressure, other.pressure, delta=0.05)

    def test_places_are_evenly_spaced_and_directions_unit(self) -> None:
        curve = [(100.0 * math.cos(t), 100.0 * math.sin(t), 1.0) for t in np.linspace(0.0, 6.0, 200)]
        places = self.places(curve)
        self.assertGreater(len(places), 20)
        for a, b in zip(places, places[1:]):
            self.assertAlmostEqual(math.hypot(b.x - a.x, b.y - a.y), 20.0, delta=1e-6)
            self.assertAlmostEqual(math.hypot(b.dx, b.dy), 1.0)
            self.assertGreater((b.x - a.x) * b.dx + (b.y - a.y) * b.dy, 19.9)

    def test_the_first_place_is_where_it_was_pressed_with_the_direction_that_follows(self) -> None:
        hand = Hand(10.0)
        self.assertEqual((hand.press(5.0, 5.0, 0.5).dx, hand.press(5.0, 5.0, 0.5).dy), (0.0, 0.0))
        self.assertEqual(hand.move(5.0, 9.0, 0.5), [])
        first, second = hand.move(5.0, 16.0, 0.5)
        self.assertEqual((first.x, first.y, first.dx, first.dy), (5.0, 5.0, 0.0, 1.0))
        self.assertEqual((second.x, second.y), (5.0, 15.0))

    def test_a_tiny_brush_still_sees_a_direction(self) -> None:
        self.assertEqual(Hand(0.1).spacing, LEAST_SPACING)


class EaselLaws(unittest.TestCase):
    def easel(self, base: BaseMesh | None = None) -> Easel:
        return Easel(WrinkleField.build(base or sheet(8, 8), FieldSettings()))

    def test_rigid_motion_does_not_change_what_is_painted(self) -> None:
        easel = self.easel()
        rest, empty = easel.field.base.positions, np.zeros((81, 3), np.float32)
        easel.pose(rest)
        here = easel.dab(empty, False, centre=(0.5, 0.5, 0.0), radius=0.4, direction=(1.0, 0.3, 0.0), **ABOVE)
        place = rotated(np.float32([[0.5, 0.5, 0.0], [0, 0, 0], [0, 0, 1], [1, 0.3, 0]]), 70.0)
        up, way = place[2] - place[1], place[3] - place[1]
        easel.pose(rotated(rest, 70.0))
        there = easel.dab(empty, False, centre=place[0], radius=0.4, direction=way, normal=up, view=-up)
        self.assertGreater(np.count_nonzero(here), 20)
        apart = np.minimum(np.linalg.norm(here - there, axis=1), np.linalg.norm(here + there, axis=1))
        self.assertLess(apart.max(), 1e-4)

    def test_what_is_given_stays_as_it_is(self) -> None:
        easel = self.easel()
        easel.pose(easel.field.base.positions)
        painted = np.zeros((81, 3), np.float32)
        easel.dab(painted, False, centre=(0.5, 0.5, 0.0), radius=0.4, **ABOVE)
        self.assertFalse(painted.any())

    def test_only_another_pose_is_laid_out_anew(self) -> None:
        easel = self.easel()
        rest = easel.field.base.positions
        self.assertTrue(easel.pose(rest))
        self.assertFalse(easel.pose(rest.copy()))
        self.assertTrue(easel.pose(rest + np.float32(0.1)))

    def test_scatter_counts_in_metres(self) -> None:
        metres, centimetres = sheet(20, 20), sheet(20, 20, size=100.0)
        one = self.easel(metres).scatter(3, 0.4, 0.2, 0.6)
        field = WrinkleField.build(centimetres, FieldSettings(), unit_scale=0.01)
        np.testing.assert_allclose(Easel(field).scatter(3, 0.4, 0.2, 0.6), one, atol=1e-4)
        self.assertEqual(np.any(one != 0.0, axis=1).sum(), round(0.4 * 441))

    def test_lines_lie_along_the_folds_or_across_them(self) -> None:
        easel = self.easel(tube(12, 8))
        easel.pose(easel.field.base.positions)
        painted = np.zeros((108, 3), np.float32)
        painted[:, 2] = 0.5  # compressed along the tube: folds run around it
        for across, axis_share in ((False, 0.0), (True, 1.0)):
            ends, strength = easel.lines(painted, across)
            way = ends[1::2] - ends[::2]
            self.assertEqual(len(strength), 108)
            np.testing.assert_allclose(strength, 0.5, atol=1e-6)
            np.testing.assert_allclose(np.abs(way[:, 2]) / np.linalg.norm(way, axis=1), axis_share, atol=0.01)

    def test_what_is_wrong_is_said_with_the_objects_name(self) -> None:
        easel = self.easel()
        easel.pose(easel.field.base.positions)
        bad = np.zeros((81, 3), np.float32)
        bad[5, 0] = np.nan
        dab = dict(centre=(0.0, 0.0, 0.0), radius=0.4, **ABOVE)
        with self.assertRaisesRegex(UserError, "Sheet: the painted rest wrinkle of vertex 5 is not a valid vector"):
            easel.dab(bad, False, **dab)
        with self.assertRaisesRegex(UserError, "Sheet: rest_wrinkle: expected 81 vertices, got 80"):
            easel.dab(bad[:80], False, **dab)
        with self.assertRaisesRegex(UserError, "Sheet: positions: expected 81 vertices, got 80"):
            easel.pose(bad[:80])
        with self.assertRaisesRegex(UserError, "Sheet: density"):
            easel.scatter(0, 2.0, 0.1, 0.5)


if __name__ == "__main__":
    unittest.main()
