# SPDX-License-Identifier: GPL-3.0-or-later
"""Folds along guides: as many, as deep, as wide and in that direction as was asked, and nothing elsewhere."""
from __future__ import annotations

import math
import unittest
from dataclasses import replace
from typing import Any

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.paint import fold_guides
from rumple.core.paint.fold_guides import DIRECTION, GUIDES, KNIFE, PLEATS, PUCKER, TUCKS, profile
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import compressed, rotated, sheet, tube

SPACING, DEPTH, COUNT = 0.04, 0.008, 3
SYSTEMS: dict[str, tuple[Any, Any]] = {
    "mesh": (WrinkleMesh, MeshSettings(density="LEVEL", level=2)),
    "layers": (WrinkleMesh, MeshSettings(density="LEVEL", level=2, layers="CLOTH", base_cloth="HANG")),
    "field": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=SPACING)),
    "paths": (WrinklePaths, PathsSettings(width=SPACING)),
}


def guide(points: Any, kind: int = PLEATS, count: int = COUNT, line: int = 0, factor: float = 1.0,
          others: float = 0.0, depth: float = DEPTH) -> np.ndarray:
    """Rows of a guide through some points."""
    about = [factor, line, kind, count, SPACING, depth, others]
    return np.array([[*point, *about] for point in points], np.float32)


def solved(base: BaseMesh, system: Any, settings: Any, guides: np.ndarray | None, positions: np.ndarray) -> Any:
    mesh = system.build(base, settings)
    paint = {} if guides is None else {GUIDES: guides}
    return mesh, solve_frame(mesh, 1.0, positions, settings, paint, start=1)


