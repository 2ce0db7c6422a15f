# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of game characters in one mesh: garments that are closed by caps are cloth, their caps and the shoes are not."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.mesh.rigid_parts import RigidParts
from rumple.core.parts.capped_parts import winding
from rumple.core.parts.cloth_surface import without_rigid_parts
from rumple.core.settings.system_settings import MeshSettings
from support.meshes import quad_mesh, tube
from support.solved_meshes import box, distances, leant, solved, together

CLOTH = MeshSettings(density="LEVEL", level=1, layers="CLOTH", base_cloth="HANG")
RADIUS, LENGTH, AROUND, ROWS = 0.05, 0.3, 24, 28  # of the sleeve; its caps have two rows of quads each
ENDS = np.array([0.02, 0.5, 1.0])  # of the radius: the rows of a cap


def capped_sleeve(deep: float = 0.0) -> BaseMesh:
    """Closed but for an eyelet in each cap, beside its middle. deep: how far the inner row of a cap is inside of it."""
    mesh = tube(AROUND, ROWS, RADIUS, LENGTH)
    share = np.ones(ROWS + 1)
    share[:3], share[-3:] = ENDS, ENDS[::-1]
    z = np.interp(np.arange(ROWS + 1), [2, ROWS - 2], [0.0, LENGTH])
    rows = mesh.positions.reshape(ROWS + 1, AROUND, 3) * share[:, None, None]
    rows[:, :, 0] += 0.02 * (1.0 - share[:, None])
    rows[:, :, 2] = z[:, None]
    rows[:2, :, 2] += deep
    rows[-2:, :, 2] -= deep
    return quad_mesh("Sleeve", rows.reshape(-1, 3), mesh.corner_vertex.reshape(-1, 4))


def bag(radius: float, length: float, z: float, closed: bool = False) -> BaseMesh:
    """A hand, or a shoe: a tube that is drawn together into a round end at the top; closed: or a whole arm, at both."""
    mesh = tube(20, 12, radius, length)
    height = mesh.positions[:, 2] / length * 2.0 - 1.0
    height = np.abs(height) if closed else height
    share = np.sqrt(1.0 - np.clip(height, 0.0, 0.999) ** 2)
    return quad_mesh("Bag", mesh.positions * np.c_[share, share, np.ones(len(share))] + (0.0, 0.0, z),
                     mesh.corner_vertex.reshape(-1, 4))


def arm(z: float, length: float = 0.16) -> BaseMesh:
    mesh = tube(20, 12, 0.044, length)
    return quad_mesh("Arm", mesh.positions + (0.0, 0.0, z), mesh.corner_vertex.reshape(-1, 4))


SLEEVE, HAND, ELBOW = capped_sleeve(), bag(0.044, 0.2, 0.26), arm(-0.13)  # both end inside of the sleeve
OTHER_SLEEVE = quad_mesh("Other", tube(24, 8, 0.05, 0.15).positions - (0.0, 0.0, 0.25),
                         tube(24, 8, 0.05, 0.15).corner_vertex.reshape(-1, 4))
WALL = AROUND * (ROWS - 4)  # quads of the sleeve without its caps


def leg(z: float) -> BaseMesh:
    """Of leggings: as the arm, but with a third opening, so that it has not the shape of skin."""
    quads = arm(z).corner_vertex.reshape(12, 20, 4)
    return quad_mesh("Leg", arm(z).positions, np.concatenate([quads[:5].reshape(-1, 4), quads[5:7, 6:].reshape(-1, 4),
                                                             quads[7:].reshape(-1, 4)]))


def split(*meshes: BaseMesh) -> tuple[int, RigidParts | None]:
    """How many polygons of cloth they have in one mesh, and what is none."""
    cloth = without_rigid_parts(together(*meshes).healed(True), True)
    return len(cloth.polygon_start) - 1, cloth.rigid


