# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted maps as arrays: gradients from open borders, and values of images."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.paint import paint_maps


def sheet(across: int, up: int, cell: float = 0.1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A sheet of quads in the plane z = 0: positions, edges, and how many faces each has."""
    positions = np.array([(cell * x, cell * y, 0.0) for y in range(up + 1) for x in range(across + 1)], np.float32)
    number = np.arange(len(positions)).reshape(up + 1, across + 1)
    beside = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], 1)
    above = np.stack([number[:-1].ravel(), number[1:].ravel()], 1)
    uses_beside = np.full((up + 1, across), 2)
    uses_beside[[0, -1]] = 1
    uses_above = np.full((up, across + 1), 2)
    uses_above[:, [0, -1]] = 1
    return positions, np.concatenate([beside, above]), np.concatenate([uses_beside.ravel(), uses_above.ravel()])


class Numbers(unittest.TestCase):
    def test_mean_and_share(self) -> None:
        weights = np.array((1.0, 0.5, 0.0, 1.0), np.float32)
        self.assertEqual(paint_maps.numbers(weights, 1.0), (0.625, 0.5))
        self.assertEqual(paint_maps.numbers(weights, 0.0), (0.625, 0.75))
        self.assertEqual(paint_maps.numbers(np.zeros(0, np.float32), 1.0), (0.0, 0.0))


class Border(unittest.TestCase):
    def away(self, positions: np.ndarray, edges: np.ndarray, uses: np.ndarray, most: float = 10.0,
             weld: bool = True) -> np.ndarray:
        border, same = paint_maps.open_edges(edges, uses, positions, weld)
        return paint_maps.border_distance(positions, same[edges], same[edges[border]], most)[same]

    def test_on_a_flat_sheet_it_is_the_distance_to_the_rim(self) -> None:
        positions, edges, uses = sheet(9, 7)
        x, y, _ = positions.T
        exact = np.minimum(np.minimum(x, 0.9 - x), np.minimum(y, 0.7 - y))
        np.testing.assert_allclose(self.away(positions, edges, uses), exact, atol=1e-6)

    def test_to_the_edges_and_not_to_their_vertices(self) -> None:
        """A fan over one long border edge: its tip is over the middle."""
        positions = np.array(((0, 0, 0), (4, 0, 0), (2, 1, 0), (2, 3, 0)), np.float32)
        edges, uses = np.array(((0, 1), (1, 2), (2, 0), (1, 3), (3, 0), (2, 3))), np.array((1, 2, 2, 2, 2, 2))
        np.testing.assert_allclose(self.away(positions, edges, uses), (0.0, 0.0, 1.0, 3.0), atol=1e-6)

    def test_behind_the_distance_and_without_a_border_it_is_infinite(self) -> None:
        positions, edges, uses = sheet(9, 7)
        near = self.away(positions, edges, uses, most=0.15)
        np.testing.assert_array_equal(np.isinf(near), self.away(positions, edges, uses) > 0.15)
        island = np.concatenate([positions, positions + (5.0, 0.0, 0.0)]).astype(np.float32)
        both = self.away(island, np.concatenate([edges, edges + len(positions)]),
                         np.concatenate([uses, np.full_like(uses, 2)]))
        self.assertTrue(np.isinf(both[len(positions):]).all())
        self.assertTrue(np.isfinite(both[:len(positions)]).all())

    def test_it_is_reached_along_the_mesh(self) -> None:
        """Two sheets 1 mm apart: the border of one is none of the other, as of a hem over trousers."""
        positions, edges, uses = sheet(9, 7)
        layers = np.concatenate([positions, positions + (0.35, 0.0, 0.001)]).astype(np.float32)
        both = self.away(layers, np.concatenate([edges, edges + len(positions)]), np.concatenate([uses, uses]))
        np.testing.assert_allclose(both[:len(positions)], self.away(positions, edges, uses), atol=1e-6)

    def test_a_seam_is_no_border_where_seams_are_welded(self) -> None:
        positions, edges, uses = sheet(8, 4)
        number = np.arange(len(positions)).reshape(5, 9)
        seam = number[:, 4]
        right = np.isin(edges, number[:, 5:]).any(1) & np.isin(edges, seam).any(1)  # edges that leave it to the right
        copies = np.arange(len(positions), len(positions) + len(seam))
        cut = edges.copy()
        for vertex, copy in zip(seam, copies):
            cut[right] = np.where(cut[right] == vertex, copy, cut[right])
        along = np.isin(edges, seam).all(1)
        cut = np.concatenate([cut, copies[np.searchsorted(seam, edges[along])]])
        uses_cut = np.concatenate([np.where(along, 1, uses), np.ones(along.sum(), int)])
        split = np.concatenate([positions, positions[seam]])
        whole = self.away(positions, edges, uses)
        np.testing.assert_allclose(self.away(split, cut, uses_cut), np.concatenate([whole, whole[seam]]), atol=1e-6)
        self.assertEqual(self.away(split, cut, uses_cut, weld=False)[seam].max(), 0.0)

    def test_the_gradient(self) -> None:
        away = np.array((0.0, 0.01, 0.025, 0.05, 0.2, np.inf), np.float32)
        np.testing.assert_allclose(paint_maps.gradient(away, 0.05, False), (0.0, 0.2, 0.5, 1.0, 1.0, 1.0), atol=1e-6)
        np.testing.assert_allclose(paint_maps.gradient(away, 0.05, True), (0.0, 0.104, 0.5, 1.0, 1.0, 1.0), atol=1e-6)
        np.testing.assert_array_equal(paint_maps.gradient(away, 0.0, True), (0.0, 1.0, 1.0, 1.0, 1.0, 1.0))


class Image(unittest.TestCase):
    PIXELS = np.array([[(0.0, 0.5, 1.0, 0.25), (1.0, 1.0, 1.0, 1.0)],
                       [(0.2, 0.2, 0.2, 0.0), (2.0, -1.0, np.nan, 0.5)]], np.float32)

    def test_channels(self) -> None:
        for channel, expected in (("RED", ((0.0, 1.0), (0.2, 1.0))), ("GREEN", ((0.5, 1.0), (0.2, 0.0))),
                                  ("BLUE", ((1.0, 1.0), (0.2, 0.0))), ("ALPHA", ((0.25, 1.0), (0.0, 0.5)))):
            np.testing.assert_allclose(paint_maps.channel_of(self.PIXELS, channel), expected, atol=1e-6)
        bright = paint_maps.channel_of(self.PIXELS[:, :, :], "LUMINANCE")
        np.testing.assert_allclose(bright[0], (0.7152 * 0.5 + 0.0722, 1.0), atol=1e-6)
        self.assertAlmostEqual(float(bright[1, 0]), 0.2, 6)
        grey = self.PIXELS[:, :, :1]
        for channel in ("LUMINANCE", "RED", "GREEN", "BLUE"):
            np.testing.assert_allclose(paint_maps.channel_of(grey, channel), ((0.0, 1.0), (0.2, 1.0)), atol=1e-6)
        np.testing.assert_array_equal(paint_maps.channel_of(grey, "ALPHA"), np.ones((2, 2)))

    def test_between_pixels_linearly_and_repeated(self) -> None:
        values = np.array(((0.0, 1.0), (0.5, 0.25)), np.float32)
        uv = np.array(((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.5, 0.25), (0.5, 0.5), (0.0, 0.25), (1.25, -0.75),
                       (np.nan, np.inf)), np.float32)
        corner = 0.25 * values.sum()
        np.testing.assert_allclose(paint_maps.sampled(values, uv), (0.0, 1.0, 0.5, 0.5, corner, 0.5, 0.0, corner),
                                   atol=1e-6)

    def test_a_vertex_has_the_mean_of_its_corners(self) -> None:
        values = np.array((0.0, 1.0, 0.5), np.float32)
        np.testing.assert_array_equal(paint_maps.on_vertices(values, np.array((0, 0, 2)), 4, np.full(4, 0.75)),
                                      (0.5, 0.75, 0.5, 0.75))


if __name__ == "__main__":
    unittest.main()
