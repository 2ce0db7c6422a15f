# SPDX-License-Identifier: GPL-3.0-or-later
"""The force fields at a garment, worked by hand."""
from __future__ import annotations

import math
import unittest
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
from rumple.core.cloth.base_cloth import FIELD, BaseCloth, ClothInput
from rumple.core.cloth.surroundings import Field, Surroundings, air_velocity, surroundings_of
from rumple.core.settings.cloth_settings import ClothSettings
from support.meshes import tube

# Three units below the garment, along an axis of length 5.
WIND = Field("WIND", location=(1.0, 2.0, 0.0), axis=(3.0, 0.0, 4.0), strength=10.0)
AT = (1.0, 2.0, 3.0)
FULL = np.array((6.0, 0.0, 8.0))  # 10 m/s along (0.6, 0, 0.8)
FORCE = Field("FORCE", location=(0.0, 0.0, -2.0), axis=(0.0, 0.0, 1.0), strength=3.0)


def air(*fields: Field) -> np.ndarray:
    return Surroundings(fields=fields).effects(np.array([AT], np.float32)).air[0]


class Winds(unittest.TestCase):

    def check(self, expected: np.ndarray, *winds: Field) -> None:
        np.testing.assert_allclose(air(*winds), expected, rtol=1e-6, atol=1e-6)
        if all(wind.is_uniform and wind.acts for wind in winds):
            np.testing.assert_allclose(air_velocity(winds), expected, rtol=1e-14, atol=1e-14)

    def test_no_wind_is_still_air(self) -> None:
        self.assertEqual(air_velocity(()), (0.0, 0.0, 0.0))
        self.assertFalse(air().any())

    def test_without_a_falloff_it_blows_at_its_strength_along_its_axis_whose_length_does_not_count(self) -> None:
        self.check(FULL, WIND)
        self.check(FULL, replace(WIND, axis=(0.03, 0.0, 0.04)))
        self.check(-FULL, replace(WIND, strength=-10.0))

    def test_power_is_of_one_more_than_the_distance(self) -> None:
        self.check(FULL / 4.0, replace(WIND, power=1.0))  # 1 + 3
        self.check(FULL / 16.0, replace(WIND, power=2.0))
        self.check(FULL / 2.0, replace(WIND, power=0.5))

    def test_up_to_the_min_distance_nothing_is_lost_and_from_there_it_counts(self) -> None:
        self.check(FULL / 2.0, replace(WIND, power=1.0, least=2.0))  # 1 + (3 - 2)
        self.check(FULL, replace(WIND, power=1.0, least=3.0))
        self.check(FULL, replace(WIND, power=1.0, least=50.0))

    def test_beyond_the_max_distance_nothing_is_left(self) -> None:
        self.check(FULL, replace(WIND, most=3.0))
        self.check(np.zeros(3), replace(WIND, most=2.99))
        self.check(np.zeros(3), replace(WIND, most=0.0))
        self.check(FULL / 4.0, replace(WIND, power=1.0, most=3.0))
        self.check(np.zeros(3), replace(WIND, least=50.0, most=2.0))

    def test_winds_add_up(self) -> None:
        across = Field("WIND", location=(1.0, 0.0, 3.0), axis=(0.0, 1.0, 0.0), strength=6.0, power=1.0)
        self.check(FULL + (0.0, 2.0, 0.0), WIND, across)  # two units away
        self.check(np.zeros(3), WIND, replace(WIND, strength=-10.0))

    def test_a_plane_is_as_far_as_its_axis_goes(self) -> None:
        """3 x 0.8 along the axis."""
        self.check(FULL / 3.4, replace(WIND, power=1.0, shape="PLANE"))


