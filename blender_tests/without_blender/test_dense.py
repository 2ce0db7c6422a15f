# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of garments that are modelled densely: they hang and fold as the same garment with fewer vertices does."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.mesh.body import Body
from rumple.core.settings.fabrics import FABRICS
from rumple.core.settings.system_settings import MeshSettings
from rumple.core.systems.coarse_mesh import COARSE_SPACING, SPACING_RANGE, coarse_mesh, fitting_spacing
from rumple.core.systems.wrinkle_mesh import WrinkleMesh, cloth_defaults
from rumple.native import kernels
from support.frames import solve_frame
from support.meshes import sheet, tube

# 10 cm wide and 50 cm long, as a sleeve is.
WIDTH, LENGTH = 0.2, 0.5


def sleeve(around: int, along: int) -> BaseMesh:
    base = tube(around, along)
    return replace(base, positions=np.ascontiguousarray(base.positions * sleeve_scale(base), np.float32))


def sleeve_scale(base: BaseMesh) -> np.ndarray:
    return np.array((WIDTH, WIDTH, LENGTH)) / np.ptp(base.positions, axis=0)


def cut(base: BaseMesh) -> BaseMesh:
    """Every polygon as triangles, as games and glTF files have them."""
    corners = np.ascontiguousarray(base.triangles.ravel(), np.int32)
    triangle_corner = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    starts = np.arange(0, len(corners) + 1, 3, dtype=np.int32)
    return replace(base, polygon_start=starts, corner_vertex=corners, triangle_corner=triangle_corner)


def pushed_together(base: BaseMesh, factor: float) -> np.ndarray:
    return np.ascontiguousarray(base.positions * np.array((1.0, 1.0, factor)), np.float32)


def settings_of(base: BaseMesh, **values: Any) -> MeshSettings:
    return MeshSettings(**{**cloth_defaults(base, 1.0, np.eye(3)), **values})


def height_of_folds(base: BaseMesh) -> float:
    """Metres, root of the mean of squares: of a sleeve that is pushed together by a fifth."""
    settings = settings_of(base, gravity=0.0)
    mesh = WrinkleMesh.build(base, settings)
    for frame in range(1, 6):
        pushed = pushed_together(base, 1.0 - 0.04 * frame)
        picture = solve_frame(mesh, float(frame), pushed, settings, {}, start=1)
    return float(np.sqrt((picture.offset ** 2).sum(axis=1).mean()))


