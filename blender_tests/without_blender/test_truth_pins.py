# SPDX-License-Identifier: GPL-3.0-or-later
"""Which borders of a garment scripts/ground_truth holds, on tubes put together like garments."""
from __future__ import annotations

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import truth_pins as pins  # noqa: E402

AROUND, RINGS = 24, 40


def tube(start: tuple, end: tuple, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """An open tube between two points: points (n, 3) metres and triangles (t, 3)."""
    a, b = np.array(start, float), np.array(end, float)
    axis = (b - a) / np.linalg.norm(b - a)
    side = np.cross(axis, (0.0, 1.0, 0.0))
    side /= np.linalg.norm(side)
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    circle = radius * (np.outer(np.cos(angle), side) + np.outer(np.sin(angle), np.cross(axis, side)))
    points = (a + np.linspace(0.0, 1.0, RINGS)[:, None, None] * (b - a) + circle).reshape(-1, 3)
    number = np.arange(RINGS * AROUND).reshape(RINGS, AROUND)
    p, q = number[:-1], np.roll(number, -1, axis=1)[:-1]
    r, s = number[1:], np.roll(number, -1, axis=1)[1:]
    return points, np.concatenate([np.stack([p, q, s], 2).reshape(-1, 3), np.stack([p, s, r], 2).reshape(-1, 3)])


def together(*tubes: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """One mesh of several."""
    starts = np.cumsum([0] + [len(points) for points, _ in tubes])
    return (np.concatenate([points for points, _ in tubes]),
            np.concatenate([triangles + first for (_, triangles), first in zip(tubes, starts)]))


class Pins(unittest.TestCase):
    def test_kinds_by_shape(self) -> None:
        """Every border of a trunk with two sleeves: what looks up, down and aside is told apart."""
        for radius, kind in ((0.035, "cuff"), (0.06, "short sleeve")):
            rest, triangles = together(tube((0, 0, 0.9), (0, 0, 1.5), 0.17), tube((0.2, 0, 1.4), (0.5, 0, 1.1), radius),
                                       tube((-0.2, 0, 1.4), (-0.5, 0, 1.1), radius))
            borders = pins.describe(rest, triangles, rest)
            self.assertEqual(len(borders), 6)
            ends = {b.kind for b in borders if abs(b.centre[0]) > 0.4}
            self.assertEqual(ends, {kind})
            trunk = {round(float(b.centre[2]), 1): b.kind for b in borders if abs(b.centre[0]) < 0.1}
            self.assertEqual(trunk, {0.9: "hem", 1.5: "collar"})

    def test_trousers_have_a_waistband(self) -> None:
        rest, triangles = together(tube((0, 0, 0.8), (0, 0, 1.1), 0.15), tube((0.1, 0, 0.8), (0.12, 0, 0.1), 0.06),
                                   tube((-0.1, 0, 0.8), (-0.12, 0, 0.1), 0.06))
        kinds = {b.kind for b in pins.describe(rest, triangles, rest) if b.centre[2] > 1.0 or b.centre[2] < 0.2}
        self.assertEqual(kinds, {"waistband", "leg"})

    def test_weights_fade(self) -> None:
        rest, triangles = tube((0, 0, 0.9), (0, 0, 1.5), 0.17)
        borders = pins.describe(rest, triangles, rest)
        weights = pins.hold(rest, triangles, borders).pins
        self.assertAlmostEqual(float(weights[rest[:, 2] > 1.499].min()), pins.STRENGTHS["collar"], places=5)
        self.assertEqual(float(weights[rest[:, 2] < 1.5 - pins.FALLOFF["collar"]].max()), 0.0)

    def test_what_has_no_border_is_held_wholly(self) -> None:
        """A belt or a buckle in the mesh would fall off the trousers."""
        trunk = tube((0, 0, 0.9), (0, 0, 1.5), 0.17)
        block = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.02 + (0.0, -0.2, 1.2)
        rest, triangles = together(trunk, (block, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])))
        borders = pins.describe(rest, triangles, rest)
        self.assertEqual(len(borders), 2)
        weights = pins.hold(rest, triangles, borders).pins
        np.testing.assert_array_equal(weights[-4:], 1.0)
        np.testing.assert_array_equal(weights[:-4], pins.hold(*trunk, borders).pins)

    def test_pin_by_wish(self) -> None:
        rest, triangles = tube((0, 0, 0.9), (0, 0, 1.5), 0.17)
        borders = pins.describe(rest, triangles, rest)
        pins.choose(borders, "hem=0.5,collar=0")
        self.assertEqual({b.kind: b.strength for b in borders}, {"hem": 0.5, "collar": 0.0})
        with self.assertRaises(SystemExit):
            pins.choose(borders, "pocket=1")


if __name__ == "__main__":
    unittest.main()
