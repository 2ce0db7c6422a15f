# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of skin that is found by the names of materials, and of the edges of a mesh of skin and clothes."""
from __future__ import annotations

import unittest

import numpy as np
from rumple.core.parts.skin_materials import is_beside_cloth, names_skin, vertices_of
from support.meshes import quad_mesh, sheet
from support.solved_meshes import together


class Names(unittest.TestCase):
    def test_skin_hair_and_shoes(self) -> None:
        for name in ("Skin", "skin.001", "Std_Skin_Head", "N00_000_00_Body_00_SKIN (Instance)", "EyeLashes",
                     "hairBack", "Left Hand", "Fingernails", "Boots", "MI_Face_02", "肌", "顔01"):
            self.assertTrue(names_skin(name), name)

    def test_shoes_whatever_they_are_made_of(self) -> None:
        for name in ("Leather_Boots", "Shoe_Leather", "DenimSneakers", "Boot_Bottom", "Shoes_Top"):
            self.assertTrue(names_skin(name), name)

    def test_short_hair_and_the_hair_on_top_of_a_head(self) -> None:
        for name in ("Hair_Short", "ShortHair", "Hair_Top", "HairCap", "Scalp cap"):
            self.assertTrue(names_skin(name), name)

    def test_clothes(self) -> None:
        for name in ("Shirt", "N00_002_01_Tops_01_CLOTH (Instance)", "Jeans", "Body", "Arms", "Neck", "",
                     "Material.001", "surface", "Threads", "Pearls", "袖"):
            self.assertFalse(names_skin(name), name)

    def test_a_word_of_clothes_or_of_fabrics_decides(self) -> None:
        for name in ("HeadScarf", "SkinSuit", "hand_knitted_sweater", "Face_Cloth", "Hair band", "Face-Veil",
                     "HeadCap", "Hand_Shorts", "SkinTights", "Leather_Skin", "Boot_Cuff", "靴下の服", "靴下"):
            self.assertFalse(names_skin(name), name)


class BesideCloth(unittest.TestCase):
    def test_a_spot_of_either_is_left_alone(self) -> None:
        mesh = sheet(10, 10, 10.0)
        for share, counts in ((0, False), (1, False), (3, True), (97, True), (99, False), (100, False)):
            self.assertEqual(is_beside_cloth(mesh, np.arange(100) < share), counts, share)

    def test_area_counts_not_the_number_of_faces(self) -> None:
        """A face is modelled more densely than clothes."""
        mesh = together(sheet(1, 1, 1.0), sheet(10, 10, 0.1))
        self.assertFalse(is_beside_cloth(mesh, np.arange(101) > 0))

    def test_its_border_is_skin_where_vertices_are_split_there_too(self) -> None:
        """As importers of game files leave them: each material has vertices of its own."""
        left = sheet(1, 1, 1.0)
        right = quad_mesh("Right", left.positions + (1.0, 0.0, 0.0), left.corner_vertex.reshape(-1, 4))
        split = together(left, right)
        np.testing.assert_array_equal(vertices_of(split, np.array((True, False))), split.positions[:, 0] <= 1.0)


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
