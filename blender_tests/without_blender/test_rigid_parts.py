# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of buttons and buckles: they are shown as they were modelled, ride on the cloth, and change no fold of it."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.mesh.connected import lowest_connected
from rumple.core.parts.cloth_surface import without_rigid_parts
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from rumple.native import kernels
from support.meshes import compressed, quad_mesh, rotated, tube
from support.solved_meshes import BOX, box, distances, embedded, leant, solved, together

CLOTH = MeshSettings(density="LEVEL", level=2, display_steps=1, layers="CLOTH", base_cloth="HANG")
GARMENT = tube(24, 24)


BUTTON = box((0.053, 0.0, 0.15), (0.003, 0.01, 0.01))  # in front of the tube, 1.5 mm off


class Buttons(unittest.TestCase):
    """A squeezed tube that hangs as cloth, with a button on it."""

    def setUp(self) -> None:
        self.base = together(GARMENT, BUTTON)
        self.pose = compressed(self.base.positions, 0.8)
        self.mesh, self.result = solved(self.base, CLOTH, self.pose)

    def test_they_are_shown_as_they_were_modelled(self) -> None:
        self.assertEqual(len(self.mesh.polygon_start) - 1, 64 * len(GARMENT.polygon_start[1:]) + 6)
        np.testing.assert_array_equal(self.mesh.positions_rest[-8:], BUTTON.positions)
        np.testing.assert_array_equal(self.mesh.polygon_parent[-6:], len(GARMENT.polygon_start) - 1 + np.arange(6))
        np.testing.assert_array_equal(self.mesh.corner_vertex[-24:].reshape(-1, 4), self.mesh.vertex_count - 8 + BOX)
        np.testing.assert_array_equal(self.mesh.edge_parent[-12:], len(GARMENT.positions) + np.unique(np.sort(
            np.stack([BOX, np.roll(BOX, -1, 1)], 2).reshape(-1, 2), 1), axis=0))
        corners = np.arange(len(self.base.corner_vertex), dtype=np.float32)[:, None]
        np.testing.assert_array_equal(self.mesh.carry_corners(corners)[-24:], corners[-24:])
        np.testing.assert_allclose(self.mesh.carry_points(self.base.positions)[-8:], BUTTON.positions)

    def test_their_shape_is_that_of_the_animation(self) -> None:
        np.testing.assert_allclose(distances(self.result.positions[-8:]), distances(self.pose[-8:]), atol=1e-7)

    def test_they_stay_at_the_place_of_the_cloth_where_they_were_sewn(self) -> None:
        rest = self.mesh.positions_rest[:-8]
        place = np.argsort(np.linalg.norm(rest - BUTTON.positions.mean(0), axis=1))[:12]

        def away(button: np.ndarray, cloth: np.ndarray) -> float:
            return float(np.linalg.norm(button.mean(0) - cloth[place].mean(0)))

        sewn, cloth = away(BUTTON.positions, rest), self.result.positions[:-8]
        self.assertGreater(away(self.pose[-8:], cloth), sewn + 0.005)  # the cloth has left its animation
        self.assertAlmostEqual(away(self.result.positions[-8:], cloth), sewn, delta=0.001)

    def test_no_fold_knows_of_them(self) -> None:
        _, bare = solved(GARMENT, CLOTH, self.pose[:-8])
        np.testing.assert_array_equal(self.result.positions[:-8], bare.positions)
        for name, values in bare.attributes.items():
            np.testing.assert_array_equal(self.result.attributes[name][:len(values)], values)

    def test_the_node_tree_puts_them_where_they_were_solved(self) -> None:
        found = embedded(self.mesh, self.pose, self.result.local_offset)
        np.testing.assert_allclose(found, self.result.positions, atol=2e-6)

    def test_rigid_motion_carries_them_rigidly(self) -> None:
        gravity_turned = replace(CLOTH, gravity=0.0)  # it points the same way in both poses
        _, here = solved(self.base, gravity_turned, self.pose)
        _, there = solved(self.base, gravity_turned, rotated(self.pose, 70.0))
        np.testing.assert_allclose(there.positions[-8:], rotated(here.positions[-8:], 70.0), atol=2e-5)

    def test_viewports_show_them_too(self) -> None:
        mesh, result = solved(self.base, CLOTH, self.pose, in_viewport=True, viewport_steps=0)
        self.assertIsNotNone(mesh.in_viewport)
        self.assertLess(len(result.positions), self.mesh.vertex_count)
        np.testing.assert_allclose(result.positions[-8:], self.result.positions[-8:], atol=1e-3)

    def test_over_a_dense_garment(self) -> None:
        dense = together(tube(96, 96), BUTTON)
        mesh, result = solved(dense, replace(CLOTH, density="WAVELENGTH", wavelength=0.02),
                              compressed(dense.positions, 0.8))
        self.assertIsNotNone(mesh.coarse)
        np.testing.assert_allclose(distances(result.positions[-8:]), distances(compressed(BUTTON.positions, 0.8)),
                                   atol=1e-7)

    def test_in_every_system(self) -> None:
        for system, settings in ((WrinkleField, FieldSettings(output="GEOMETRY", wavelength=0.02)),
                                 (WrinkleField, FieldSettings(output="SHADING", wavelength=0.02)),
                                 (WrinklePaths, PathsSettings(width=0.01)),
                                 (WrinkleMesh, MeshSettings(density="LEVEL", level=1))):
            with self.subTest(system=system.__name__):
                settings = replace(settings, base_cloth="HANG")
                mesh, result = solved(self.base, settings, self.pose, system)
                for attribute in mesh.ATTRIBUTES:
                    rows = len(mesh.corner_vertex) if attribute.domain == "CORNER" else mesh.vertex_count
                    self.assertEqual(len(result.attributes[attribute.name]), rows, attribute.name)
                np.testing.assert_allclose(distances(result.positions[-8:]), distances(self.pose[-8:]), atol=1e-7)
                self.assertGreater(np.linalg.norm(result.positions[-8:] - self.pose[-8:], axis=1).min(), 0.001)

    def test_without_the_setting_they_are_cloth(self) -> None:
        mesh, _ = solved(self.base, replace(CLOTH, rigid_parts=False), self.pose)
        self.assertEqual(len(mesh.polygon_start) - 1, 64 * (len(self.base.polygon_start) - 1))

    def test_what_is_far_from_the_cloth_stays_with_the_animation(self) -> None:
        far = together(GARMENT, box((0.2, 0.0, 0.15), (0.01, 0.01, 0.01)))
        pose = compressed(far.positions, 0.8)
        _, result = solved(far, CLOTH, pose)
        np.testing.assert_array_equal(result.positions[-8:], pose[-8:])

    def test_a_turned_face_of_the_garment_is_healed_beside_them(self) -> None:
        quads = self.base.corner_vertex.reshape(-1, 4).copy()
        quads[40] = quads[40][::-1]
        mesh, result = solved(quad_mesh("Turned", self.base.positions, quads), CLOTH, self.pose)
        np.testing.assert_allclose(result.positions[-8:], self.result.positions[-8:], atol=2e-3)  # other diagonals
        np.testing.assert_allclose(distances(result.positions[-8:]), distances(self.pose[-8:]), atol=1e-7)
        np.testing.assert_array_equal(mesh.polygon_parent[-6:], self.mesh.polygon_parent[-6:])