class Dense(unittest.TestCase):
    def setUp(self) -> None:
        self.base = sleeve(80, 62)  # edges of 8 mm
        self.settings = settings_of(self.base)
        self.mesh = WrinkleMesh.build(self.base, self.settings)

    def solve(self, frame: int, factor: float, **values: Any) -> Any:
        positions = pushed_together(self.base, factor)
        return solve_frame(self.mesh, float(frame), positions, replace(self.settings, **values), {}, start=1)

    def test_it_is_solved_on_fewer_vertices_and_shown_on_all(self) -> None:
        self.assertIsNotNone(self.mesh.coarse)
        self.assertLess(self.mesh.coarse.surface.vertex_count, 0.15 * len(self.base.positions))
        self.assertGreaterEqual(self.mesh.vertex_count, len(self.base.positions))
        self.assertEqual(len(self.solve(1, 0.85).positions), self.mesh.vertex_count)

    def test_it_folds_as_much_as_it_does_with_fewer_vertices(self) -> None:
        """Half the edges of 42 by 34 faces are those of 21 by 17, which are solved. Those of 80 by 62 are too short, so
        triangles are made. Their slanted sides turn where cloth unfolds, and are held to their direction."""
        few, subdivided, dense = (height_of_folds(sleeve(*faces)) for faces in ((21, 17), (42, 34), (80, 62)))
        self.assertGreater(few, 0.002)
        self.assertAlmostEqual(subdivided, few, delta=0.05 * few)
        self.assertAlmostEqual(dense, few, delta=0.5 * few)

    def test_triangles_fold_as_the_quads_that_they_were(self) -> None:
        """Slanted sides turn where cloth unfolds, and are held to their direction: cut quads gave way less."""
        quads = sleeve(21, 17)
        whole = height_of_folds(quads)
        self.assertAlmostEqual(height_of_folds(cut(quads)), whole, delta=0.05 * whole)
        coarse = WrinkleMesh.build(cut(quads), settings_of(quads)).coarse
        self.assertEqual((coarse.surface.vertex_count, coarse.surface.triangle_count), (21 * 18, 2 * 21 * 17))

    def test_a_mesh_that_was_subdivided_is_solved_on_the_one_before(self) -> None:
        """... once or twice, until it is not too dense; but not on one with narrow faces."""
        for around, along, was_subdivided in ((42, 34, True), (84, 68, True), (84, 34, False), (80, 62, False)):
            base = sleeve(around, along)
            coarse = WrinkleMesh.build(base, settings_of(base)).coarse
            self.assertEqual(coarse.spacing is None, was_subdivided, (around, along))
            if was_subdivided:
                self.assertEqual(coarse.surface.vertex_count, 21 * 18)
                self.assertEqual(coarse.surface.triangle_count, 2 * 21 * 17)

    def test_a_mesh_with_narrow_faces_is_solved_on_even_ones(self) -> None:
        """Sleeves are modelled with faces of 8 by 50 mm. On these, folds along the sleeve would be 8 mm wide, and there
        would be none across it."""
        even, narrow = sleeve(21, 17), sleeve(80, 10)
        self.assertGreater(narrow.mean_edge(), 0.02)  # not dense in the mean
        for base, is_uneven in ((even, False), (narrow, True)):
            mesh = WrinkleMesh.build(base, settings_of(base))
            self.assertEqual(kernels.is_uneven(mesh.surface, 0.02), is_uneven)
            self.assertEqual(mesh.coarse is not None, is_uneven)

    def test_the_width_of_a_triangle_is_its_height(self) -> None:
        """As that of a quad, it is the distance of sides that face each other: of one side from the opposite corner."""
        corner = np.array(((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (1.0, 0.5, 0.0)), np.float32)
        base = BaseMesh("one", corner, np.array((0, 3), np.int32), np.arange(3, dtype=np.int32),
                        np.array(((0, 1, 2),), np.int32))
        self.assertEqual([kernels.is_uneven(base.surface(True), width) for width in (0.499, 0.501)], [False, True])

    def test_a_part_that_is_denser_leaves_the_rest_no_coarser(self) -> None:
        """A face in the mesh of its clothes has most of the edges: the clothes were shown as they were modelled. Here a
        sleeve with edges of 15 mm ends in a cuff whose 40 rings lie 0.25 mm apart."""
        sleeve_rows, cuff_rows = 32, 40
        base = sleeve(42, sleeve_rows + cuff_rows)
        height = np.r_[np.linspace(0.0, 0.98, sleeve_rows, endpoint=False), np.linspace(0.98, 1.0, cuff_rows + 1)]
        base.positions[:, 2] = LENGTH * np.repeat(height, 42)
        mesh = WrinkleMesh.build(base, settings_of(base))
        self.assertIsNotNone(mesh.coarse)
        self.assertGreater(mesh.vertex_count, 10 * len(base.positions))  # subdivided twice, not once

    def test_rest_without_gravity_stays_where_it_was_modelled(self) -> None:
        picture = self.solve(1, 1.0, gravity=0.0, slack=1.0)
        shown = picture.positions - self.mesh.positions_rest
        self.assertLess(float(np.linalg.norm(shown, axis=1).max()), 0.002)
        still = self.solve(1, 1.0, gravity=0.0, slack=1.0, radius=0.0, room=0.0)
        np.testing.assert_allclose(still.positions, self.mesh.positions_rest, atol=1e-6)

    def test_played_frames_replay_to_the_bit_in_any_order(self) -> None:
        factors = {frame: 1.0 - 0.03 * frame for frame in range(1, 6)}
        played = {frame: self.solve(frame, factor).positions for frame, factor in factors.items()}
        for frame in (4, 1, 5, 2, 3):
            picture = self.solve(frame, factors[frame])
            self.assertTrue(picture.replayed)
            np.testing.assert_array_equal(picture.positions, played[frame])

    def test_paint_counts_where_it_is_painted(self) -> None:
        half = self.base.positions[:, 2] < np.median(self.base.positions[:, 2])
        paint = {"radius": np.where(half, 0.0, 1.0).astype(np.float32), "follow": np.ones(len(half), np.float32)}
        picture = solve_frame(self.mesh, 1.0, pushed_together(self.base, 0.8), self.settings, paint, start=1)
        height = np.linalg.norm(picture.offset, axis=1)
        low = self.mesh.positions_rest[:, 2] < np.quantile(self.base.positions[:, 2], 0.35)
        high = self.mesh.positions_rest[:, 2] > np.quantile(self.base.positions[:, 2], 0.65)
        self.assertGreater(np.median(height[high]), 10.0 * np.median(height[low]))

    def test_what_paint_starts_from_has_a_value_for_every_vertex(self) -> None:
        follow = self.mesh.suggested_follow(self.settings)
        self.assertEqual(len(follow), len(self.base.positions))
        self.assertGreater(follow.max(), 0.0)

    def test_painting_what_is_suggested_changes_nothing(self) -> None:
        pushed = pushed_together(self.base, 0.9)
        solve = lambda paint: solve_frame(self.mesh, 1.0, pushed, self.settings, paint, start=1).positions
        np.testing.assert_array_equal(solve({}), solve({"follow": self.mesh.suggested_follow(self.settings)}))

    def test_a_loose_vertex_does_no_harm(self) -> None:
        finer = sleeve(160, 124)  # so dense that it is shown as it is
        base = replace(finer, positions=np.ascontiguousarray(np.r_[finer.positions, [[0.0, 0.0, 0.0]]], np.float32))
        mesh = WrinkleMesh.build(base, settings_of(base))
        self.assertIsNotNone(mesh.coarse)
        self.assertGreaterEqual(mesh.vertex_count, len(base.positions))

    def test_folds_become_no_finer_than_the_most_vertices_allow(self) -> None:
        """A coarse mesh has triangles: of as many vertices half as many more come. The build was refused."""
        for most in (9_000, 12_000, 15_000, 20_000, 30_000, 50_000):
            mesh = WrinkleMesh.build(self.base, replace(self.settings, wavelength=0.01), most_vertices=most)
            self.assertIsNotNone(mesh.coarse)
            self.assertLessEqual(max(mesh.solve_vertex_count, mesh.vertex_count), most)
            self.assertEqual(len([note for note in mesh.warnings if "raise Most Vertices" in note]), 1, most)

    def test_it_stays_out_of_a_body(self) -> None:
        inner = sleeve(40, 31)
        inner.positions[:, :2] *= 0.95
        body = Body(inner.positions, np.ascontiguousarray(inner.corner_vertex[inner.triangle_corner]))
        picture = None
        for frame in range(1, 6):
            picture = solve_frame(self.mesh, float(frame), pushed_together(self.base, 1.0 - 0.03 * frame),
                                  self.settings, {}, start=1, body=body)
        middle = np.abs(picture.positions[:, 2] - picture.positions[:, 2].mean()) < 0.3 * LENGTH
        radius = np.linalg.norm(picture.positions[middle, :2], axis=1)
        self.assertGreater(radius.min(), 0.95 * WIDTH / 2.0 * np.cos(np.pi / 40.0) - 1e-4)

    def test_another_garment_can_lie_on_it(self) -> None:
        self.solve(1, 0.9)
        worn = self.mesh.worn_surface(1.0, pushed_together(self.base, 0.9), self.settings)
        self.assertLess(worn.triangles.max(), len(worn.positions))
        self.assertLess(abs(np.ptp(worn.positions[:, 2]) - 0.9 * LENGTH), settings_of(self.base).slide_room)


class LongEdges(unittest.TestCase):
    """Garments of game characters have faces as wide as an arm. Cloth cannot hang in folds on them, and only their
    vertices kept off bodies: an arm came through a cape between two of them."""

    def test_they_are_halved_until_they_are_short_enough(self) -> None:
        for faces, vertices in (((10, 8), None), ((7, 6), 14 * 13), ((4, 3), 16 * 13)):
            base = sleeve(*faces)  # edges of 63, 87 and 154 mm
            mesh = WrinkleMesh.build(base, settings_of(base))
            self.assertEqual(None if mesh.coarse is None else mesh.coarse.surface.vertex_count, vertices)
            self.assertGreaterEqual(mesh.vertex_count, len(base.positions))

    def test_they_fold_as_much_as_the_same_garment_with_more_vertices(self) -> None:
        more = height_of_folds(sleeve(21, 17))
        for faces in ((7, 6), (4, 3)):  # before, 1.33 and 1.91 of it
            self.assertAlmostEqual(height_of_folds(sleeve(*faces)), more, delta=0.15 * more)

    def test_at_rest_without_gravity_they_stay_as_modelled(self) -> None:
        base = sleeve(7, 6)
        settings = settings_of(base, gravity=0.0, slack=1.0, radius=0.0)
        mesh = WrinkleMesh.build(base, settings)
        still = solve_frame(mesh, 1.0, base.positions, settings, {}, start=1)
        np.testing.assert_allclose(still.positions, mesh.positions_rest, atol=1e-6)

    def test_what_is_pinned_halfway_is_so_between_the_vertices_too(self) -> None:
        base = sleeve(7, 6)
        mesh = WrinkleMesh.build(base, settings_of(base))
        height = base.positions[:, 2] / LENGTH
        carried = mesh._where_solved(height)
        np.testing.assert_allclose(np.unique(carried.round(5)), np.linspace(0.0, 1.0, 13), atol=1e-5)

    def test_directions_are_those_of_the_nearest_vertex(self) -> None:
        """v and -v are the same direction: their mean is none."""
        base = sleeve(7, 6)
        mesh = WrinkleMesh.build(base, settings_of(base))
        turned = np.zeros((len(base.positions), 3), np.float32)
        turned[:, 0] = np.resize((1.0, -1.0), len(turned))
        np.testing.assert_array_equal(np.abs(mesh._where_solved(turned)[:, 0]), 1.0)


class SewnOn(unittest.TestCase):
    """A pocket has no border that holds it: as a garment of its own it fell off, and the shirt front of a jacket came
    through the jacket. It is not solved, and moves with the cloth under it."""

    def test_a_pocket_moves_with_the_cloth_under_it(self) -> None:
        for faces in ((21, 17), (80, 62)):  # solved itself, and on an even mesh
            garment = sleeve(*faces)
            pocket = patch_on(garment)
            count = len(garment.positions)
            base = joined(garment, pocket)
            settings = settings_of(base)
            mesh = WrinkleMesh.build(base, settings)
            self.assertLess(mesh.coarse.base_vertex.max(), count)
            for frame in range(1, 6):
                pushed = pushed_together(base, 1.0 - 0.04 * frame)
                picture = solve_frame(mesh, float(frame), pushed, settings, {}, start=1)
            shown = picture.positions[:len(base.positions)]  # the vertices of the base come first
            moved = np.linalg.norm(shown - mesh.positions_rest[:len(shown)], axis=1)
            self.assertGreater(moved[:count].max(), 0.01)
            for vertex in range(count, len(base.positions)):
                near = np.argmin(np.linalg.norm(garment.positions - base.positions[vertex], axis=1))
                apart = np.linalg.norm(shown[vertex] - shown[near])
                self.assertLess(apart, 0.03, (faces, vertex))


def patch_on(garment: BaseMesh) -> BaseMesh:
    """A pocket of 4 x 4 faces, 6 cm wide, 4 mm off the middle of a sleeve."""
    flat = sheet(4, 4, 0.06)
    across, along = flat.positions[:, 0] - 0.03, flat.positions[:, 1] - 0.03
    radius = np.hypot(*garment.positions[:, :2].T).max() + 0.004
    angle = across / radius
    at = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.5 * LENGTH + along], axis=1)
    return replace(flat, positions=np.ascontiguousarray(at, np.float32))