class WhatCounts(unittest.TestCase):

    def test_a_uniform_wind_is_one_velocity_and_any_other_field_acts_on_every_vertex(self) -> None:
        found = surroundings_of(AT, 7, [WIND, FORCE], 1.0)
        self.assertEqual(found.fields, (FORCE,))
        np.testing.assert_allclose(found.wind, FULL, rtol=1e-14)
        for change in (dict(power=1.0), dict(most=9.0), dict(noise=1.0), dict(side="ABOVE"),
                       dict(falloff="TUBE", radial_most=3.0), dict(falloff="CONE", radial_power=1.0)):
            found = surroundings_of(AT, 7, [replace(WIND, **change)], 1.0)
            self.assertEqual((len(found.fields), found.wind), (1, (0.0, 0.0, 0.0)), change)

    def test_what_has_no_axis_or_is_not_finite_does_not_act_and_the_others_do(self) -> None:
        bad = [replace(WIND, axis=(0.0, 0.0, 0.0))]
        for value in (math.nan, math.inf, -math.inf):
            bad += [replace(WIND, **change) for change in (
                dict(location=(value, 0.0, 0.0)), dict(axis=(0.0, value, 1.0)), dict(strength=value),
                dict(power=value), dict(least=value), dict(noise=value))]
        found = surroundings_of(AT, 1, [*bad, FORCE], 1.0)
        self.assertEqual((found.fields, found.wind), ((FORCE,), (0.0, 0.0, 0.0)))

    def test_without_drag_no_wind_counts(self) -> None:
        found = surroundings_of(AT, 1, [WIND, replace(WIND, noise=1.0), FORCE], 0.0)
        self.assertEqual((found.fields, found.wind), ((FORCE,), (0.0, 0.0, 0.0)))

    def test_the_frame_counts_where_there_is_noise(self) -> None:
        self.assertEqual(surroundings_of(AT, 7, [FORCE], 1.0).frame, 0)
        self.assertEqual(surroundings_of(AT, 7, [replace(FORCE, noise=1.0)], 1.0).frame, 7)

    def test_numbers_too_large_for_the_library_are_bounded(self) -> None:
        far = replace(FORCE, strength=1e30, most=3e38, location=(1e20, 0.0, 0.0), axis=(0.0, 0.0, 1e12))
        self.assertTrue(np.isfinite(Surroundings(fields=(far,)).effects(np.zeros((1, 3), np.float32)).push).all())

    def test_digests_tell_every_change_and_stay_as_they_were_without_fields(self) -> None:
        plain = Surroundings(AT, (1.0, 2.0, 3.0))
        np.testing.assert_array_equal(plain.array(), np.array((AT, (1.0, 2.0, 3.0))))
        fields = [FORCE] + [replace(FORCE, **change) for change in (
            dict(kind="VORTEX"), dict(shape="LINE"), dict(falloff="CONE"), dict(side="ABOVE"), dict(strength=3.5),
            dict(location=(0.0, 0.0, -2.5)), dict(axis=(0.0, 0.1, 1.0)), dict(damping=1.0), dict(size=1.0),
            dict(flow=1.0), dict(noise=1.0), dict(seed=1), dict(power=1.0), dict(least=1.0), dict(most=0.0),
            dict(radial_power=1.0), dict(radial_least=1.0), dict(radial_most=1.0), dict(inverse_square=True),
            dict(in_world=True))]
        seen = {bytes(Surroundings(AT, fields=(field,)).array()) for field in fields}
        seen |= {bytes(Surroundings(AT, fields=(FORCE,), frame=5).array()), bytes(plain.array())}
        self.assertEqual(len(seen), len(fields) + 2)

    def test_a_digest_is_of_as_many_bytes_on_every_system(self) -> None:
        """With NumPy 1 a whole number has 32 bits on Windows where nobody says how many."""
        real = np.array

        def on_windows(values: Any, dtype: Any = None) -> np.ndarray:
            found = real(values, dtype)
            return found.astype(np.int32) if dtype is None and found.dtype == np.int64 else found
        for system in (real, on_windows):
            with mock.patch.object(np, "array", system):
                found = Surroundings(AT, fields=(FORCE,), frame=5).array()
            self.assertEqual(bytes(found[48:56]), (5).to_bytes(8, "little"))  # behind place and wind
            self.assertEqual(bytes(found[56:]), bytes(FORCE.array()))


class OnCloth(unittest.TestCase):
    """A tube in metres or not, turned or not, on which only fields act."""

    def velocity(self, fields: list[Field], world_from_object: np.ndarray, unit_scale: float = 1.0,
                 drag: float = 1.0) -> np.ndarray:
        """(n, 3) in the world, m/s, after a time step of 1/60 s from rest. Its own mass per area is 0.5."""
        mesh = tube(8, 6, 0.1 / unit_scale, 0.5 / unit_scale)
        surface = mesh.surface(True)
        cloth = BaseCloth(surface, 1.0 / unit_scale, unit_scale)
        settings = ClothSettings(base_cloth="SWING", gravity=0.0, mass=0.5, room=10.0, swing_damping=0.0, drag=drag)
        around = surroundings_of((0.0, 0.0, 0.0), 1, fields, drag)
        paint = {"follow": np.zeros(surface.vertex_count, np.float32)}
        frame = None
        for seconds in (0.0, 1.0 / 60.0):
            given = ClothInput(mesh.positions, world_from_object, None, seconds, around)
            frame = cloth.solve(settings, paint, given, frame)
        return frame.state.velocity @ world_from_object.T * unit_scale

    def check(self, fields: list[Field], acceleration: tuple[float, float, float]) -> None:
        turned = np.array(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        for matrix in (np.eye(3), turned):
            for unit_scale in (1.0, 0.01):
                found = self.velocity(fields, matrix, unit_scale).mean(axis=0) * 60.0
                # the pull back to the animation takes 150 / s^2 of the way: 4 %
                np.testing.assert_allclose(found, acceleration, rtol=0.05, atol=0.05)

    def test_a_strength_is_of_area_and_in_metres_whatever_the_units_and_the_turn_of_the_object(self) -> None:
        push = replace(FORCE, location=(0.0, -1e6, 0.0), strength=6.0)
        self.check([push], (0.0, 6.0 * FIELD / 0.5, 0.0))

    def test_a_wind_on_every_vertex_is_the_single_wind(self) -> None:
        limited = replace(WIND, most=1e6)
        turned = np.array(((0.6, -0.8, 0.0), (0.8, 0.6, 0.0), (0.0, 0.0, 1.0)))
        single = self.velocity([WIND], turned)
        np.testing.assert_allclose(self.velocity([limited], turned), single, rtol=1e-6, atol=1e-7)
        self.assertGreater(np.abs(single).max(), 0.1)

    def test_force_pushes_away(self) -> None:
        found = self.velocity([replace(FORCE, shape="LINE", location=(0.0, 0.0, 0.0))], np.eye(3))
        radial = tube(8, 6, 0.1, 0.5).positions[:, :2]
        self.assertGreater((found[:, :2] * radial[:len(found)]).sum(axis=1).min(), 0.0)


if __name__ == "__main__":
    unittest.main()
