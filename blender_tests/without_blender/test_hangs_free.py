# SPDX-License-Identifier: GPL-3.0-or-later
"""Hangs Free: the room and the folds of cloth that hangs free of the body."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.base.triangles import at_border
from rumple.core.paint import hangs_free
from rumple.core.paint.hangs_free import FREE
from rumple.core.settings.cloth_settings import ClothSettings
from rumple.core.settings.system_settings import MeshSettings
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support.frames import solve_frame
from support.meshes import compressed, tube

CHAIN = np.stack([np.arange(9), np.arange(1, 10)], 1)  # edges


class Maps(unittest.TestCase):
    def test_what_lies_on_the_body_is_worn_and_what_is_a_hand_away_hangs_free(self) -> None:
        for size in (1.0, 0.1):  # a doll's clothes are to scale
            share = hangs_free.share_of_distance(size * np.array((0.0, 0.03, 0.05, 0.09, 0.13, 0.2, np.nan)), size)
            np.testing.assert_allclose(share, (0, 0, 0, 0.5, 1, 1, np.nan), atol=1e-9)

    def test_what_is_not_known_is_taken_from_beside_it(self) -> None:
        share = np.array((0, 0, np.nan, 0, 0, 1, np.nan, 1, 1, 1.0))
        even = hangs_free.spread(share, CHAIN, np.arange(10))
        self.assertTrue((np.diff(even) >= 0.0).all())
        self.assertLess(even[2], 0.15)
        self.assertGreater(even[6], 0.6)
        np.testing.assert_array_equal(hangs_free.spread(np.full(10, np.nan), CHAIN, np.arange(10)), 0.0)
        np.testing.assert_allclose(hangs_free.spread(np.ones(11), CHAIN, np.arange(11)), 1.0)  # the last one is loose

    def test_it_is_taken_from_beyond_a_seam_that_is_cut(self) -> None:
        """As the UV seams of a game's meshes are: of a strip of which nothing was known all was held."""
        share = np.where(np.arange(10) < 5, np.nan, 1.0)
        cut = np.insert(share, 4, np.nan)
        edges = np.where(CHAIN > 4, CHAIN + 1, CHAIN)
        edges[4] = 5, 6
        place = np.insert(np.arange(10), 4, 4)
        np.testing.assert_allclose(hangs_free.spread(cut, edges, place), 1.0)

    def test_room_grows_from_that_of_worn_cloth_to_that_of_free_cloth(self) -> None:
        free = np.array((0.0, 0.5, 1.0, 2.0), np.float32)
        np.testing.assert_allclose(hangs_free.room_factor(free, ClothSettings(room=0.1, free_room=0.3)),
                                   (1.0, 2.0, 3.0, 3.0))
        for settings in (ClothSettings(room=0.3, free_room=0.1), ClothSettings(room=0.0)):
            np.testing.assert_array_equal(hangs_free.room_factor(free, settings), 1.0)

    def test_narrow_folds_fade_and_what_is_painted_counts_as_well(self) -> None:
        free, detail = np.array((0.0, 1.0), np.float32), np.array((0.5, 0.5), np.float32)
        words = ["drape", "folds", "detail"]
        paint = hangs_free.with_wide_folds({"detail": detail}, free, words)
        np.testing.assert_allclose((paint["folds"], paint["detail"]), ((1.0, 0.5), (0.5, 0.0)), rtol=1e-5)
        np.testing.assert_array_equal(paint["worn"], 1.0 - free)
        self.assertEqual(set(hangs_free.with_wide_folds({}, None, words)), set())
        # Of fewer layers the widest is left whole; of one mesh, as in the paper, nothing is changed.
        fewer = hangs_free.with_wide_folds({}, free, ["folds", "detail"])
        np.testing.assert_allclose(fewer["detail"], (1.0, 0.5))
        self.assertEqual(set(fewer), {"detail", "worn"})
        self.assertEqual(set(hangs_free.with_wide_folds({}, free, ["detail"])), {"worn"})
        self.assertEqual(set(hangs_free.with_wide_folds({}, free, [])), set())


