# SPDX-License-Identifier: GPL-3.0-or-later
"""The wind at a garment, worked by hand."""
from __future__ import annotations

import math
import unittest
from dataclasses import replace

import numpy as np
from rumple.core.surroundings import Wind, air_velocity

# Three units below the garment, along an axis of length 5.
WIND = Wind(location=(1.0, 2.0, 0.0), axis=(3.0, 0.0, 4.0), strength=10.0)
AT = (1.0, 2.0, 3.0)
FULL = np.array((6.0, 0.0, 8.0))  # 10 m/s along (0.6, 0, 0.8)


class AirVelocity(unittest.TestCase):

    def check(self, expected: np.ndarray, *winds: Wind) -> None:
        np.testing.assert_allclose(air_velocity(AT, winds), expected, rtol=1e-14, atol=1e-14)

    def test_no_wind_is_still_air(self) -> None:
        self.assertEqual(air_velocity(AT, ()), (0.0, 0.0, 0.0))

    def test_without_a_falloff_it_blows_at_its_strength_along_its_axis_whose_length_does_not_count(self) -> None:
        self.check(FULL, WIND)
        self.check(FULL, replace(WIND, axis=(0.03, 0.0, 0.04)))
        self.check(-FULL, replace(WIND, strength=-10.0))

    def test_power_is_of_one_more_than_the_distance(self) -> None:
        self.check(FULL / 4.0, replace(WIND, power=1.0))  # 1 + 3
        self.check(FULL / 16.0, replace(WIND, power=2.0))
        self.check(FULL / 2.0, replace(WIND, power=0.5))

    def test_up_to_the_min_distance_nothing_is_lost_and_from_there_it_counts(self) -> None:
        self.check(FULL / 2.0, replace(WIND, power=1.0, min_distance=2.0))  # 1 + (3 - 2)
        self.check(FULL, replace(WIND, power=1.0, min_distance=3.0))
        self.check(FULL, replace(WIND, power=1.0, min_distance=50.0))

    def test_beyond_the_max_distance_nothing_is_left(self) -> None:
        self.check(FULL, replace(WIND, max_distance=3.0))
        self.check(np.zeros(3), replace(WIND, max_distance=2.99))
        self.check(np.zeros(3), replace(WIND, max_distance=0.0))
        self.check(FULL / 4.0, replace(WIND, power=1.0, max_distance=3.0))
        self.check(np.zeros(3), replace(WIND, min_distance=50.0, max_distance=2.0))

    def test_winds_add_up(self) -> None:
        across = Wind(location=(1.0, 0.0, 3.0), axis=(0.0, 1.0, 0.0), strength=6.0, power=1.0)  # two units away
        self.check(FULL + (0.0, 2.0, 0.0), WIND, across)
        self.check(np.zeros(3), WIND, replace(WIND, strength=-10.0))

    def test_one_without_an_axis_does_not_blow_and_the_others_do(self) -> None:
        self.check(np.zeros(3), replace(WIND, axis=(0.0, 0.0, 0.0)))
        self.check(FULL, replace(WIND, axis=(0.0, 0.0, 0.0)), WIND)

    def test_one_that_is_not_finite_does_not_blow_and_the_others_do(self) -> None:
        for bad in (math.nan, math.inf, -math.inf):
            for change in (dict(location=(bad, 0.0, 0.0)), dict(axis=(0.0, bad, 1.0)), dict(strength=bad),
                           dict(power=bad), dict(min_distance=bad)):
                self.check(FULL, replace(WIND, **change), WIND)

    def test_at_a_place_that_is_not_finite_the_air_is_still(self) -> None:
        self.assertEqual(air_velocity((math.nan, 0.0, 0.0), [WIND]), (0.0, 0.0, 0.0))


if __name__ == "__main__":
    unittest.main()