SHIRT = tube(24, 24, 0.15, 0.6)
POUCH = box((0.18, 0.0, 0.2), (0.05, 0.1, 0.1))  # on it


def helmet() -> BaseMesh:
    """Half a ball over the upper end of the shirt, open below."""
    cap = tube(24, 8, 0.12, 0.12)
    x, y, z = cap.positions.T
    share = np.sqrt(np.maximum(1.0 - (z / 0.12)**2, 1e-3))
    return quad_mesh("Helmet", np.c_[x * share, y * share, z + 0.65], cap.corner_vertex.reshape(-1, 4))


class Solids(unittest.TestCase):
    """Parts that are too large for buttons, and hold much for their surface."""

    def solid(self, *meshes: BaseMesh) -> tuple[list[bool], list[bool]]:
        """Of the rigid parts of one mesh of all: whether they stay where they are animated, and are skin."""
        rigid = without_rigid_parts(together(*meshes).healed(True), True).rigid
        return ([], []) if rigid is None else (rigid.stays.tolist(), rigid.is_skin.tolist())

    def test_a_pouch_rides_on_the_cloth_and_a_helmet_stays(self) -> None:
        """They were cloth, wrinkled and drawn in by it."""
        self.assertEqual(self.solid(SHIRT, POUCH), ([False], [False]))
        self.assertEqual(self.solid(SHIRT, helmet()), ([True], [False]))
        base = together(SHIRT, helmet(), POUCH)
        pose = leant(base.positions)
        _, result = solved(base, CLOTH, pose)
        worn, pouch = slice(-8 - len(helmet().positions), -8), slice(-8, None)
        np.testing.assert_array_equal(result.positions[worn], pose[worn])
        np.testing.assert_allclose(distances(result.positions[pouch]), distances(pose[pouch]), atol=1e-6)
        self.assertGreater(np.linalg.norm(result.positions[pouch] - pose[pouch], axis=1).min(), 1e-4)

    def test_both_are_named(self) -> None:
        rigid = without_rigid_parts(together(SHIRT, helmet(), POUCH), True).rigid
        assert rigid is not None
        self.assertEqual(rigid.lines(), ["Rigid parts that ride on the cloth: 1",
                                         "Solid parts that stay as they are animated: 1"])

    def test_a_pocket_a_cuff_and_a_doubled_sleeve_are_cloth(self) -> None:
        pocket = quad_mesh("Pocket", SHIRT.positions[:96] * (1.05, 1.05, 1.0) + (0.0, 0.0, 0.1),
                           SHIRT.corner_vertex.reshape(-1, 4)[:72 - 24])
        self.assertEqual(self.solid(SHIRT, pocket), ([], []))
        cuff = tube(24, 4, 0.055, 0.16)
        self.assertEqual(self.solid(SHIRT, cuff), ([], []))
        inside = tube(24, 4, 0.05, 0.16)
        walls = inside.corner_vertex.reshape(-1, 4)[:, ::-1] + len(cuff.positions)
        ends = [[(ring + i, ring + (i + 1) % 24, ring + (i + 1) % 24 + len(cuff.positions),
                  ring + i + len(cuff.positions))[::1 if ring else -1] for i in range(24)] for ring in (0, 96)]
        doubled = quad_mesh("Doubled", np.concatenate([cuff.positions, inside.positions]), np.concatenate(
            [cuff.corner_vertex.reshape(-1, 4), walls, *ends]))
        self.assertEqual(self.solid(SHIRT, doubled), ([], []))
        around = tube(24, 6, 0.17, 0.3)
        half = quad_mesh("Yoke", around.positions, around.corner_vertex.reshape(-1, 24, 4)[:, :12].reshape(-1, 4))
        self.assertEqual(self.solid(SHIRT, half), ([], []))  # over the shoulders, open at the front

    def test_what_is_half_as_large_as_the_mesh_is_cloth(self) -> None:
        self.assertEqual(self.solid(SHIRT, box((0.3, 0.0, 0.2), (0.2, 0.2, 0.3))), ([], []))

    def test_what_is_all_solid_has_no_cloth_to_lie_on(self) -> None:
        self.assertEqual(self.solid(POUCH, box((0.5, 0.0, 0.2), (0.05, 0.1, 0.1))), ([], []))
        rolls = [box((0.3 + 0.21 * k, 0.0, 0.1), (0.2, 0.2, 0.2)) for k in range(4)]
        self.assertEqual(self.solid(SHIRT, *rolls), ([], []))