class Borders(unittest.TestCase):
    def test_triangles_at_the_edge_of_a_hole_are_told(self) -> None:
        corner = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]  # a fan: a corner of each is on its rim
        np.testing.assert_array_equal(at_border(np.array(corner, np.int32)), True)
        closed = np.array([(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)], np.int32)
        np.testing.assert_array_equal(at_border(closed), False)
        apart = np.concatenate([closed, np.array([(4, 5, 6)], np.int32)])
        np.testing.assert_array_equal(at_border(apart), (False,) * 4 + (True,))


class Solved(unittest.TestCase):
    """A tube that is pinned at its top and hangs across: gravity pulls it out of its animated place."""

    def setUp(self) -> None:
        self.base = tube(16, 16, 0.1, 0.6)
        height = self.base.positions[:, 2]
        self.follow = (height < 0.05).astype(np.float32)
        self.lower = np.flatnonzero(height > 0.4)
        self.free = np.clip((height - 0.2) / 0.2, 0.0, 1.0).astype(np.float32)

    def dropped(self, paint: dict[str, np.ndarray], **settings: float) -> np.ndarray:
        """(n,) how far each vertex is from its animated place."""
        system = WrinkleMesh.build(self.base, MeshSettings(layers="CLOTH", wavelength=0.05))
        chosen = MeshSettings(layers="CLOTH", wavelength=0.05, base_cloth="HANG", gravity=8.0, slide_room=0.0,
                              **settings)
        across = np.array(((1, 0, 0), (0, 0, -1), (0, 1, 0)), np.float32)  # its axis lies: the loose end falls
        for frame in range(1, 4):
            solve_frame(system, float(frame), self.base.positions, chosen, {"follow": self.follow, **paint}, start=1,
                        world_from_object=across)
        moved = system.solved_over(3.0, self.base.positions) - self.base.positions
        return np.linalg.norm(moved, axis=1)

    def test_cloth_that_hangs_free_leaves_its_place_by_the_free_room(self) -> None:
        worn, free = (self.dropped(paint, room=0.01, free_room=0.08) for paint in ({}, {FREE: self.free}))
        self.assertLess(worn.max(), 0.0101)
        self.assertLess(free.max(), 0.0801)
        self.assertGreater(np.median(free[self.lower]), 2.0 * np.median(worn[self.lower]))

    def test_a_map_of_zeros_and_a_small_free_room_change_no_bit(self) -> None:
        worn = self.dropped({}, room=0.01)
        for paint, free_room in ((np.zeros_like(self.free), 0.08), (self.free, 0.01)):
            np.testing.assert_array_equal(self.dropped({FREE: paint}, room=0.01, free_room=free_room), worn)

    def test_another_free_room_is_another_frame(self) -> None:
        near, far = (self.dropped({FREE: self.free}, room=0.01, free_room=room) for room in (0.02, 0.08))
        self.assertGreater(np.median(far[self.lower]), 1.5 * np.median(near[self.lower]))

    def test_a_layer_has_fewer_narrow_folds_there_and_all_of_them_elsewhere(self) -> None:
        results, height = [], self.base.positions[:, 2]
        for paint in ({}, {FREE: (height > 0.3).astype(np.float32)}):
            chosen = MeshSettings(layers="CLOTH", wavelength=0.05, base_cloth="OFF", drape=0.0, folds=0.0)
            system = WrinkleMesh.build(self.base, chosen)
            for frame in range(1, 5):
                shown = solve_frame(system, float(frame), compressed(self.base.positions, 1.02 - 0.04 * frame), chosen,
                                    paint, start=1)
            results.append((system.shown.positions_rest[:, 2], np.sqrt((shown.offset ** 2).sum(axis=1))))
        (along, everywhere), (_, painted) = results
        free, worn = (along > 0.4) & (along < 0.55), along < 0.2
        self.assertLess(painted[free].mean(), 0.4 * everywhere[free].mean())
        self.assertGreater(painted[worn].mean(), 0.9 * everywhere[worn].mean())
