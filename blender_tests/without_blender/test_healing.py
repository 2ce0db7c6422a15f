# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of meshes that are no oriented manifold: solved on a healed copy, shown as they are, nothing refused."""
from __future__ import annotations

import unittest
from dataclasses import replace

import numpy as np
from rumple.core.frame.engine import Wrinkles
from rumple.core.mesh.base_mesh import BaseMesh, built_once
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.brush import Easel
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh, cloth_defaults
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import compressed, quad_mesh, tube

SETTINGS = MeshSettings(density="LEVEL", level=1, display_steps=0)


def quads_of(base: BaseMesh) -> np.ndarray:
    return base.corner_vertex.reshape(-1, 4)


def turned(base: BaseMesh, faces: list[int]) -> BaseMesh:
    quads = quads_of(base).copy()
    quads[faces] = quads[faces][:, ::-1]
    return quad_mesh("Turned", base.positions, quads)


def doubled(base: BaseMesh, faces: np.ndarray, inside_out: bool) -> BaseMesh:
    """The faces once more, each beginning with its second corner."""
    more = np.roll(quads_of(base)[faces], 1, axis=1)
    return quad_mesh("Doubled", base.positions, np.concatenate([quads_of(base), more[:, ::-1] if inside_out else more]))


def with_fin(base: BaseMesh) -> BaseMesh:
    """A flap that is sewn on along a ring of edges."""
    ring = quads_of(base)[12 * 4:12 * 5, :2]
    first = len(base.positions)
    outer = base.positions[ring[:, 0]] * np.array((1.5, 1.5, 1.0))
    own = np.arange(first, first + 12)
    fin = np.stack([ring[:, 0], ring[:, 1], np.roll(own, -1), own], 1)
    return quad_mesh("Fin", np.concatenate([base.positions, outer]), np.concatenate([quads_of(base), fin]))


def moebius() -> BaseMesh:
    count = 24
    angle = 2 * np.pi * np.arange(count) / count
    across = np.linspace(-0.05, 0.05, 5)
    radius = 0.2 + across * np.cos(angle / 2)[:, None]
    positions = np.stack([radius * np.cos(angle)[:, None], radius * np.sin(angle)[:, None],
                          across * np.sin(angle / 2)[:, None]], -1).reshape(-1, 3)
    quads = []
    for k in range(count):
        for j in range(4):
            right = [5 * (k + 1) + j, 5 * (k + 1) + j + 1] if k + 1 < count else [4 - j, 3 - j]
            quads.append([5 * k + j, right[0], right[1], 5 * k + j + 1])
    return quad_mesh("Moebius", positions, np.array(quads))


def squeezed_offsets(base: BaseMesh, settings: MeshSettings = SETTINGS) -> tuple[WrinkleMesh, np.ndarray]:
    mesh = WrinkleMesh.build(base, settings)
    frame = solve_frame(mesh, 1.0, compressed(base.positions, 0.8), settings, {}, start=1)
    return mesh, frame.positions