class Flaps(unittest.TestCase):
    """Faces that stand on an edge that has two already. Healing cuts them off, and as cloth of their own they fell."""

    def test_they_stay_at_the_cloth(self) -> None:
        first = [24 * row + column for row in (6, 12, 18) for column in (2, 8, 14, 20)]
        edges = np.stack([first, np.add(first, 1)], axis=1)
        outer = GARMENT.positions[edges.ravel()] * np.array((1.04, 1.04, 1.0), np.float32)
        rows = len(GARMENT.positions) + np.arange(len(outer)).reshape(-1, 2)
        base = quad_mesh("Torn", np.concatenate([GARMENT.positions, outer]),
                         np.concatenate([GARMENT.corner_vertex.reshape(-1, 4), np.c_[edges, rows[:, ::-1]]]))
        mesh, result = solved(base, CLOTH, leant(compressed(base.positions, 0.8)))
        corners = np.repeat(mesh.polygon_parent, np.diff(mesh.polygon_start))
        whole = len(GARMENT.polygon_start) - 1
        cloth = result.positions[np.unique(mesh.corner_vertex[corners < whole])]
        for number in range(len(edges)):
            flap = result.positions[np.unique(mesh.corner_vertex[corners == whole + number])]
            self.assertLess(np.linalg.norm(flap[:, None] - cloth, axis=2).min(), 0.003, number)

    def test_a_doubled_one_takes_nothing_from_a_button(self) -> None:
        base = together(GARMENT, BUTTON, box((-0.053, 0.0, 0.15), (0.003, 0.01, 0.01)))
        faces = base.corner_vertex.reshape(-1, 4)
        doubled = quad_mesh("Worn", base.positions, np.concatenate([faces, faces[-1:]]))
        found = without_rigid_parts(doubled.healed(True), True).rigid
        assert found is not None
        self.assertEqual((found.count, len(found.vertex)), (1, 8))


