# SPDX-License-Identifier: GPL-3.0-or-later
"""How tall a figure is by its meshes and bones, and the factor on lengths that follows from that."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.mesh.figure_size import GIANT, PERSON, height_of, size_factor

SPINE = (0.95, 1.1, 1.3, 1.5, 1.58)
LEG, ARM = (0.92, 0.5, 0.08), (1.45, 1.45, 1.45, 1.45)


def person(legs: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """Heads and parents of a person of 1.8 m: a spine, legs, and arms to the sides."""
    heads, parents = [(0.0, 0.0, height) for height in SPINE], list(range(-1, len(SPINE) - 1))
    for side in (1.0, -1.0):
        for limb, at, reach in ((LEG, 0, 0.0), (ARM, 2, 0.2)) if legs else ((ARM, 2, 0.2),):
            for number, height in enumerate(limb):
                parents.append(len(heads) - 1 if number else at)
                heads.append((side * (0.1 + number * reach), 0.0, height))
    return np.array(heads), np.array(parents)


def box(width: float, depth: float, low: float, high: float) -> tuple[tuple[float, ...], ...]:
    return (-0.5 * width, -0.5 * depth, low), (0.5 * width, 0.5 * depth, high)


class Factor(unittest.TestCase):
    def test_it_is_one_for_people_and_true_to_scale_for_others(self) -> None:
        for height in (*PERSON, 1.0, 1.75, 2.5):
            for diagonal in (0.1, 5.0):
                self.assertEqual(size_factor(diagonal, 1.0, height), 1.0)
        for height in (0.1, 0.5, 4.0, 4.6, 100.0):
            self.assertAlmostEqual(size_factor(1.9, 1.0, height), height / 1.75, 6)
            self.assertAlmostEqual(size_factor(190.0, 0.01, 100.0 * height), height / 1.75, 6)

    def test_it_grows_without_a_jump(self) -> None:
        factors = [size_factor(1.0, 1.0, height) for height in np.linspace(0.2, 6.0, 5801).tolist()]
        steps = np.diff(factors)
        self.assertGreaterEqual(steps.min(), 0.0)
        self.assertLess(steps.max(), 3e-3)

    def test_without_a_figure_the_garment_tells(self) -> None:
        self.assertEqual([size_factor(size, 1.0) for size in (0.2, 0.4, 3.0, 2.0 * GIANT)], [0.5, 1.0, 1.0, 2.0])


class Height(unittest.TestCase):
    def setUp(self) -> None:
        self.heads, self.parents = person()
        self.shirt, self.body = box(0.5, 0.3, 0.9, 1.5), box(1.7, 0.3, 0.0, 1.8)

    def height(self, scale: float, *boxes: tuple) -> float:
        return height_of(scale * np.array(boxes), scale * self.heads, self.parents) / scale

    def test_body_and_bones(self) -> None:
        for scale in (0.1, 1.0, 10.0):
            self.assertAlmostEqual(self.height(scale, self.shirt, self.body), 1.8, 6)
            self.assertAlmostEqual(self.height(scale, self.shirt), 1.65, 6)

    def test_banners_and_targets(self) -> None:
        self.assertLessEqual(self.height(1.0, self.shirt, self.body, box(1.0, 0.1, 0.0, 8.0)), PERSON[1])
        self.heads = np.concatenate([self.heads, [(0.0, 5.0, 9.0), (0.0, -5.0, 9.5), (0.0, 0.0, -7.0)]])
        self.parents = np.append(self.parents, [0, 0, 0])
        for scale in (0.1, 1.0, 10.0):
            self.assertAlmostEqual(self.height(scale, self.shirt, self.body), 1.8, 6)

    def test_a_bust_and_two_arms_say_nothing(self) -> None:
        heads, parents = person(legs=False)
        boxes = np.array((box(0.3, 0.3, 1.3, 1.5), box(0.5, 0.3, 0.95, 1.75)))
        self.assertEqual(height_of(boxes, heads, parents), 0.0)
        self.heads = self.heads * (1.0, 1.0, 0.2)
        self.assertEqual(self.height(1.0, box(1.7, 0.2, 0.0, 0.4)), 0.0)

    def test_animals(self) -> None:
        """Four legs with four bones each under a spine along y. A horse counts as a person, a dog as unknown."""
        heads, parents = [(0.0, y, 1.3) for y in (0.8, 0.4, 0.0, -0.4, -0.8)], [-1, 0, 1, 2, 3]
        for at, y in ((0, 0.8), (4, -0.8)):
            for side in (0.2, -0.2):
                for number, height in enumerate((1.1, 0.8, 0.45, 0.1)):
                    parents.append(len(heads) - 1 if number else at)
                    heads.append((side, y, height))
        cover, body = box(0.6, 1.5, 0.7, 1.4), box(0.6, 2.4, 0.0, 1.7)
        for scale, expected in ((1.0, 1.7), (0.3, 0.0), (5.0, 8.5)):
            found = height_of(scale * np.array((cover, body)), scale * np.array(heads), np.array(parents))
            self.assertAlmostEqual(found, expected, 6)

    def test_few_bones_tell_of_a_person_at_most(self) -> None:
        for scale, expected in ((0.2, 0.0), (1.0, 1.8), (3.0, 0.0)):
            found = height_of(scale * np.array((self.shirt, self.body)), self.heads[:3], self.parents[:3])
            self.assertAlmostEqual(found, expected, 6)


if __name__ == "__main__":
    unittest.main()