def joined(first: BaseMesh, other: BaseMesh) -> BaseMesh:
    """Both in one mesh."""
    vertices, corners = len(first.positions), len(first.corner_vertex)
    return BaseMesh(first.name, np.r_[first.positions, other.positions],
                    np.r_[first.polygon_start, other.polygon_start[1:] + np.int32(corners)],
                    np.r_[first.corner_vertex, other.corner_vertex + np.int32(vertices)],
                    np.r_[first.triangle_corner, other.triangle_corner + np.int32(corners)])


class FoldWidths(unittest.TestCase):
    """Layers are halved from one to the next, but the edges of a coarse mesh can have any length. So each fabric has
    folds of just its width; with the same edges for all, wool and denim had those of cotton."""

    def setUp(self) -> None:
        self.base = sleeve(80, 62)

    def build(self, wavelength: float) -> tuple[MeshSettings, WrinkleMesh]:
        settings = settings_of(self.base, gravity=0.0, wavelength=wavelength)
        return settings, WrinkleMesh.build(self.base, settings)

    def test_the_finest_layer_is_whole_at_any_wavelength(self) -> None:
        for wavelength in np.geomspace(0.02, 0.09, 9):
            _, mesh = self.build(float(wavelength))
            self.assertIsNotNone(mesh.coarse)
            self.assertEqual(mesh.finest_share, 1.0)
            self.assertLess(abs(5.0 * mesh.edge_mean / wavelength - 1.0), 0.08, wavelength)

    def test_folds_are_as_much_wider_as_the_fabric_s_are(self) -> None:
        ratios = []
        for fabric in ("SILK", "COTTON", "WOOL", "DENIM", "LEATHER"):
            settings, mesh = self.build(0.04 * FABRICS[fabric].fold_width)
            detail = replace(settings, drape=0.0, folds=0.0)
            shown = solve_frame(mesh, 1.0, pushed_together(self.base, 0.85), detail, {}, start=1)
            ratios.append(fold_distance(shown.positions) / settings.wavelength)
        self.assertLess(max(ratios) / min(ratios), 1.2, ratios)

    def test_the_spacing_stays_near_the_usual_one(self) -> None:
        for wavelength in np.geomspace(0.001, 10.0, 200):
            spacing = fitting_spacing(COARSE_SPACING, float(wavelength))
            self.assertTrue(0.999 / SPACING_RANGE < spacing / COARSE_SPACING < 1.001 * SPACING_RANGE, wavelength)
        self.assertEqual(fitting_spacing(COARSE_SPACING, np.float32(0.04).item()), COARSE_SPACING)
        self.assertEqual(fitting_spacing(COARSE_SPACING, 1.0), SPACING_RANGE * COARSE_SPACING)  # no layer is as wide


