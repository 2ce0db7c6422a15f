# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of skin in the mesh of its clothes: it stays where it is animated, and cloth stays outside of it."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.cloth.on_cloth import LEAST_UNDER
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.parts.cloth_surface import without_rigid_parts
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import quad_mesh, sheet, tube
from support.solved_meshes import box, leant, solved, together

CLOTH = MeshSettings(density="LEVEL", level=1, layers="CLOTH", base_cloth="HANG")
SLEEVE = tube(24, 24)  # radius 0.05, from 0 to 0.3


def shifted(mesh: BaseMesh, z: float) -> BaseMesh:
    return quad_mesh(mesh.name, mesh.positions + (0.0, 0.0, z), mesh.corner_vertex.reshape(-1, 4))


def rounded(mesh: BaseMesh, both_ends: bool = False) -> BaseMesh:
    """A tube whose upper half is drawn together into a round end; or the lower one as well."""
    z = mesh.positions[:, 2]
    share = (z - z.min()) / np.ptp(z) * 2.0 - 1.0
    share = np.clip(np.abs(share) if both_ends else share, 0.0, 0.999)
    positions = mesh.positions * np.c_[np.sqrt(1.0 - share**2), np.sqrt(1.0 - share**2), np.ones(len(z))]
    return quad_mesh("Hand", positions, mesh.corner_vertex.reshape(-1, 4))


HAND = shifted(rounded(tube(20, 12, 0.044, 0.2)), 0.26)  # it begins in the sleeve
ELBOW = shifted(tube(20, 12, 0.044, 0.16), -0.13)  # between two sleeves
OTHER_SLEEVE = shifted(tube(24, 8, 0.05, 0.15), -0.25)


def head() -> BaseMesh:
    """A ball on a neck that begins in the sleeve."""
    mesh = tube(20, 30, 1.0, 0.27)
    z = mesh.positions[:, 2] - mesh.positions[:, 2].min()
    ball = np.sqrt(np.clip(0.12**2 - (z - 0.15) ** 2, 1e-6, None))
    width = np.where(z < 0.15, np.maximum(ball, 0.04), ball)
    return shifted(quad_mesh("Head", mesh.positions * np.c_[width, width, np.ones(len(z))],
                             mesh.corner_vertex.reshape(-1, 4)), 0.27)


def patch(x: float, z: float) -> BaseMesh:
    """A sheet of four centimetres that looks along x."""
    flat = sheet(4, 4, 0.04)
    return quad_mesh("Patch", flat.positions[:, [2, 0, 1]] + (x, -0.02, z), flat.corner_vertex.reshape(-1, 4))


def skin_faces(*meshes: BaseMesh) -> set[int]:
    """Numbers of the meshes whose faces are skin when they are one mesh."""
    rigid = without_rigid_parts(together(*meshes).healed(True), True).rigid
    if rigid is None:
        return set()
    ends = np.cumsum([len(mesh.polygon_start) - 1 for mesh in meshes])
    of_polygon = rigid.is_skin[rigid.part[rigid.corner_vertex[np.cumsum(rigid.polygon_size) - 1]]]
    return set(np.searchsorted(ends, rigid.polygon[of_polygon], side="right").tolist())


