# SPDX-License-Identifier: GPL-3.0-or-later
"""Which way a body faces: contacts push to that side."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.mesh.body import facing_outwards, is_nearly_closed, side

AROUND = 24


def lathe(rings: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """A surface around z through rings of (radius, height), seen from outside: positions and triangles."""
    angles = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    positions = [(radius * np.cos(a), radius * np.sin(a), height) for radius, height in rings for a in angles]
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(AROUND), np.arange(len(rings) - 1)))
    here, there = j * AROUND + i, j * AROUND + (i + 1) % AROUND
    triangles = np.concatenate([np.stack([here, there, here + AROUND], 1),
                                np.stack([there, there + AROUND, here + AROUND], 1)])
    return np.array(positions, np.float32), triangles.astype(np.int32)


def arc(first: float, last: float) -> list[tuple[float, float]]:
    return [(np.sin(a), -np.cos(a)) for a in np.linspace(first, last, 20)]


class Side(unittest.TestCase):

    def check(self, rings: list[tuple[float, float]], expected: int) -> None:
        positions, triangles = lathe(rings)
        for away in (0.0, 500.0):  # where it stands does not count
            self.assertEqual(side(positions + np.float32(away), triangles), expected)
            self.assertEqual(side(positions + np.float32(away), triangles[:, ::-1]), -expected)
        mirrored = positions * (np.float32(-1), np.float32(1), np.float32(1))
        self.assertEqual(side(mirrored, triangles), -expected)
        turned = facing_outwards(mirrored, triangles)
        np.testing.assert_array_equal(turned, triangles[:, ::-1] if expected else triangles)

    def test_what_has_an_inside(self) -> None:
        self.check(arc(0.01, 3.13), 1)
        self.check(arc(0.5, 3.13), 1)  # a hole, as under clothes
        self.check([(1.0, 0.0), (1.0, 3.0)], 1)  # a tube

    def test_what_is_long_and_thin(self) -> None:
        """Whole bodies with their limbs apart have less volume for their area than was asked for: 0.026 and 0.03. Such
        a one that was inside out drew its clothes in."""
        self.check([(0.01, 0.0), (1.0, 0.0), (1.0, 200.0), (0.01, 200.0)], 1)

    def test_sheets_have_none(self) -> None:
        self.check([(0.01, 0.0), (1.0, 0.0)], 0)
        self.check(arc(0.01, 0.25), 0)  # a dish

    def test_what_bends_through_has_another_side_though_nothing_mirrors_it(self) -> None:
        """So of what is open the sides in a pose say nothing: a hood that wind blows through kept its cloth inside."""
        hood, blown = lathe(arc(0.01, 1.2)), lathe([(radius, -height) for radius, height in arc(0.01, 1.2)])
        self.assertEqual((side(*hood), side(*blown)), (1, -1))
        self.assertFalse(is_nearly_closed(*hood))
        self.assertTrue(is_nearly_closed(*lathe(arc(0.01, 3.13))))
        self.assertTrue(is_nearly_closed(*lathe(arc(0.3, 3.13))))  # a hole at the neck

    def test_what_is_not_finite_or_has_no_extent_has_none_and_no_warning(self) -> None:
        positions, triangles = lathe(arc(0.01, 3.13))
        for value in (0.0, np.nan, np.inf, 3e38):
            with np.errstate(all="raise"):
                self.assertEqual(side(np.full_like(positions, value), triangles), 0)
        self.assertEqual(side(positions, triangles[:0]), 0)


if __name__ == "__main__":
    unittest.main()
