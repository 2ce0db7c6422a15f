# SPDX-License-Identifier: GPL-3.0-or-later
"""Which garments the first click takes for skirts, which for trousers with loose legs, and which for sheets."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.paint.hangs_free import share_of_sheet
from rumple.core.parts.flared import has_loose_legs, is_flared, is_sheet
from rumple.core.systems.wrinkle_mesh import (
    CLOTH_WAVELENGTH, LOOSE_LEGS_SLACK, SHEET_WAVELENGTH, SKIRT_WAVELENGTH, cloth_defaults)
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
        self.assertTrue(is_flared(cone(0.13, 0.3), UPRIGHT[2]))
        self.assertFalse(is_flared(cone(0.13, 0.13), UPRIGHT[2]))
        self.assertFalse(is_flared(cone(0.3, 0.13), UPRIGHT[2]))

    def test_below_is_where_the_world_has_it(self) -> None:
        skirt = cone(0.13, 0.3)
        lying = replace(skirt, positions=-skirt.positions)
        self.assertFalse(is_flared(lying, UPRIGHT[2]))
        self.assertTrue(is_flared(lying, -UPRIGHT[2]))

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
        self.assertTrue(is_flared(quad_mesh("Skirt", points, split), UPRIGHT[2]))

    def test_a_third_opening_makes_it_another_garment(self) -> None:
        skirt = cone(0.13, 0.3)
        quads = np.delete(skirt.corner_vertex.reshape(-1, 4), 100, axis=0)
        self.assertFalse(is_flared(quad_mesh("Holed", skirt.positions, quads), UPRIGHT[2]))

    def test_it_gets_few_wide_folds_and_what_else_cloth_gets(self) -> None:
        found = [cloth_defaults(base, 1.0, UPRIGHT, sheet) for base, sheet in (
            (cone(0.13, 0.3), False), (sheet_of(1.2, 1.6), True), (sheet_of(0.6, 0.8), True),
            (sheet_of(0.3, 0.4), True), (cone(0.13, 0.13), False))]
        self.assertEqual([settings.pop("wavelength") for settings in found],
                         [SKIRT_WAVELENGTH, SKIRT_WAVELENGTH, 0.1, SHEET_WAVELENGTH, CLOTH_WAVELENGTH])
        for settings in found[:-1]:
            self.assertEqual(settings, found[-1])


def sheet_of(wide: float, high: float, bulge: float = 0.0) -> BaseMesh:
    """8 by 8 quads, upright in X and Z, metres, that stand out by so much in the middle."""
    across, up = np.meshgrid(np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 9))
    out = bulge * np.sin(np.pi * across) * np.sin(np.pi * up)
    points = np.stack([wide * across, out, high * up], -1).reshape(-1, 3).astype(np.float32)
    first = (np.arange(8)[:, None] * 9 + np.arange(8)).reshape(-1, 1)
    return quad_mesh("Sheet", points, first + np.array([0, 1, 10, 9]))


def together(*bases: BaseMesh) -> BaseMesh:
    """Beside one another, as parts of one mesh."""
    first = np.cumsum([0, *(len(base.positions) for base in bases)])
    return quad_mesh("Parts", np.concatenate([base.positions + (3.0 * k, 0.0, 0.0) for k, base in enumerate(bases)]),
                     np.concatenate([base.corner_vertex.reshape(-1, 4) + start for base, start in zip(bases, first)]))


def legs(radius: float = 0.065, length: float = 0.9, figure: float = 1.75, other_lower: float = 0.0) -> BaseMesh:
    """Two tubes beside each other, metres: where trousers end, this is all that counts. A leg is 0.065 wide where jeans
    end, an ankle 0.04."""
    leg = tube(24, 8, radius, length)
    base = together(leg, replace(leg, positions=leg.positions - np.float32((0.0, 0.0, other_lower))))
    base.figure = figure
    return base


class LooseLegs(unittest.TestCase):

    def test_straight_legs_have_them_and_leggings_do_not(self) -> None:
        self.assertTrue(has_loose_legs(legs(), UPRIGHT[2]))
        self.assertFalse(has_loose_legs(legs(radius=0.04), UPRIGHT[2]))

    def test_wide_is_relative_to_the_figure_in_any_unit(self) -> None:
        self.assertFalse(has_loose_legs(legs(figure=2.5), UPRIGHT[2]))
        self.assertFalse(has_loose_legs(legs(figure=0.0), UPRIGHT[2]))  # not known
        in_centimetres = replace(legs(), positions=100.0 * legs().positions)
        in_centimetres.figure = 175.0
        self.assertTrue(has_loose_legs(in_centimetres, UPRIGHT[2]))

    def test_shorts_skirts_and_sleeves_at_other_heights_are_none(self) -> None:
        for other in (legs(length=0.3), legs(other_lower=0.3), cone(0.13, 0.3)):
            other.figure = 1.75
            self.assertFalse(has_loose_legs(other, UPRIGHT[2]))

    def test_a_jacket_above_them_changes_nothing(self) -> None:
        jacket = tube(24, 8, 0.2, 0.6)
        dressed = together(replace(jacket, positions=jacket.positions + np.float32((0.0, 0.0, 1.0))), legs())
        dressed.figure = 1.75
        self.assertTrue(has_loose_legs(dressed, UPRIGHT[2]))

    def test_they_get_slack_and_what_else_cloth_gets(self) -> None:
        loose, tight = (cloth_defaults(legs(radius), 1.0, UPRIGHT) for radius in (0.065, 0.04))
        self.assertEqual(loose, {**tight, "slack": LOOSE_LEGS_SLACK})
        self.assertNotIn("slack", tight)


class Sheets(unittest.TestCase):
    PERSON = np.array([(0.0, 0.0, 0.0), (0.6, 0.3, 1.8)])  # metres: two corners of the box

    def test_capes_and_scarves_are(self) -> None:
        for cape in (sheet_of(1.0, 1.0), sheet_of(0.25, 1.4), sheet_of(1.0, 1.0, 0.3)):
            self.assertTrue(is_sheet(cape, self.PERSON))
        self.assertTrue(is_sheet(together(sheet_of(1.0, 1.0), sheet_of(0.1, 0.1)), self.PERSON))  # with a patch

    def test_hats_masks_clothes_and_cards_of_hair_are_not(self) -> None:
        deep = sheet_of(1.0, 1.0, 1.2)
        self.assertFalse(is_sheet(deep, self.PERSON))
        self.assertFalse(is_sheet(sheet_of(0.25, 0.3), self.PERSON))
        for clothes in (cone(0.13, 0.3), tube(24, 8, 0.3, 0.2)):
            self.assertFalse(is_sheet(clothes, self.PERSON))
        self.assertFalse(is_sheet(together(*[sheet_of(0.03, 0.6)] * 3), self.PERSON))
        self.assertFalse(is_sheet(replace(deep, positions=np.zeros_like(deep.positions)), self.PERSON))

    def test_they_hang_free_below_their_upper_end(self) -> None:
        cape = sheet_of(1.0, 1.0)
        free = share_of_sheet(cape.positions)
        self.assertEqual(free[-9:].max(), 0.0)
        self.assertEqual(free[:45].min(), 1.0)
        self.assertTrue((np.diff(free[::9]) <= 0.0).all())
        near = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, 0.93), (1.0, 0.0, 0.0)])  # at 5 % of the diagonal
        np.testing.assert_array_equal(share_of_sheet(near), [0.0, 0.0, 1.0])


if __name__ == "__main__":
    unittest.main()
