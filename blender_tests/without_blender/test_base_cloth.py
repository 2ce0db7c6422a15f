# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth by itself: how it hangs where the shape at rest, a hold or the unit of length decides it."""
from __future__ import annotations

import unittest
from unittest import mock

import numpy as np
from rumple.core.cloth.base_cloth import HANGING, BaseCloth, ClothInput
from rumple.core.settings.cloth_settings import ClothSettings
from support.meshes import tube


class Legs(unittest.TestCase):
    def test_a_leg_that_is_drawn_up_rides_up(self) -> None:
        """Nothing is painted. The hold of borders grows with the cube of what is suggested, up to that of a waistband:
        legs held an eighth as firmly did not move."""
        for radius in (0.05, 0.06, 0.07):
            base = tube(24, 30, radius, length=1.0)
            height = base.positions[:, 2]
            drawn = base.positions.copy()
            drawn[:, 2] += 0.04 * np.clip(2.5 * (height - 0.6), 0.0, 1.0)
            cloth = BaseCloth(base.surface(True), base.diagonal(), 1.0)
            way = cloth.solve(ClothSettings(base_cloth="HANG"), {}, ClothInput(drawn)).positions - drawn
            self.assertGreater(way[height == 0.0, 2].min(), 0.028, radius)
            self.assertLess(np.abs(way[height > 0.99]).max(), 1e-3, radius)


class WideTube(unittest.TestCase):
    """A tube that lies, held at one end: along it, and around the wider one, cloth turns by its weight."""

    LYING = np.array(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))

    def hung(self, unit_scale: float = 1.0, base_cloth: str = "HANG") -> np.ndarray:
        """(n, 3) metres."""
        mesh = tube(16, 10, 0.1 / unit_scale, 0.5 / unit_scale)
        settings = ClothSettings(base_cloth=base_cloth, room=0.2, slide_room=0.2)
        follow = (mesh.positions[:, 2] == mesh.positions[:, 2].min()).astype(np.float32)
        cloth = BaseCloth(mesh.surface(True), 1.0 / unit_scale, unit_scale)
        given = ClothInput(mesh.positions, self.LYING)
        return cloth.solve(settings, {"follow": follow}, given).positions * unit_scale

    def test_hanging_it_turns_more_than_cloth_that_is_firm_everywhere(self) -> None:
        turned = self.hung()
        with mock.patch.dict(HANGING, flat_share=1.0):
            self.assertGreater(np.linalg.norm(turned - self.hung(), axis=1).max(), 2e-3)

    def test_in_centimetres_it_is_as_in_metres(self) -> None:
        np.testing.assert_allclose(self.hung(0.01), self.hung(), atol=2e-4)

    def test_what_swings_is_firm_everywhere(self) -> None:
        swinging = self.hung(base_cloth="SWING")
        with mock.patch.dict(HANGING, flat_share=1.0):
            np.testing.assert_array_equal(self.hung(base_cloth="SWING"), swinging)


if __name__ == "__main__":
    unittest.main()
