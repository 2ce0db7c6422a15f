# SPDX-License-Identifier: GPL-3.0-or-later
"""Which meshes without an opening are garments."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.parts.closed_garment import bends, is_closed_garment
from support.meshes import quad_mesh, tube

UP = np.array((0.0, 0.0, 1.0))


def trousers(closed: tuple[float, ...] = (0.1, 1.1)) -> BaseMesh:
    """A tube of 1 m along Z with its lower end at 0.1 m, for a figure of 1.8 m. closed: the heights of closed ends."""
    base = tube(12, 20, 0.15, 1.0)
    points = base.positions - base.positions.min(axis=0) + np.float32((-0.15, -0.15, 0.1))
    quads = base.corner_vertex.reshape(-1, 4)
    for height in closed:
        ring = np.abs(points[:, 2] - height) < 1e-3
        order = np.flatnonzero(ring)[np.argsort(np.arctan2(points[ring, 1], points[ring, 0]))]
        half = len(order) // 2
        strips = [(order[k], order[k + 1], order[-k - 2], order[-k - 1]) for k in range(half - 1)]
        quads = np.concatenate([quads, np.array(strips, quads.dtype)])
    return quad_mesh("Trousers", points, quads)


class Closed(unittest.TestCase):

    def setUp(self) -> None:
        self.base = trousers()
        self.rest = np.array([(0.0, 0.0, 0.0), (0.0, 0.0, 1.8)], np.float32)  # feet and a head

    def is_one(self, **changed: object) -> bool:
        arguments = dict(base=self.base, others=self.rest, up=UP) | changed
        return is_closed_garment(**arguments)

    def test_trousers_with_closed_ends_below_a_head(self) -> None:
        self.assertTrue(self.is_one())

    def test_an_opening_makes_it_a_question_for_others(self) -> None:
        self.assertFalse(self.is_one(base=trousers(closed=())))

    def test_a_coat_is_open_at_its_collar_alone(self) -> None:
        """Sleeves end around the hands, and its hem is closed: the coats of common avatars were no cloth."""
        coat = trousers(closed=(0.1,))
        self.assertTrue(self.is_one(base=coat))
        self.assertFalse(self.is_one(base=trousers(closed=(1.1,))), "it would be held by its hem")

    def test_a_body_that_is_cut_off_at_its_neck_is_none(self) -> None:
        """It has one opening as a coat has, but the figure ends where it does."""
        head = np.array([(0.0, 0.0, 1.1), (0.0, 0.0, 1.8)], np.float32)
        self.assertFalse(self.is_one(base=trousers(closed=(0.1,)), others=head))

    def test_boots_in_the_mesh_of_a_coat_are_below_it(self) -> None:
        head = np.array([(0.0, 0.0, 1.1), (0.0, 0.0, 1.8)], np.float32)
        coat = trousers(closed=(0.1,))
        boot = np.array([(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1, 0.1, 0.0), (0.0, 0.1, 0.0)], np.float32)
        quads = np.concatenate([coat.corner_vertex.reshape(-1, 4), [len(coat.positions) + np.arange(4)]])
        both = quad_mesh("Coat", np.concatenate([coat.positions, boot]), quads)
        self.assertTrue(self.is_one(base=both, others=head))

    def test_a_whole_body_is_none(self) -> None:
        """Its hair is above it, but by less than a head."""
        self.assertFalse(self.is_one(others=np.array([(0.0, 0.0, 0.1), (0.0, 0.0, 1.15)], np.float32)))

    def test_alone_it_is_none(self) -> None:
        self.assertFalse(self.is_one(others=np.zeros((0, 3), np.float32)))

    def test_a_boot_is_none(self) -> None:
        self.assertFalse(self.is_one(base=replace(self.base, positions=np.float32(0.5) * self.base.positions)))

    def test_what_one_bone_moves_does_not_bend(self) -> None:
        upper = (self.base.positions[:, 2] > 0.6).astype(np.float32)
        weights = np.stack([upper, 1.0 - upper], axis=1)
        self.assertTrue(bends(weights))
        self.assertFalse(bends(weights[:, :1]))
        self.assertFalse(bends(weights[:, :0]))
        self.assertFalse(bends(weights * np.float32((0.0, 1.0))), "no bone moves the upper half")

    def test_a_position_that_is_not_finite(self) -> None:
        """The build reports it."""
        for wrong in (np.nan, np.inf, -np.inf):
            points = self.base.positions.copy()
            points[3] = wrong
            with np.errstate(invalid="ignore"):
                self.assertFalse(self.is_one(base=replace(self.base, positions=points)))

    def test_up_is_where_the_world_has_it(self) -> None:
        """A mesh in centimetres that lies, as in files of games."""
        turned = np.stack([self.base.positions[:, 0], self.base.positions[:, 2], self.base.positions[:, 1]], axis=1)
        lying = replace(self.base, positions=np.float32(100.0) * turned)
        others = np.float32(100.0) * self.rest[:, (0, 2, 1)]
        self.assertTrue(self.is_one(base=lying, others=others, up=np.array((0.0, 0.01, 0.0))))
        self.assertFalse(self.is_one(base=lying, others=others, up=np.array((0.0, -0.01, 0.0))))