class WhichAreRigid(unittest.TestCase):
    def rigid_faces(self, base: BaseMesh, weld: bool = True) -> list[int]:
        parts = without_rigid_parts(base.healed(weld), weld).rigid
        return [] if parts is None else parts.polygon.tolist()

    def test_a_garment_alone_has_none(self) -> None:
        self.assertEqual(self.rigid_faces(GARMENT), [])

    def test_small_parts_wherever_they_stand_in_the_mesh(self) -> None:
        self.assertEqual(self.rigid_faces(together(BUTTON, GARMENT, BUTTON)), [*range(6), *range(582, 588)])

    def test_a_belt_and_a_pocket_are_cloth(self) -> None:
        belt = tube(24, 2, 0.055, 0.02)
        pocket = quad_mesh("Pocket", np.array([(0.06, y, z) for y in (0.0, 0.03) for z in (0.1, 0.13)]),
                           np.array([(0, 2, 3, 1)]))
        self.assertEqual(self.rigid_faces(together(GARMENT, belt, pocket)), [])

    def test_a_badge_is_rigid_though_it_has_a_border(self) -> None:
        badge = quad_mesh("Badge", np.array([(0.06, y, z) for y in (0.0, 0.01) for z in (0.1, 0.11)]),
                          np.array([(0, 2, 3, 1)]))
        self.assertEqual(self.rigid_faces(together(GARMENT, badge)), [576])

    def test_a_mesh_whose_faces_are_loose_is_one_garment_where_seams_are_welded(self) -> None:
        worn = together(GARMENT, BUTTON)
        split = quad_mesh("Split", worn.positions[worn.corner_vertex],
                          np.arange(len(worn.corner_vertex)).reshape(-1, 4))
        self.assertEqual(self.rigid_faces(split), list(range(576, 582)))
        self.assertEqual(self.rigid_faces(split, weld=False), [])

    def test_what_a_mesh_is_made_of_is_no_part_of_it(self) -> None:
        mail = together(*(box((0.05 * np.cos(a), 0.05 * np.sin(a), z), (0.01, 0.01, 0.01))
                          for a in np.linspace(0, 6, 20) for z in np.linspace(0, 0.3, 20)))
        self.assertEqual(self.rigid_faces(mail), [])
        self.assertEqual(self.rigid_faces(together(GARMENT, mail)), [])


