# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of garments whose thickness was modelled: their outer side is cloth, and the inner side goes along with it."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
from rumple.core.mesh import outer_side
from rumple.core.mesh.base_mesh import BaseMesh, built_once
from rumple.core.mesh.body import Body
from rumple.core.settings.system_settings import MeshSettings
from rumple.core.systems.wrinkle_mesh import WrinkleMesh, cloth_defaults, suits_cloth
from rumple.native import kernels
from support.frames import solve_frame
from support.meshes import thick_tube, tube

AROUND, ALONG, RADIUS, LENGTH, THICKNESS = 21, 17, 0.1, 0.5, 0.004
OUTER = AROUND * (ALONG + 1)  # vertices of one side


def thick_sleeve() -> BaseMesh:
    return thick_tube(AROUND, ALONG, RADIUS, LENGTH, THICKNESS)


def pushed_together(base: BaseMesh, factor: float) -> np.ndarray:
    return np.ascontiguousarray(base.positions * np.array((1.0, 1.0, factor)), np.float32)


class Sleeve(unittest.TestCase):
    def setUp(self) -> None:
        self.base = thick_sleeve()
        self.settings = MeshSettings(**cloth_defaults(outer_side.without_inner_side(self.base), 1.0, np.eye(3)))
        self.mesh = WrinkleMesh.build(self.base, self.settings)

    def played(self, mesh: WrinkleMesh, settings: MeshSettings, body: Body | None = None) -> Any:
        for frame in range(1, 6):
            picture = solve_frame(mesh, float(frame), pushed_together(mesh.base, 1.0 - 0.04 * frame), settings, {},
                                  start=1, body=body)
        return picture

    def test_its_outer_side_has_the_openings_of_a_garment(self) -> None:
        self.assertFalse(suits_cloth(self.base))
        outer = outer_side.without_inner_side(self.base)
        self.assertTrue(suits_cloth(outer))
        self.assertEqual(len(outer.polygon_start) - 1, AROUND * ALONG)
        np.testing.assert_array_equal(outer_side.triangles_of(self.base).max(), OUTER - 1)
        self.assertEqual(outer_side.triangles_of(self.base).min(), 0)

    def test_the_first_click_searches_it_once_for_equal_meshes(self) -> None:
        """A click reads a garment ten times. On 98,000 vertices each search took 0.4 s."""
        alone = outer_side.without_inner_side(self.base)
        with built_once(), mock.patch.object(kernels, "outer_side", wraps=kernels.outer_side) as searched:
            for _ in range(3):
                again = outer_side.without_inner_side(thick_sleeve())
                np.testing.assert_array_equal(again.corner_vertex, alone.corner_vertex)
            self.assertEqual(searched.call_count, 1)
            outer_side.without_inner_side(replace(self.base, positions=2.0 * self.base.positions))
            self.assertEqual(searched.call_count, 2)

    def test_a_garment_without_a_thickness_is_as_it_is(self) -> None:
        for base in (tube(AROUND, ALONG, RADIUS, LENGTH), tube(AROUND, ALONG, 0.002, LENGTH)):
            self.assertIs(outer_side.without_inner_side(base), base)

    def test_the_outer_side_alone_is_solved_and_pinned(self) -> None:
        outer = self.mesh.outer
        assert outer is not None
        self.assertAlmostEqual(outer.thickness, THICKNESS, delta=0.1 * THICKNESS)
        self.assertLess(self.mesh.coarse.base_vertex.max(), OUTER)
        follow = self.mesh.suggested_follow(self.settings)
        np.testing.assert_array_equal(follow[OUTER:], 0.0)
        self.assertGreater(follow[:OUTER].max(), 0.9)
        self.assertIn("Thickness of 4.0 mm: the inner side moves with the outer one",
                      self.mesh.status(self.played(self.mesh, self.settings)))

    def test_a_level_by_hand_and_no_base_cloth_take_the_outer_side_as_well(self) -> None:
        for values in (dict(density="LEVEL", level=1), dict(base_cloth="OFF")):
            self.assertIsNotNone(WrinkleMesh.build(self.base, replace(self.settings, **values)).outer, values)

    def test_the_inner_side_stays_behind_the_outer_one(self) -> None:
        """Of every shown vertex of the inner side that was right behind one of the outer side."""
        rest, shown = self.mesh.positions_rest, self.played(self.mesh, self.settings).positions
        at, low = np.linalg.norm(rest[:, :2], axis=1), RADIUS - 0.5 * THICKNESS
        middle = np.abs(rest[:, 2] - 0.5 * LENGTH) < 0.3 * LENGTH
        outer, inner = np.flatnonzero((at > low) & middle), np.flatnonzero((at <= low) & middle)[::17]
        distance = np.linalg.norm(rest[inner][:, None] - rest[outer][None], axis=2)
        behind = outer[distance.argmin(axis=1)]
        paired = distance.min(axis=1) < 1.2 * THICKNESS
        self.assertGreater(paired.mean(), 0.9)
        apart = np.linalg.norm(shown[inner] - shown[behind], axis=1)[paired]
        self.assertLess(apart.max(), 2.0 * THICKNESS)
        self.assertGreater(apart.min(), 0.4 * THICKNESS)
        radius = np.linalg.norm(shown[:, :2], axis=1)
        self.assertGreater((radius[behind] - radius[inner])[paired].min(), 0.0)
        self.assertGreater(np.ptp(radius[behind]), THICKNESS)  # of folds

    def test_it_folds_as_much_as_without_a_thickness(self) -> None:
        settings = replace(self.settings, gravity=0.0)
        thin = tube(AROUND, ALONG, RADIUS, LENGTH)
        heights = []
        for base in (thin, self.base):
            picture = self.played(WrinkleMesh.build(base, settings), settings)
            heights.append(float(np.sqrt((picture.offset ** 2).sum(axis=1).mean())))
        self.assertLess(abs(heights[1] - heights[0]), 0.5 * heights[0], heights)

    def test_its_inner_side_stays_out_of_a_body(self) -> None:
        inside = tube(40, 31, 0.95 * RADIUS, LENGTH)
        body = Body(inside.positions, inside.triangles)
        shown = self.played(self.mesh, self.settings, body).positions
        middle = np.abs(shown[:, 2] - shown[:, 2].mean()) < 0.3 * LENGTH
        radius = np.linalg.norm(shown[middle, :2], axis=1)
        self.assertGreater(radius.min(), 0.95 * RADIUS * np.cos(np.pi / 40.0) - 0.25 * THICKNESS)

    def test_rest_without_gravity_stays_where_it_was_modelled(self) -> None:
        still = replace(self.settings, gravity=0.0, slack=1.0, radius=0.0, room=0.0)
        picture = solve_frame(self.mesh, 1.0, self.base.positions, still, {}, start=1)
        np.testing.assert_allclose(picture.positions, self.mesh.positions_rest, atol=1e-6)


if __name__ == "__main__":
    unittest.main()