class WhatIsSkin(unittest.TestCase):

    def test_a_hand_and_an_elbow_between_sleeves(self) -> None:
        self.assertEqual(skin_faces(SLEEVE, HAND, ELBOW, OTHER_SLEEVE), {1, 2})

    def test_a_whole_arm_in_a_sleeve(self) -> None:
        self.assertEqual(skin_faces(SLEEVE, shifted(rounded(tube(20, 40, 0.044, 0.6), both_ends=True), -0.15)), {1})

    def test_a_sleeve_alone_and_two_of_them_are_cloth(self) -> None:
        self.assertEqual(skin_faces(SLEEVE), set())
        self.assertEqual(skin_faces(SLEEVE, OTHER_SLEEVE), set())

    def test_a_sleeve_over_the_end_of_another_and_a_pocket_are_cloth(self) -> None:
        over = shifted(tube(24, 12, 0.055, 0.15), -0.13)
        self.assertEqual(skin_faces(SLEEVE, over, HAND, patch(0.0515, 0.1)), {2})

    def test_a_head_is_no_garment_that_hair_grows_out_of(self) -> None:
        """Two locks ended in it as limbs end in a garment with closed ends: it was cloth, and its chin came through its
        mouth. No garment is as round as a head."""
        locks = [shifted(rounded(tube(20, 12, 0.03, 0.2)), 0.45) for _ in range(2)]
        for lock, x in zip(locks, (-0.05, 0.05)):
            lock.positions[:, 0] += np.float32(x)
        self.assertEqual(skin_faces(SLEEVE, head(), *locks), {1, 2, 3})

    def test_what_lies_on_skin_is_left_with_it(self) -> None:
        self.assertEqual(skin_faces(SLEEVE, HAND, patch(0.042, 0.3)), {1, 2})
        self.assertEqual(skin_faces(SLEEVE, HAND, patch(0.0515, 0.1)), {1})

    def test_a_strip_half_on_skin_is_the_same_in_any_order(self) -> None:
        strip = tube(12, 60, 0.004, 0.14)
        found = set()
        for seed in range(4):
            order = np.random.default_rng(seed).permutation(len(strip.positions))
            where = np.argsort(order).astype(np.int32)
            shuffled = quad_mesh("Strip", strip.positions[order] + (0.056, 0.0, 0.22),
                                 where[strip.corner_vertex].reshape(-1, 4))
            found.add(2 in skin_faces(SLEEVE, HAND, shuffled))
        self.assertEqual(len(found), 1)

    def test_a_bag_is_cloth_and_what_is_painted_rigid_rides(self) -> None:
        bag = box((0.12, 0.0, 0.15), (0.1, 0.16, 0.16))
        self.assertEqual(skin_faces(SLEEVE, bag), set())
        base = together(SLEEVE, HAND)
        base.painted_rigid = np.arange(len(base.positions)) >= len(SLEEVE.positions)
        rigid = without_rigid_parts(base, True).rigid
        assert rigid is not None
        self.assertEqual(rigid.is_skin.tolist(), [False])

    def test_a_button_rides_on_the_cloth(self) -> None:
        button = box((0.053, 0.0, 0.15), (0.003, 0.01, 0.01))
        rigid = without_rigid_parts(together(SLEEVE, HAND, button), True).rigid
        assert rigid is not None
        self.assertEqual(sorted(rigid.is_skin.tolist()), [False, True])
        self.assertEqual(rigid.lines(), ["Rigid parts that ride on the cloth: 1",
                                         "Parts that are skin and stay as they are animated: 1"])

    def test_without_the_setting_all_is_cloth(self) -> None:
        self.assertIsNone(without_rigid_parts(together(SLEEVE, HAND), True, small=False).rigid)


