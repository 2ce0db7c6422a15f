# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a body is under a garment while both are at rest."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.cloth import worn_at_rest
from rumple.core.mesh.base_mesh import BaseMesh
from support.meshes import tube


def shifted(made: BaseMesh, way: tuple[float, float, float]) -> np.ndarray:
    return made.positions + np.array(way, np.float32)


def triangles_of(made: BaseMesh) -> np.ndarray:
    return np.ascontiguousarray(made.corner_vertex[made.triangle_corner])


class Covered(unittest.TestCase):
    """A leg along z under a skirt that is 15 cm away from it, and an arm beside the skirt."""

    def setUp(self) -> None:
        self.skirt = tube(60, 40, 0.2, 0.5)
        self.limb = tube(20, 40, 0.05, 0.4)

    def covered(self, limb: np.ndarray, size: float = 1.0) -> np.ndarray:
        outwards = self.skirt.positions * np.array((5.0, 5.0, 0.0), np.float32)
        return worn_at_rest.is_covered(limb, triangles_of(self.limb), size * self.skirt.positions, outwards, size)

    def test_a_leg_in_a_skirt_is_and_an_arm_beside_it_is_not(self) -> None:
        for size in (1.0, 100.0):
            leg, arm = (size * shifted(self.limb, way) for way in ((0.0, 0.0, 0.05), (0.3, 0.0, 0.05)))
            self.assertTrue(self.covered(leg, size).all())
            self.assertFalse(self.covered(arm, size).any())

    def test_a_garment_that_is_elsewhere_was_not_modelled_on_it(self) -> None:
        for way, expected in (((0.0, 0.0, 0.05), True), ((2.0, 0.0, 0.0), False)):
            self.assertEqual(worn_at_rest.is_worn(self.skirt.positions, shifted(self.limb, way)), expected)


if __name__ == "__main__":
    unittest.main()