class Motions(unittest.TestCase):
    """kernels.rigid_motions."""

    def test_exact(self) -> None:
        points = np.random.default_rng(3).normal(size=(9, 3)).astype(np.float32)
        moved = np.concatenate([points[:5], rotated(points[5:], 40.0)])
        stays, turns = kernels.rigid_motions(np.array([0, 5, 9], np.int32), points, moved)
        np.testing.assert_array_equal(stays, np.concatenate([np.eye(3), np.zeros((1, 3))]))
        np.testing.assert_allclose(points[5:] @ turns[:3].T + turns[3], moved[5:], atol=1e-6)

    def test_what_is_left_open_is_not_turned(self) -> None:
        line = np.array([(0, 0, 0), (1, 0, 0), (0, 0, 0)], np.float32)
        motions = kernels.rigid_motions(np.array([0, 2, 3, 3], np.int32), line, line + np.float32(0.5))
        np.testing.assert_allclose(motions[:2], np.concatenate([np.eye(3), np.full((1, 3), 0.5)])[None].repeat(2, 0))
        np.testing.assert_array_equal(motions[2], np.concatenate([np.eye(3), np.zeros((1, 3))]))

    def test_bad_input_is_said(self) -> None:
        points = np.zeros((2, 3), np.float32)
        for starts, words in (([1, 2], "got 1 first"), ([0, 2, 1], "got 1 after 2"), ([0, 3], "from: expected 3")):
            with self.assertRaisesRegex(ValueError, words):
                kernels.rigid_motions(np.array(starts, np.int32), points, points)
        with self.assertRaisesRegex(ValueError, "to: "):
            kernels.rigid_motions(np.array([0, 2], np.int32), points, points[:1])
        with self.assertRaisesRegex(ValueError, "from"):
            kernels.rigid_motions(np.array([0, 2], np.int32), points + np.float32(np.nan), points)


class Connected(unittest.TestCase):
    """The lowest number of all that each is connected with, beside a walk from vertex to vertex."""

    def walked(self, count: int, pairs: np.ndarray) -> list[int]:
        label, beside = [-1] * count, [set[int]() for _ in range(count)]
        for one, other in pairs.tolist():
            beside[one].add(other)
            beside[other].add(one)
        for lowest in range(count):
            waiting = [lowest] if label[lowest] < 0 else []
            while waiting:
                vertex = waiting.pop()
                if label[vertex] < 0:
                    label[vertex] = lowest
                    waiting += beside[vertex]
        return label

    def check(self, count: int, pairs: np.ndarray) -> None:
        before = np.arange(count)
        found = lowest_connected(before, pairs[:, 0], pairs[:, 1])
        self.assertEqual(found.tolist(), self.walked(count, pairs))
        self.assertEqual(before.tolist(), list(range(count)))

    def test_of_any_graph(self) -> None:
        random = np.random.default_rng(5)
        for count, edges in ((1, 0), (40, 15), (40, 40), (400, 300), (400, 2000)):
            self.check(count, random.integers(0, count, (edges, 2)))

    def test_of_lines_in_any_order(self) -> None:
        """What a walk of neighbours takes most steps for."""
        random = np.random.default_rng(6)
        for order in (np.arange(300), np.arange(300)[::-1], random.permutation(300)):
            pairs = np.stack([order[:-1], order[1:]], 1)
            self.check(300, pairs[random.permutation(299)])
            self.check(300, np.delete(pairs, 100, axis=0)[:, ::-1])

    def test_of_stars(self) -> None:
        """The corners of one polygon: in these two orders all pairs ask for one root at once."""
        for hub in (0, 999):
            others = np.delete(np.arange(1000), hub)
            for order in (others, others[::-1]):
                self.check(1000, np.stack([np.full(999, hub), order], 1))


if __name__ == "__main__":
    unittest.main()