def fold_distance(positions: np.ndarray) -> float:
    """Along a sleeve, mean over lines around it, weighted by power."""
    radius, around = np.hypot(positions[:, 0], positions[:, 1]), np.arctan2(positions[:, 1], positions[:, 0])
    along = np.linspace(positions[:, 2].min() + 0.05, positions[:, 2].max() - 0.05, 256)
    power = np.zeros(129)
    for angle in np.linspace(-np.pi, np.pi, 24, endpoint=False):
        line = np.abs((around - angle + np.pi) % (2.0 * np.pi) - np.pi) < 0.05
        order = np.argsort(positions[line, 2])
        heights = np.interp(along, positions[line, 2][order], radius[line][order])
        power += np.abs(np.fft.rfft((heights - heights.mean()) * np.hanning(256))) ** 2
    frequency = np.fft.rfftfreq(256, along[1] - along[0])
    return float(power[2:].sum() / (power[2:] * frequency[2:]).sum())


class Kept(unittest.TestCase):
    """Where no coarse mesh stands for a base."""

    def test_a_base_that_is_coarse_a_level_by_hand_and_no_base_cloth(self) -> None:
        dense, coarse = sleeve(80, 62), sleeve(21, 17)
        for base, values in ((coarse, {}), (dense, dict(density="LEVEL")), (dense, dict(base_cloth="OFF"))):
            self.assertIsNone(coarse_mesh(base, settings_of(base, **values), base.surface(True), 1.0), values)

    def test_wide_folds_lie_on_wider_ones(self) -> None:
        """The finest folds of a skirt were the widest that its mesh could have: bumps, and no flutes."""
        base = sleeve(21, 17)  # edges of 30 mm
        spacing = []
        for wavelength in (0.09, 0.14):
            settings = settings_of(base, wavelength=wavelength)
            coarse = coarse_mesh(base, settings, base.surface(True), 1.0)
            spacing.append(base.mean_edge() if coarse is None else coarse.mean_edge)
            self.assertEqual(coarse is None, wavelength == 0.09)
        self.assertGreater(spacing[1], 1.6 * spacing[0])

    def test_a_skirt_lies_on_wide_folds_whatever_its_finest_are(self) -> None:
        base = sleeve(21, 17)
        below = 1.0 - base.positions[:, 2:] / base.positions[:, 2].max()
        flared = replace(base, positions=base.positions * np.c_[np.tile(1.0 + below, 2), np.ones(len(below))].astype(
            np.float32))
        for mesh, up, is_coarse in ((base, "Z", False), (flared, "Z", True), (flared, "-Z", False)):
            settings = settings_of(mesh, wavelength=0.04, up=up)
            self.assertEqual(coarse_mesh(mesh, settings, mesh.surface(True), 1.0) is not None, is_coarse, up)

    def test_a_thing_that_is_too_small(self) -> None:
        base = tube(80, 62)
        small = replace(base, positions=np.ascontiguousarray(0.001 * base.positions, np.float32))
        far = small.positions.copy()
        far[0] = (100.0, 0.0, 0.0)  # so large a bounding box that nothing on it is dense
        mesh = WrinkleMesh.build(replace(small, positions=far), settings_of(base))
        self.assertIsNone(mesh.coarse)


if __name__ == "__main__":
    unittest.main()
