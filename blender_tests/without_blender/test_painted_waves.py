# SPDX-License-Identifier: GPL-3.0-or-later
"""What is painted for the Wrinkle Field is what is shown: direction within 10 degrees, wavelength within 10 %; and less
of a mask moves nothing beside it."""
from __future__ import annotations

import math
import unittest

import numpy as np
from rumple.core.settings.system_settings import FieldSettings
from rumple.core.systems.wrinkle_field import WrinkleField, skin_wavelength
from support.frames import solve_frame
from support.meshes import compressed, sheet, tube

WAVELENGTH = 0.04  # metres
STRENGTH = 0.5
LEFT = 1.0 - STRENGTH ** 2  # of the cloth's width, as the guide says: so waves are narrower by it
EVERY = 7  # of the points: enough to tell waves apart
CANDIDATES = [2.0 * math.pi / length * np.array([math.cos(angle), math.sin(angle)])
              for length in WAVELENGTH * np.arange(0.5, 2.0, 0.02) for angle in np.radians(np.arange(0.0, 180.0, 2.0))]
SETTINGS = FieldSettings(output="GEOMETRY", wavelength=WAVELENGTH)


def solved(base: object, paint: dict[str, np.ndarray], positions: np.ndarray) -> tuple[WrinkleField, np.ndarray]:
    """The field, and how its points (n, 3) lie off the smooth surface."""
    field = WrinkleField.build(base, SETTINGS)
    return field, solve_frame(field, 1.0, positions, SETTINGS, paint, start=1).offset


class OfSkin(unittest.TestCase):
    def test_furrows_are_12_mm_apart_but_on_coarse_meshes_and_small_heads(self) -> None:
        for columns, size, asked in ((200, 0.3, 0.012), (30, 0.3, 0.02), (200, 0.1, 0.05 * math.sqrt(2.0) * 0.1)):
            self.assertAlmostEqual(skin_wavelength(sheet(columns, columns, size), 1.0), asked, places=5)
            self.assertAlmostEqual(skin_wavelength(sheet(columns, columns, 100.0 * size), 0.01), asked, places=5)


class OnASheet(unittest.TestCase):
    def setUp(self) -> None:
        self.base = sheet(32, 32, 0.6)
        self.normal = int(np.ptp(self.base.positions, axis=0).argmin())
        self.plane = [k for k in range(3) if k != self.normal]

    def waves(self, degrees: float, scale: float = 1.0) -> tuple[float, float]:
        """Painted everywhere: the angle of the crests, degrees, and the distance from one to the next, metres; in the
        middle of the sheet, where its heights have their strongest plane wave."""
        across = np.zeros((len(self.base.positions), 3), np.float32)
        across[:, self.plane] = -math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        paint = {"rest_wrinkle": STRENGTH * across,
                 "wavelength": np.full(len(across), scale, np.float32)}
        field, offset = solved(self.base, paint, self.base.positions)
        from_middle = field.shown.positions_rest[:, self.plane]
        from_middle = from_middle - from_middle.mean(axis=0)
        inside = np.flatnonzero((np.abs(from_middle) < 0.2).all(axis=1))[::EVERY]
        window = np.prod(np.cos(0.5 * math.pi * from_middle[inside] / 0.2) ** 2, axis=1)
        height = window * offset[inside, self.normal]
        strongest = max(CANDIDATES, key=lambda wave: abs(height @ np.exp(1j * (from_middle[inside] @ wave))))
        across_found = math.degrees(math.atan2(strongest[1], strongest[0]))
        return across_found % 180.0 - 90.0, 2.0 * math.pi / math.hypot(*strongest)

    def test_waves_run_as_painted(self) -> None:
        for degrees in (0.0, 25.0, 60.0, 90.0, 135.0):
            with self.subTest(degrees):
                found, length = self.waves(degrees)
                self.assertLess(abs((found - degrees + 90.0) % 180.0 - 90.0), 10.0)
                self.assertLess(abs(length / LEFT / WAVELENGTH - 1.0), 0.1)

    def test_a_painted_wavelength_is_the_one_that_is_shown(self) -> None:
        for scale in (0.75, 1.0, 1.5):
            with self.subTest(scale):
                self.assertLess(abs(self.waves(30.0, scale)[1] / (scale * LEFT * WAVELENGTH) - 1.0), 0.1)


class OnATube(unittest.TestCase):
    def test_less_of_the_mask_moves_nothing_beside_it(self) -> None:
        base = tube(48, 32, 0.06, 0.8)
        near = base.positions[:, 2] < 0.2
        vectors = np.zeros((len(near), 3), np.float32)
        vectors[near] = 0.0, 0.0, STRENGTH
        (field, one), (_, two) = (
            solved(base, {"rest_wrinkle": vectors, "mask": np.where(near, mask, 1.0).astype(np.float32)},
                   compressed(base.positions, 0.9)) for mask in (1.0, 0.5))
        moved = np.linalg.norm(one - two, axis=1)
        far = field.shown.positions_rest[:, 2] > 0.2 + 3.0 * WAVELENGTH
        self.assertGreater(moved[~far].max(), 0.001)
        self.assertLess(np.percentile(moved[far], 99), 1e-4)


if __name__ == "__main__":
    unittest.main()
