# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of skin that is found by the names of materials, and of the edges of a mesh of skin and clothes."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.base_mesh import BaseMesh
from rumple.core.skin_materials import names_skin, vertices_of, welded_skin
from support.meshes import quad_mesh, sheet, tube
from support.solved_meshes import together


class Names(unittest.TestCase):
    def test_skin_hair_and_shoes(self) -> None:
        for name in ("Skin", "skin.001", "Std_Skin_Head", "N00_000_00_Body_00_SKIN (Instance)", "EyeLashes",
                     "hairBack", "Left Hand", "Fingernails", "Boots", "MI_Face_02", "肌", "顔01"):
            self.assertTrue(names_skin(name), name)

    def test_clothes(self) -> None:
        for name in ("Shirt", "N00_002_01_Tops_01_CLOTH (Instance)", "Jeans", "Body", "Arms", "Neck", "",
                     "Material.001", "surface", "Threads", "Pearls", "袖"):
            self.assertFalse(names_skin(name), name)

    def test_a_word_of_clothes_decides(self) -> None:
        for name in ("HeadScarf", "SkinSuit", "hand_knitted_sweater", "Shoe_Leather", "Hair band", "Face-Veil",
                     "靴下の服"):
            self.assertFalse(names_skin(name), name)


def rows_of(base: BaseMesh, first: int, last: int) -> np.ndarray:
    """(p,) bool: polygons of a sheet of 1-metre rows along y, from row `first` on, before row `last`."""
    y = base.positions[base.corner_vertex, 1].reshape(-1, 4).mean(axis=1)
    return (y > first) & (y < last)


class Welded(unittest.TestCase):
    def test_only_what_is_connected_to_cloth(self) -> None:
        """A loose hand is found by its shape instead, and its map would be of no use."""
        suit, hand = tube(16, 8), sheet(4, 4, 0.04)
        mesh = together(suit, hand)
        of_suit = np.arange(len(mesh.polygon_start) - 1) < len(suit.polygon_start) - 1
        skin = ~of_suit
        skin[:40] = True
        np.testing.assert_array_equal(welded_skin(mesh, skin), skin & of_suit)

    def test_vertices_that_are_split_at_a_material_are_connected(self) -> None:
        """As importers of game files leave them: each material has vertices of its own."""
        whole = sheet(4, 4, 4.0)
        corners = whole.corner_vertex.reshape(-1, 4)
        skin = rows_of(whole, 0, 2)
        apart = np.where(skin[:, None], corners, corners + len(whole.positions))
        used, corners = np.unique(apart, return_inverse=True)
        split = quad_mesh("Split", np.tile(whole.positions, (2, 1))[used], corners.reshape(-1, 4))
        self.assertGreater(len(split.positions), len(whole.positions))
        np.testing.assert_array_equal(welded_skin(split, skin), skin)
        np.testing.assert_array_equal(vertices_of(split, skin), split.positions[:, 1] <= 2.0)

    def test_a_spot_of_either_is_left_alone(self) -> None:
        mesh = sheet(10, 10, 10.0)
        for share, counts in ((1, False), (3, True), (97, True), (99, False)):
            skin = np.arange(100) < share
            self.assertEqual(welded_skin(mesh, skin).any(), counts, share)


class Edges(unittest.TestCase):
    def test_their_mean_by_area_is_that_of_the_larger_faces(self) -> None:
        """A square metre of one face beside a hundredth of it with a hundred: (1 * 1 + 0.01 * 0.01) / 1.01."""
        large, small = sheet(1, 1, 1.0), sheet(10, 10, 0.1)
        mesh = together(large, small)
        self.assertAlmostEqual(mesh.mean_edge(), (4 * 1.0 + 400 * 0.01) / 404, places=6)
        self.assertAlmostEqual(mesh.mean_edge_by_area(), (1.0 + 0.01 * 0.01) / 1.01, places=6)

    def test_of_equal_faces_both_are_the_same(self) -> None:
        mesh = sheet(7, 7, 1.0)
        self.assertAlmostEqual(mesh.mean_edge_by_area(), mesh.mean_edge(), places=6)


if __name__ == "__main__":
    unittest.main()