def crest_direction(points: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Along the folds, (2,): across their mean gradient, of heights over a plane, by fits around each point."""
    tensor = np.zeros((2, 2))
    for point in points[::7]:
        near = np.linalg.norm(points - point, axis=1) < 0.2 * SPACING
        plane = np.column_stack([points[near] - point, np.ones(near.sum())])
        gradient = np.linalg.lstsq(plane, heights[near], rcond=None)[0][:2]
        tensor += np.outer(gradient, gradient)
    return np.linalg.eigh(tensor)[1][:, 0]


class OnASheet(unittest.TestCase):
    """Half a metre of flat cloth."""

    def setUp(self) -> None:
        self.base = sheet(24, 24, 0.5)
        self.middle = 0.5 * (self.base.positions.min(axis=0) + self.base.positions.max(axis=0))
        self.normal = int(np.ptp(self.base.positions, axis=0).argmin())
        self.plane = [k for k in range(3) if k != self.normal]

    def line(self, degrees: float, length: float = 0.3) -> list[np.ndarray]:
        way = np.zeros(3)
        way[self.plane] = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        return [self.middle - 0.5 * length * way, self.middle + 0.5 * length * way]

    def change(self, guides: np.ndarray, system: str = "mesh") -> tuple[np.ndarray, np.ndarray]:
        """Places in the plane at rest, and the way that guides move each."""
        (mesh, bare), (_, guided) = (solved(self.base, *SYSTEMS[system], g, self.base.positions)
                                     for g in (None, guides))
        return mesh.shown.positions_rest[:, self.plane], guided.positions - bare.positions

    def test_folds_run_along_the_guide_as_deep_and_as_wide_as_asked_in_every_system(self) -> None:
        for system in ("mesh", "field", "paths"):
            for degrees in (0.0, 30.0, 90.0):
                with self.subTest(f"{system} {degrees}"):
                    places, moved = self.change(guide(self.line(degrees)), system)
                    way = np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])
                    from_middle = places - self.middle[self.plane]
                    along, across = from_middle @ way, from_middle @ np.array([-way[1], way[0]])
                    heights = moved[:, self.normal]
                    heights = heights * np.sign(heights[np.abs(heights).argmax()])
                    inside = (np.abs(along) < 0.1) & (np.abs(across) < 0.5 * COUNT * SPACING)
                    self.assertLess(abs(heights[inside].max() / DEPTH - 1.0), 0.1)
                    self.assertLess(abs(heights[inside].min()) / DEPTH, 0.1)
                    found = crest_direction(from_middle[inside], heights[inside])
                    self.assertGreater(abs(found @ way), math.cos(math.radians(10.0)))
                    for fold in (-1, 0, 1):  # a crest in the middle of each, a valley between them
                        for at, low, high in ((fold * SPACING, 0.9, 1.01), ((fold + 0.5) * SPACING, -0.01, 0.1)):
                            close = inside & (np.abs(across - at) < 0.08 * SPACING)
                            self.assertGreater(close.sum(), 3)
                            self.assertGreater(heights[close].mean() / DEPTH, low)
                            self.assertLess(heights[close].mean() / DEPTH, high)

    def test_nothing_moves_beyond_the_folds(self) -> None:
        places, moved = self.change(guide(self.line(0.0)))
        from_middle = np.abs(places - self.middle[self.plane])
        far = (from_middle[:, 1] > 0.5 * COUNT * SPACING + 1e-6) | (from_middle[:, 0] > 0.15 + SPACING)
        self.assertGreater(far.sum(), 1000)
        self.assertEqual(np.abs(moved[far]).max(), 0.0)

    def test_a_guide_that_hovers_counts_where_it_lies_over_the_cloth(self) -> None:
        lift = np.zeros(3)
        lift[self.normal] = 0.01
        _, on = self.change(guide(self.line(30.0)))
        _, over = self.change(guide([point + lift for point in self.line(30.0)]))
        np.testing.assert_allclose(over, on, atol=1e-5)

    def test_one_that_is_far_away_is_named_and_changes_nothing(self) -> None:
        away = guide([point + 5.0 for point in self.line(0.0)])
        mesh, result = solved(self.base, *SYSTEMS["mesh"], away, self.base.positions)
        _, bare = solved(self.base, *SYSTEMS["mesh"], None, self.base.positions)
        np.testing.assert_array_equal(result.positions, bare.positions)
        self.assertIn("too far", " ".join(mesh.status(result)))

    def test_folds_that_the_mesh_cannot_show_are_named(self) -> None:
        coarse = MeshSettings(density="LEVEL", level=0, display_steps=0)
        mesh, result = solved(self.base, WrinkleMesh, coarse, guide(self.line(0.0)), self.base.positions)
        self.assertIn("too coarse", " ".join(mesh.status(result)))

    def test_the_factor_of_a_point_scales_the_depth(self) -> None:
        _, whole = self.change(guide(self.line(0.0)))
        _, half = self.change(guide(self.line(0.0), factor=0.5))
        np.testing.assert_allclose(half, 0.5 * whole, atol=1e-6)

    def test_puckers_run_across_the_guide(self) -> None:
        places, moved = self.change(guide(self.line(0.0), PUCKER, 4))
        from_middle = places - self.middle[self.plane]
        inside = (np.abs(from_middle[:, 0]) < 0.1) & (np.abs(from_middle[:, 1]) < 0.4 * SPACING)
        found = crest_direction(from_middle[inside], moved[inside, self.normal])
        self.assertGreater(abs(found[1]), math.cos(math.radians(10.0)))


class OnATube(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(32, 32, 0.06, 0.5)
        self.line = [(0.06, 0.0, 0.1), (0.06, 0.0, 0.4)]

    def test_around_it_they_are_as_far_apart_as_asked_and_the_other_side_stays(self) -> None:
        """Distances count along the cloth: chords of the tube are 7 % shorter at the second crest."""
        (mesh, bare), (_, guided) = (solved(self.base, *SYSTEMS["mesh"], g, self.base.positions)
                                     for g in (None, guide(self.line, count=5)))
        rest, height = mesh.shown.positions_rest, np.linalg.norm(guided.positions - bare.positions, axis=1)
        arc = 0.06 * np.arctan2(rest[:, 1], rest[:, 0])
        inside = np.abs(rest[:, 2] - 0.25) < 0.1
        for fold in (-2, 2):
            close = inside & (np.abs(arc - fold * SPACING) < 0.5 * SPACING)
            centre = (arc[close] * height[close]).sum() / height[close].sum()
            self.assertLess(abs(centre / (fold * SPACING) - 1.0), 0.03)
        self.assertEqual(height[np.abs(arc) > 0.5 * 5 * SPACING + 0.01].max(), 0.0)

    def test_they_ride_on_the_pose_and_replace_the_other_folds(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            with self.subTest(name):
                turned = np.ascontiguousarray(rotated(self.base.positions, 70.0), np.float32)
                mesh, at_rest = solved(self.base, system, settings, guide(self.line), self.base.positions)
                _, posed = solved(self.base, system, replace(settings, gravity=0.0), guide(self.line), turned)
                folds = mesh._by_hand._folds_on(mesh.shown)  # pylint: disable=protected-access
                inside = folds.rows[folds.left < 0.01]
                self.assertGreater(len(inside), 50)
                heights = [np.linalg.norm(result.offset[inside], axis=1) for result in (at_rest, posed)]
                np.testing.assert_allclose(heights[0], heights[1], atol=3e-4)
                self.assertLess(abs(heights[1].max() / DEPTH - 1.0), 0.1)

    def test_an_edit_changes_nothing_three_wavelengths_away(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            with self.subTest(name):
                posed = compressed(self.base.positions, 0.8)
                short = [(0.06, 0.0, 0.1), (0.06, 0.0, 0.15)]
                (mesh, one), (_, two) = (solved(self.base, system, settings, guide(short, depth=depth), posed)
                                         for depth in (DEPTH, 2.0 * DEPTH))
                moved = np.linalg.norm(one.positions - two.positions, axis=1)
                far = mesh.shown.positions_rest[:, 2] > 0.15 + 3.0 * SPACING
                self.assertGreater(moved[~far].max(), 0.5 * DEPTH)
                self.assertLess(np.percentile(moved[far], 99), 1e-4)

    def test_vertices_without_a_face_change_nothing(self) -> None:
        """They are loose, or those of a rigid part. Here they lie on the guide, and beside the garment."""
        loose = np.array([(0.06, 0.0, 0.25), (0.07, 0.0, 0.25)], np.float32)
        more = replace(self.base, positions=np.concatenate([self.base.positions, loose]))
        for name, (system, settings) in {**SYSTEMS, "waves": (WrinkleField, FieldSettings(wavelength=SPACING))}.items():
            for kind in (PLEATS, DIRECTION):
                with self.subTest(f"{name} {kind}"):
                    one, two = (solved(base, system, settings, guide(self.line, kind),
                                       compressed(base.positions, 0.8))[1] for base in (self.base, more))
                    np.testing.assert_array_equal(two.positions[:len(one.positions)], one.positions)

    def test_what_is_asked_to_stay_between_them_stays(self) -> None:
        posed = compressed(self.base.positions, 0.8)
        system, settings = SYSTEMS["mesh"]
        bare, with_others, alone = (solved(self.base, system, settings, guides, posed)[1] for guides in (
            None, guide(self.line, others=1.0, depth=0.0), guide(self.line, others=0.0, depth=0.0)))
        np.testing.assert_allclose(with_others.positions, bare.positions, atol=1e-7)
        self.assertGreater(np.linalg.norm(alone.positions - bare.positions, axis=1).max(), 0.001)


class Profiles(unittest.TestCase):
    def test_every_kind_is_0_at_its_edge_and_1_at_its_crests(self) -> None:
        across = np.linspace(-0.5 * COUNT * SPACING, 0.5 * COUNT * SPACING, 1201)
        for kind in (PLEATS, KNIFE, TUCKS):
            heights = profile(kind, across, np.zeros_like(across), COUNT, SPACING)
            self.assertLess(max(heights[0], heights[-1]), 1e-4)
            self.assertAlmostEqual(heights.max(), 1.0, delta=1e-3)
            rising = (heights[1:] >= 0.5) & (heights[:-1] < 0.5)
            self.assertEqual(int(rising.sum()), COUNT)

    def test_series_are_the_functions_that_they_stand_for(self) -> None:
        """To the last bits: NumPy's own functions have other last bits on other processors."""
        shares, cosines = np.linspace(-3.0, 3.0, 2001), np.linspace(-1.0, 1.0, 2001)
        np.testing.assert_allclose(fold_guides.crest(shares), 0.5 - 0.5 * np.cos(2.0 * np.pi * shares), atol=1e-14)
        angles = np.maximum(np.arccos(cosines) / 2.0, 1e-6)
        np.testing.assert_allclose(fold_guides._arc_of_chord(cosines), angles / np.sin(angles), rtol=1e-12)

    def test_knife_pleats_lie_to_one_side(self) -> None:
        across = np.linspace(0.0, SPACING, 401)
        heights = profile(KNIFE, across - 0.5 * SPACING, np.zeros_like(across), 1, SPACING)
        self.assertGreater(np.abs(np.diff(heights)).max(), 1.9 * np.diff(heights).max())


if __name__ == "__main__":
    unittest.main()