class Skin(unittest.TestCase):
    """A sleeve that lies on its side over a hand."""

    def setUp(self) -> None:
        self.base = together(SLEEVE, HAND)
        self.pose = leant(self.base.positions)
        self.own = len(HAND.positions)

    def test_it_stays_where_it_is_animated_to_the_bit(self) -> None:
        for system, settings in ((WrinkleMesh, CLOTH), (WrinklePaths, PathsSettings(width=0.01)),
                                 (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=0.02))):
            with self.subTest(system=system.__name__):
                mesh, result = solved(self.base, replace(settings, base_cloth="HANG"), self.pose, system)
                np.testing.assert_array_equal(result.positions[-self.own:], self.pose[-self.own:])
                np.testing.assert_array_equal(mesh.positions_rest[-self.own:], HAND.positions)

    def test_cloth_stays_outside_of_it(self) -> None:
        sunk = self.pose.copy()
        sunk[:len(SLEEVE.positions)] -= (0.0, 0.0, 0.02)  # the animation has the hand come through above
        _, result = solved(self.base, CLOTH, sunk)
        _, alone = solved(SLEEVE, CLOTH, sunk[:len(SLEEVE.positions)])
        off = [self.off_axis(positions) for positions in (result.positions[:-self.own], alone.positions)]
        self.assertGreater(off[0], 0.044)
        self.assertLess(off[1], 0.04)

    def off_axis(self, cloth: np.ndarray) -> float:
        """The least distance from the axis of the hand, above it, where both are."""
        x, y, z = cloth.T
        inside = (y < -0.27) & (y > -0.29) & (z > 0.0)
        return float(np.sqrt(x[inside]**2 + z[inside]**2).min())

    def test_another_garment_lies_on_cloth_and_skin(self) -> None:
        dense = together(HAND, tube(120, 120))
        for name, base, settings in (
                ("hangs", self.base, CLOTH), ("swings", self.base, replace(CLOTH, base_cloth="SWING")),
                ("on the animation", self.base, replace(CLOTH, base_cloth="OFF")),
                ("on a coarse mesh", dense, replace(CLOTH, density="WAVELENGTH", wavelength=0.02))):
            with self.subTest(name):
                mesh = WrinkleMesh.build(base, settings)
                for frame in (1.0, 2.0, 3.0):
                    pose = leant(base.positions) + np.float32(0.03 * frame)
                    solve_frame(mesh, frame, pose, settings, {}, start=1, world_from_object=np.eye(3))
                worn = mesh.worn_surface(3.0, pose, settings)
                assert worn is not None
                hand = pose[:self.own] if base is dense else pose[-self.own:]
                np.testing.assert_array_equal(worn.positions[:self.own], hand)
                self.assertEqual(int(worn.triangles.max()), len(worn.positions) - 1)
                self.assertGreater(len(worn.triangles), len(HAND.triangles) + len(SLEEVE.triangles) // 2)
                again = mesh.worn_surface(3.0, pose, settings)
                assert again is not None
                self.assertIs(again.triangles, worn.triangles)

    def lines(self, *meshes: BaseMesh) -> tuple[list[str], float]:
        """Of the status; and how much of the cloth has the body under it, in hundredths."""
        base = together(*meshes)
        mesh, result = solved(base, CLOTH, leant(base.positions))
        lines = mesh.status(result)
        known = next(line for line in lines if line.startswith("Base cloth"))
        return lines, float(known.split("average, ")[1].split(" %")[0])

    def test_no_other_body_is_asked_for(self) -> None:
        lines, known = self.lines(SLEEVE, HAND, shifted(tube(60, 120, 0.05, 0.5), -1.0))
        self.assertIn("Parts that are skin and stay as they are animated: 1", lines)
        self.assertLess(known, 100.0 * LEAST_UNDER)
        self.assertFalse([line for line in lines if "choose another body" in line], lines)

    def test_what_is_under_cloth_is_a_share_of_the_cloth(self) -> None:
        fine_hand = shifted(rounded(tube(160, 160, 0.044, 0.2)), 0.26)
        self.assertAlmostEqual(self.lines(SLEEVE, HAND)[1], self.lines(SLEEVE, fine_hand)[1], delta=2.0)

    def test_it_is_a_body_beside_others(self) -> None:
        rigid = without_rigid_parts(self.base, True).rigid
        assert rigid is not None
        own = rigid.skin.joined(self.pose, None)
        assert own is not None
        self.assertEqual((len(own.positions), own.triangles.max()), (self.own, self.own - 1))
        both = rigid.skin.joined(self.pose, own)
        assert both is not None
        np.testing.assert_array_equal(both.positions, np.tile(own.positions, (2, 1)))
        np.testing.assert_array_equal(both.triangles, np.concatenate([own.triangles, own.triangles + self.own]))
        again = rigid.skin.joined(self.pose + 1.0, own)
        assert again is not None
        self.assertIs(again.triangles, both.triangles)


if __name__ == "__main__":
    unittest.main()