class Healing(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(12, 10)

    def assert_same_folds(self, positions: np.ndarray, expected: np.ndarray) -> None:
        """Vertices have other numbers, so constraints are solved in another order, and a tube folds the same on all
        sides: the folds are as many and as high, not in the same place."""
        radii = [np.linalg.norm(of[:, :2], axis=1) for of in (positions, expected)]
        np.testing.assert_allclose(radii[0].std(), radii[1].std(), rtol=0.15)
        np.testing.assert_allclose(radii[0].mean(), radii[1].mean(), rtol=0.02)

    def test_a_mesh_without_faults_is_not_touched(self) -> None:
        self.assertIs(self.base.healed(True), self.base)

    def test_turned_faces_wrinkle_as_if_they_were_not(self) -> None:
        """The bought blouse: faces 76 and 90 met with opposite normals, and nothing was solved."""
        faces = [3, 40, 41, 52, 100]
        mesh, positions = squeezed_offsets(turned(self.base, faces))
        right, expected = squeezed_offsets(self.base)
        self.assertEqual(mesh.base.origin.elements["turned"].tolist(), faces)
        np.testing.assert_array_equal(np.sort(mesh.polygon_parent), np.sort(right.polygon_parent))
        self.assert_same_folds(positions, expected)

    def test_the_larger_side_of_a_sheet_stays_and_a_tube_faces_outwards(self) -> None:
        most = list(range(70))
        self.assertEqual(turned(self.base, most).healed(True).origin.elements["turned"].tolist(), most)
        flat = replace(self.base, positions=self.base.positions * np.array((1, 1, 0), np.float32))
        self.assertEqual(turned(flat, most).healed(True).origin.elements["turned"].tolist(), list(range(70, 120)))

    def test_faces_that_lie_on_others_are_shown_with_the_same_wrinkles(self) -> None:
        for inside_out in (False, True):
            faces = np.array([5, 6, 60])
            base = doubled(self.base, faces, inside_out)
            mesh, positions = squeezed_offsets(base)
            right, expected = squeezed_offsets(self.base)
            np.testing.assert_array_equal(positions, expected)  # what is shown twice is solved once
            count = len(right.polygon_parent)
            self.assertEqual(sorted(set(mesh.polygon_parent[count:])), [120, 121, 122])
            self.assertEqual(len(mesh.polygon_parent) - count, 3 * count // 120)
            for polygon in range(count, len(mesh.polygon_parent)):
                corners = mesh.corner_vertex[mesh.polygon_start[polygon]:mesh.polygon_start[polygon + 1]].tolist()
                original = faces[mesh.polygon_parent[polygon] - 120]
                same = [p for p in np.flatnonzero(right.polygon_parent == original)
                        if sorted(right.corner_vertex[4 * p:4 * p + 4]) == sorted(corners)]
                self.assertEqual(len(same), 1)
                others = right.corner_vertex[4 * same[0]:4 * same[0] + 4].tolist()
                place = others.index(corners[0])
                following = others[(place + (-1 if inside_out else 1)) % 4]
                self.assertEqual(corners[1], following)

    def test_every_face_has_the_values_of_its_own_corners(self) -> None:
        for inside_out in (False, True):
            base = doubled(turned(self.base, [5, 9]), np.array([5, 6, 60]), inside_out)
            mesh = WrinkleMesh.build(base, SETTINGS)
            places = mesh.carry_corners(np.ascontiguousarray(base.positions[base.corner_vertex]))
            np.testing.assert_allclose(places, mesh.carry_points(base.positions)[mesh.corner_vertex], atol=1e-6)
            numbers = mesh.carry_corners(np.repeat(np.arange(len(quads_of(base)), dtype=np.float32), 4)[:, None])[:, 0]
            np.testing.assert_allclose(numbers, np.repeat(mesh.polygon_parent, 4), atol=1e-4)

    def test_a_flap_that_is_sewn_on_is_cut_off_and_the_garment_is_not(self) -> None:
        mesh, positions = squeezed_offsets(with_fin(self.base))
        _, expected = squeezed_offsets(self.base)
        self.assertEqual(len(mesh.base.origin.elements["cut"]), 12)
        of_tube = np.unique(mesh.corner_vertex.reshape(-1, 4)[mesh.polygon_parent < 120])
        self.assert_same_folds(positions[of_tube], expected)

    def test_a_strip_with_one_side(self) -> None:
        base = moebius()
        mesh, positions = squeezed_offsets(base)
        self.assertGreaterEqual(len(mesh.base.origin.elements["cut"]), 4)
        self.assertLess(len(mesh.base.origin.elements["cut"]), 10)  # across, not along
        self.assertTrue(np.isfinite(positions).all())
        self.assertEqual(len(np.unique(mesh.polygon_parent)), len(quads_of(base)))

    def test_rigid_motion_carries_it_along(self) -> None:
        base = with_fin(doubled(turned(self.base, [3, 40]), np.array([7]), True))
        mesh = WrinkleMesh.build(base, SETTINGS)
        moved = base.positions + np.float32(0.25)
        frame = solve_frame(mesh, 1.0, moved, SETTINGS, {}, start=1)
        np.testing.assert_allclose(frame.positions, mesh.positions_rest + 0.25, atol=2e-6)

    def test_all_systems_solve_what_is_broken_and_answer_in_the_artists_numbering(self) -> None:
        base = with_fin(doubled(turned(self.base, [3, 40]), np.array([7, 8]), True))
        posed = compressed(base.positions, 0.8)
        paint = {"mask": np.linspace(0.0, 1.0, len(base.positions), dtype=np.float32)}
        for system, settings in ((WrinkleField, FieldSettings(wavelength=0.04)),
                                 (WrinklePaths, PathsSettings(width=0.02)),
                                 (WrinkleMesh, MeshSettings(**cloth_defaults(base, 1.0, np.eye(3))))):
            mesh: Wrinkles = system.build(base, settings)
            frame = solve_frame(mesh, 1.0, posed, settings, paint if system is not WrinkleMesh else {}, start=1)
            self.assertEqual(len(frame.positions), mesh.vertex_count)
            self.assertTrue(np.isfinite(frame.positions).all())
            self.assertLess(mesh.triangle_vertex.max(), len(base.positions))
            self.assertLess(mesh.edge_parent.max(), len(base.positions))
            self.assertEqual(mesh.coarse_count, len(base.positions))
            for attribute in mesh.ATTRIBUTES:
                rows = mesh.vertex_count if attribute.domain == "POINT" else len(mesh.corner_vertex)
                self.assertEqual(len(frame.attributes[attribute.name]), rows, attribute.name)
            self.assertRegex(" ".join(mesh.base.origin.notes("Fin")), "Fin: each of 2 faces")
            if system is WrinklePaths:
                curves = mesh.curves(1.0, posed, settings)
                self.assertTrue(len(curves.corners) == 0 or curves.corners.max() < len(base.positions))
                preview = solve_frame(mesh, 1.0, posed, settings, paint, start=1, for_preview=True)
                self.assertEqual(len(preview.proxy_offset), len(base.positions))

    def test_the_brush_paints_vertices_of_the_artist(self) -> None:
        base = with_fin(self.base)
        field = WrinkleField.build(base, FieldSettings(wavelength=0.04))
        easel = Easel(field)
        easel.pose(np.ascontiguousarray(field.base.points(base.positions)))
        painted = np.zeros_like(base.positions)
        scattered = easel.scatter(1, 1.0, 0.05, 0.7)
        self.assertEqual(len(scattered), len(base.positions))
        centre = base.positions[12 * 4]
        out = easel.dab(painted, False, centre=centre, normal=(1.0, 0.0, 0.0), view=(-1.0, 0.0, 0.0),
                        direction=np.array((0.0, 0.0, 1.0), np.float32), radius=0.05, strength=1.0, length=0.7)
        self.assertEqual(len(out), len(base.positions))
        self.assertGreater(np.abs(out).max(), 0.1)

    def test_the_sentences_name_object_and_element(self) -> None:
        notes = with_fin(doubled(turned(self.base, [3]), np.array([7, 8]), True)).healed(True).origin.notes("Shirt")
        self.assertRegex(notes[0], r"^Shirt: each of \d+ faces \(the first is face \d+\) faces|^Shirt: face 3 faces")
        self.assertTrue(any("each of 12 edges (the first is edge" in note for note in notes), notes)
        self.assertTrue(any("each of 2 faces (the first is face 120) lies on another" in note for note in notes), notes)

    def test_only_what_has_no_face_or_is_not_finite_is_refused(self) -> None:
        rng = np.random.default_rng(4)
        for _ in range(200):  # nothing but chance: faces through one another, edges with many faces
            count = int(rng.integers(1, 30))
            quads = np.stack([rng.choice(9, 4, replace=False) for _ in range(count)])
            base = quad_mesh("Chance", rng.random((9, 3)).astype(np.float32), quads)
            mesh = WrinkleMesh.build(base, replace(SETTINGS, level=1))
            self.assertEqual(sorted(set(mesh.polygon_parent)), list(range(count)))


class BuiltOnce(unittest.TestCase):
    """Of equal arrays, whoever holds them; and only within it."""

    def test_equal_arrays_are_one_surface_and_others_are_not(self) -> None:
        base = tube(12, 8, 0.1, 0.5)
        with built_once():
            made = base.surface(True)
            self.assertIs(replace(base, positions=base.positions.copy()).surface(True), made)
            self.assertIsNot(replace(base, positions=base.positions + np.float32(1.0)).surface(True), made)
            self.assertIsNot(base.surface(False), made)
            creased = replace(base, crease_edge=quads_of(base)[:1, :2].copy(),
                              crease_sharpness=np.ones(1, np.float32))
            self.assertIsNot(creased.surface(True), made)
        self.assertIsNot(base.surface(True), made)