class WhatIsCloth(unittest.TestCase):

    def test_a_sleeve_in_which_arms_end_is_cloth_without_its_caps(self) -> None:
        """It was a solid thing that stayed as animated, and the arms were cloth: it has no opening."""
        polygons, rigid = split(SLEEVE, HAND, ELBOW, OTHER_SLEEVE)
        assert rigid is not None
        self.assertEqual(polygons, WALL + len(OTHER_SLEEVE.polygon_start) - 1)
        self.assertEqual(rigid.lines(), ["Rigid parts that ride on the cloth: 2",
                                         "Parts that are skin and stay as they are animated: 2"])

    def test_a_cap_with_a_step_is_one(self) -> None:
        """Its inner panel rode on what was nearest, and came out under the hem."""
        polygons, rigid = split(capped_sleeve(0.032), HAND, arm(-0.13, 0.22), OTHER_SLEEVE)
        assert rigid is not None
        self.assertEqual(polygons, WALL + len(OTHER_SLEEVE.polygon_start) - 1)
        self.assertEqual(rigid.lines()[0], "Rigid parts that ride on the cloth: 2")

    def test_one_end_is_not_enough(self) -> None:
        """A helmet is closed and has a neck in it."""
        self.assertEqual(split(SLEEVE, HAND)[1], None)

    def test_one_of_the_ends_may_be_cloth(self) -> None:
        """A long shirt in which leggings end and the neck of a head was skin, and the leggings came through it."""
        polygons, rigid = split(SLEEVE, HAND, leg(-0.13), OTHER_SLEEVE)
        assert rigid is not None
        self.assertEqual(polygons, WALL + sum(len(of.polygon_start) - 1 for of in (leg(-0.13), OTHER_SLEEVE)))
        self.assertIn("Parts that are skin and stay as they are animated: 1", rigid.lines())

    def test_ends_of_cloth_alone_are_not_enough(self) -> None:
        """Sloppily modelled clothes dip into a body. So the closed sleeve is not cloth."""
        dressed_hand = [quad_mesh(of.name, of.positions + (0.3, 0.0, 0.0), of.corner_vertex.reshape(-1, 4))
                        for of in (tube(24, 8, 0.05, 0.3), HAND)]
        cloth = [leg(-0.13), leg(0.27), dressed_hand[0]]
        polygons, rigid = split(SLEEVE, *cloth, dressed_hand[1])
        assert rigid is not None
        self.assertEqual(polygons, sum(len(of.polygon_start) - 1 for of in cloth))

    def test_caps_are_hidden_in_a_body(self) -> None:
        """The same lids with nothing in them are cloth: a part of the garment that is seen."""
        short = arm(0.05, 0.2)  # ends inside, with both ends
        polygons, rigid = split(SLEEVE, short, HAND)
        assert rigid is not None
        self.assertEqual(polygons, WALL + 2 * AROUND)
        self.assertEqual(rigid.lines()[0], "Rigid parts that ride on the cloth: 1")

    def test_cloth_that_skin_comes_through_is_no_cap(self) -> None:
        """A sleeve of eight sides has creases between them, and the hand is outside of each in its middle."""
        sides = tube(8, 24)
        polygons, rigid = split(sides, bag(0.048, 0.2, 0.26))
        assert rigid is not None
        self.assertEqual(polygons, len(sides.polygon_start) - 1)

    def test_pleats_that_skin_comes_through_are_no_caps(self) -> None:
        """Each of their strips stands upright on the hand. They were cut out, and it took seconds."""
        sides, rows = 120, 12
        plain = tube(sides, rows)
        pleats = plain.positions.reshape(rows + 1, sides, 3) * np.ones(3, np.float32)
        pleats[:, 1::2, :2] *= 1.08
        pleated = quad_mesh("Pleats", pleats.reshape(-1, 3), plain.corner_vertex.reshape(-1, 4))
        polygons, rigid = split(pleated, bag(0.053, 0.6, -0.15, closed=True))
        assert rigid is not None
        self.assertEqual(polygons, sides * rows)

    def test_shoes_stay_and_are_not_crumpled(self) -> None:
        shoe = bag(0.055, 0.2, -0.45)  # below the other sleeve, far from skin
        flat = quad_mesh("Shoe", shoe.positions * (0.5, 1.2, 1.0), shoe.corner_vertex.reshape(-1, 4))
        _, rigid = split(SLEEVE, HAND, ELBOW, OTHER_SLEEVE, flat)
        assert rigid is not None
        self.assertIn("Solid parts that stay as they are animated: 1", rigid.lines())
        self.assertEqual(split(OTHER_SLEEVE, flat)[1], None)  # without skin it may be a bag of cloth


class Caps(unittest.TestCase):

    def test_with_faces_on_them_they_are_cloth(self) -> None:
        """Caps with two sides: the second ones lie on faces that were no longer there, and no frame was solved."""
        quads = SLEEVE.corner_vertex.reshape(-1, 4)
        of_caps = np.concatenate([quads[:2 * AROUND], quads[-2 * AROUND:]])[:, ::-1]
        doubled = quad_mesh("Doubled", SLEEVE.positions, np.concatenate([quads, of_caps]))
        base = together(doubled, HAND, ELBOW, OTHER_SLEEVE)
        mesh, result = solved(base, CLOTH, leant(base.positions))
        rigid = mesh.base.rigid
        assert rigid is not None
        self.assertEqual(rigid.lines(), ["Parts that are skin and stay as they are animated: 2"])
        self.assertTrue(np.isfinite(result.positions).all())

    def test_they_close_the_cloth_wherever_it_goes(self) -> None:
        """They were fixed to the nearest of the cloth, all of it on one side, and flew off by centimetres."""
        base = together(SLEEVE, HAND, ELBOW, OTHER_SLEEVE)
        mesh, result = solved(base, replace(CLOTH, level=3), leant(base.positions))
        rigid = mesh.base.rigid
        assert rigid is not None
        cloth, rest = len(result.positions) - len(rigid.vertex), mesh.positions_rest
        went = result.positions - leant(rest)
        for z in (0.0, LENGTH):
            end = np.flatnonzero(np.abs(rest[:cloth, 2] - z) < 1e-4)
            cap = cloth + np.flatnonzero(~rigid.stays[rigid.part] & (np.abs(rest[cloth:, 2] - z) < 1e-4))
            edge = cap[np.linalg.norm(rest[cap, :2], axis=1) > 0.99 * RADIUS]
            self.assertEqual((len(cap), len(edge)), (3 * AROUND, AROUND))
            beside = end[distances(np.concatenate([rest[edge], rest[end]]))[:AROUND, AROUND:].argmin(1)]
            self.assertLess(float(np.abs(went[edge] - went[beside]).max()), 0.0005)
            self.assertLess(float(np.abs(went[cap].mean(0) - went[end].mean(0)).max()), 0.0005)


class Winding(unittest.TestCase):

    def test_it_is_one_inside_none_outside_and_the_share_that_is_seen(self) -> None:
        cube = box((0.0, 0.0, 0.0), (2.0, 2.0, 2.0))
        corners = cube.positions[cube.triangles]
        points = np.array([[0.0, 0.0, 0.0], [0.9, -0.9, 0.9], [3.0, 0.0, 0.0]])
        np.testing.assert_allclose(winding(points, corners), [1.0, 1.0, 0.0], atol=1e-7)
        np.testing.assert_allclose(winding(points[:1], corners[2:]), [5.0 / 6.0], atol=1e-7)
        np.testing.assert_allclose(winding(points, corners[:, ::-1]), [1.0, 1.0, 0.0], atol=1e-7)


if __name__ == "__main__":
    unittest.main()
