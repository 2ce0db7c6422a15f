# SPDX-License-Identifier: GPL-3.0-or-later
"""Which garments the first click takes for skirts."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.base_mesh import BaseMesh
from rumple.core.flared import is_flared
from rumple.core.wrinkle_mesh import CLOTH_WAVELENGTH, SKIRT_LENGTHS, cloth_defaults
from support.meshes import quad_mesh, tube

UPRIGHT = np.eye(3)


def cone(top: float, bottom: float) -> BaseMesh:
    """A tube of 24 by 8 quads and 0.6 m along Z, with these radii."""
    base = tube(24, 8, 1.0, 0.6)
    share = np.ptp(base.positions[:, 2])
    along = (base.positions[:, 2:] - base.positions[:, 2].min()) / share
    radii = bottom + (top - bottom) * along
    return replace(base, positions=np.concatenate([radii * base.positions[:, :2], base.positions[:, 2:]], 1))


class Flared(unittest.TestCase):

    def test_two_openings_of_which_the_lower_one_is_far_wider(self) -> None:
        self.assertTrue(is_flared(cone(0.13, 0.3), UPRIGHT))
        self.assertFalse(is_flared(cone(0.13, 0.13), UPRIGHT))
        self.assertFalse(is_flared(cone(0.3, 0.13), UPRIGHT))

    def test_below_is_where_the_world_has_it(self) -> None:
        skirt = cone(0.13, 0.3)
        lying = replace(skirt, positions=-skirt.positions)
        self.assertFalse(is_flared(lying, UPRIGHT))
        self.assertTrue(is_flared(lying, -UPRIGHT))

    def test_a_seam_that_is_cut_is_no_opening(self) -> None:
        """UV seams are cut in games' meshes: the two sides of one are at the same places."""
        skirt = cone(0.13, 0.3)
        quads = skirt.corner_vertex.reshape(-1, 4)
        split, points = quads.copy(), skirt.positions
        column = np.flatnonzero(np.isclose(np.arctan2(points[:, 1], points[:, 0]), 0.0))
        beside = (points[quads][:, :, 1].mean(axis=1) < 0.0)
        for vertex in column:
            split[beside[:, None] & (quads == vertex)] = len(points)
            points = np.concatenate([points, points[vertex:vertex + 1]])
        self.assertTrue(is_flared(quad_mesh("Skirt", points, split), UPRIGHT))

    def test_a_third_opening_makes_it_another_garment(self) -> None:
        skirt = cone(0.13, 0.3)
        quads = np.delete(skirt.corner_vertex.reshape(-1, 4), 100, axis=0)
        self.assertFalse(is_flared(quad_mesh("Holed", skirt.positions, quads), UPRIGHT))

    def test_it_gets_few_wide_folds_and_what_else_cloth_gets(self) -> None:
        skirt, sleeve = (cloth_defaults(base, 1.0, UPRIGHT) for base in (cone(0.13, 0.3), cone(0.13, 0.13)))
        self.assertEqual({name: skirt[name] for name in SKIRT_LENGTHS}, SKIRT_LENGTHS)
        self.assertEqual(sleeve["wavelength"], CLOTH_WAVELENGTH)
        others = skirt.keys() - SKIRT_LENGTHS.keys()
        self.assertEqual({name: skirt[name] for name in others}, {name: sleeve[name] for name in others})


if __name__ == "__main__":
    unittest.main()
