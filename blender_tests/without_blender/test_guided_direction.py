# SPDX-License-Identifier: GPL-3.0-or-later
"""Guides of the kind Direction, and painted widths: folds of motion run where, and are as narrow as, an artist asks, in
every system; nothing changes elsewhere."""
from __future__ import annotations

import math
import unittest
from dataclasses import replace
from typing import Any

import numpy as np
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.paint.fold_guides import ALONG, DIRECTION, GUIDES, directions
from rumple.core.paint.paint_maps import NARROWEST, WIDTH, fold_width, narrowest_of
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import rotated, sheet, tube

SIDE, SQUEEZE, REACH, WAVELENGTH = 0.5, 0.85, 0.3, 0.06
SYSTEMS: dict[str, tuple[Any, Any]] = {
    "mesh": (WrinkleMesh, MeshSettings(density="LEVEL", level=2)),
    "layers": (WrinkleMesh, MeshSettings(density="LEVEL", level=2, layers="CLOTH")),
    "field": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=WAVELENGTH)),
    "paths": (WrinklePaths, PathsSettings(width=0.5 * WAVELENGTH, threshold=1.1)),
}


def guide(points: Any, reach: float = REACH, others: float = 0.0, line: int = 0, factor: float = 1.0) -> np.ndarray:
    """Rows of a guide through some points."""
    return np.array([[*point, factor, line, DIRECTION, 1, reach, 0.0, others] for point in points], np.float32)


def way(degrees: float) -> np.ndarray:
    return np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])


def play(system: Any, settings: Any, base: BaseMesh, posed: np.ndarray, paint: dict[str, np.ndarray]) -> Any:
    mesh = system.build(base, settings)
    return mesh, [solve_frame(mesh, float(frame), posed, settings, paint, start=1) for frame in (1, 2, 3)][-1]


def crest_direction(points: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Along the folds, (2,): across their mean gradient, by fits around some points of the plane."""
    tensor = np.zeros((2, 2))
    for point in points[::max(len(points) // 400, 1)]:
        near = np.linalg.norm(points - point, axis=1) < 0.2 * WAVELENGTH
        if near.sum() > 3:
            plane = np.column_stack([points[near] - point, np.ones(near.sum())])
            gradient = np.linalg.lstsq(plane, heights[near], rcond=None)[0][:2]
            tensor += np.outer(gradient, gradient)
    return np.linalg.eigh(tensor)[1][:, 0]


class OnASheet(unittest.TestCase):
    """Half a metre of cloth, pressed together along one of its sides."""

    def setUp(self) -> None:
        self.base = sheet(24, 24, SIDE)
        self.middle = 0.5 * (self.base.positions.min(axis=0) + self.base.positions.max(axis=0))
        self.normal = int(np.ptp(self.base.positions, axis=0).argmin())
        self.plane = [k for k in range(3) if k != self.normal]
        self.posed = self.base.positions.copy()
        self.posed[:, self.plane[0]] += (SQUEEZE - 1.0) * (self.posed - self.middle)[:, self.plane[0]]

    def line(self, degrees: float, length: float = 0.6) -> list[np.ndarray]:
        along = np.zeros(3)
        along[self.plane] = 0.5 * length * way(degrees)
        return [self.middle - along, self.middle + along]

    def found(self, name: str, paint: dict[str, np.ndarray]) -> tuple[np.ndarray, float]:
        """Direction of the folds around the middle, and their RMS height."""
        mesh, shown = play(*SYSTEMS[name], self.base, self.posed, paint)
        core = np.linalg.norm(mesh.shown.positions_rest[:, self.plane] - self.middle[self.plane], axis=1) < 0.14
        at = (shown.positions - self.middle)[core]
        return crest_direction(at[:, self.plane], at[:, self.normal]), float(at[:, self.normal].std())

    def test_folds_run_along_it_within_ten_degrees_and_are_as_high_as_before_in_every_system(self) -> None:
        """Most of all where that is far from where they would run."""
        for name in SYSTEMS:
            bare, height = self.found(name, {})
            self.assertGreater(abs(bare[1]), math.cos(math.radians(10.0)), name)
            for degrees in (0.0, 20.0, 45.0, 90.0):
                with self.subTest(f"{name} {degrees}"):
                    asked = way(degrees) * (SQUEEZE, 1.0)  # the line is pressed together with the cloth
                    found, guided = self.found(name, {GUIDES: guide(self.line(degrees))})
                    self.assertGreater(abs(found @ asked) / np.linalg.norm(asked), math.cos(math.radians(10.0)))
                    self.assertLess(abs(math.log(guided / height)), math.log(1.5))

    def test_how_far_they_turn_is_what_others_leave(self) -> None:
        turned = [abs(self.found("field", {GUIDES: guide(self.line(45.0), others=others)})[0][1])
                  for others in (0.0, 0.5, 1.0)]
        self.assertLess(turned[0], turned[1] - 0.01)
        self.assertLess(turned[1], turned[2] - 0.01)
        self.assertGreater(turned[2], 0.999)

    def test_cloth_at_rest_gets_no_folds(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            _, bare = play(system, settings, self.base, self.base.positions, {})
            _, guided = play(system, settings, self.base, self.base.positions, {GUIDES: guide(self.line(30.0))})
            np.testing.assert_allclose(guided.positions, bare.positions, atol=1e-5, err_msg=name)

    def test_one_that_asks_for_nothing_changes_no_bit(self) -> None:
        for name, (system, settings) in SYSTEMS.items():
            _, bare = play(system, settings, self.base, self.posed, {})
            far = guide([point + 5.0 for point in self.line(30.0)])
            mesh, guided = play(system, settings, self.base, self.posed, {GUIDES: far})
            np.testing.assert_array_equal(guided.positions, bare.positions, name)
            self.assertIn("too far", " ".join(mesh.status(guided)))

    def test_two_that_cross_at_right_angles_ask_for_nothing(self) -> None:
        crossing = np.concatenate([guide(self.line(0.0)), guide(self.line(90.0), line=1)])
        along, _ = directions(crossing, self.base.positions, self.base.polygon_start, self.base.corner_vertex)
        assert along is not None
        middle = np.linalg.norm(self.base.positions - self.middle, axis=1).argmin()
        self.assertLess(np.linalg.norm(along[middle]), 0.02)
        slanted = np.concatenate([guide(self.line(20.0)), guide(self.line(40.0), line=1)])
        along, _ = directions(slanted, self.base.positions, self.base.polygon_start, self.base.corner_vertex)
        assert along is not None
        self.assertGreater(abs(along[middle][self.plane] @ way(30.0)) / np.linalg.norm(along[middle]), 0.999)

    def test_it_is_whole_within_half_of_its_reach_and_nothing_behind_it(self) -> None:
        along, _ = directions(guide(self.line(90.0, 2.0), reach=0.2), self.base.positions, self.base.polygon_start,
                              self.base.corner_vertex)
        assert along is not None
        away = np.abs(self.base.positions - self.middle)[:, self.plane[0]]
        weight = np.linalg.norm(along, axis=1)
        np.testing.assert_allclose(weight[away < 0.1], 1.0, atol=1e-6)
        self.assertEqual(weight[away > 0.2].max(), 0.0)
        self.assertTrue(((weight > 0.0) & (weight < 1.0)).any())


class Elsewhere(unittest.TestCase):
    def test_an_edit_changes_nothing_three_wavelengths_behind_its_reach(self) -> None:
        """Phases of the Wrinkle Field know no end: docs/wrinkle_field.md."""
        base = tube(32, 48, 0.06, 0.8)
        posed = np.ascontiguousarray(base.positions * (1.0, 1.0, 0.8), np.float32)
        for name in ("mesh", "layers", "paths"):
            with self.subTest(name):
                bare, guided = (play(*SYSTEMS[name], base, posed, paint) for paint in (
                    {}, {GUIDES: guide([(0.06, 0.0, 0.02), (0.05, 0.03, 0.2)], reach=0.1)}))
                moved = np.linalg.norm(bare[1].positions - guided[1].positions, axis=1)
                far = bare[0].shown.positions_rest[:, 2] > 0.3 + 3.0 * WAVELENGTH
                self.assertGreater(far.sum(), 100)
                self.assertGreater(moved[~far].max(), 1e-3)
                self.assertLess(np.percentile(moved[far], 99), 1e-4)

    def test_it_turns_with_the_garment(self) -> None:
        """Paths of an even tube start elsewhere after any rounding, with or without a guide."""
        base = tube(32, 24, 0.06, 0.4)
        posed = np.ascontiguousarray(base.positions * (1.0, 1.0, 0.85), np.float32)
        lines = guide([(0.06, 0.0, 0.05), (0.04, 0.045, 0.35)], reach=0.15)
        for name in ("mesh", "layers", "field"):
            system, settings = SYSTEMS[name]
            with self.subTest(name):
                one, turned = (play(system, replace(settings, gravity=0.0), base, positions, {GUIDES: lines})[1]
                               for positions in (posed, np.ascontiguousarray(rotated(posed, 40.0), np.float32)))
                back = rotated(one.positions, 40.0)
                self.assertLess(np.linalg.norm(turned.positions - back, axis=1).mean(), 2e-4)

    def test_the_other_side_of_a_sleeve_is_not_asked(self) -> None:
        base = tube(32, 24, 0.06, 0.4)
        along, _ = directions(guide([(0.06, 0.0, 0.05), (0.06, 0.0, 0.35)], reach=0.1), base.positions,
                              base.polygon_start, base.corner_vertex)
        assert along is not None
        opposite = base.positions[:, 0] < -0.055
        self.assertEqual(np.abs(along[opposite]).max(), 0.0)
        self.assertLess(np.abs((along * base.positions * (1.0, 1.0, 0.0)).sum(axis=1)).max(), 1e-6)  # along the cloth


def wave_length(mesh: Any, shown: Any, plane: list[int], normal: int, middle: np.ndarray) -> float:
    """The mean distance from fold to fold across the first axis of the plane, weighted by power."""
    at, power = shown.positions - middle, np.zeros(0)
    places = np.linspace(-0.2, 0.2, 400, endpoint=False)
    for beside in np.linspace(-0.12, 0.12, 9):
        row = np.abs(at[:, plane[1]] - beside) < 0.008
        order = np.argsort(at[row, plane[0]])
        heights = np.interp(places, at[row, plane[0]][order], at[row, normal][order])
        spectrum = np.abs(np.fft.rfft((heights - heights.mean()) * np.hanning(400))) ** 2
        power = spectrum if not len(power) else power + spectrum
    frequency = np.fft.rfftfreq(400, 0.4 / 400)
    return float(power[2:].sum() / (power[2:] * frequency[2:]).sum())


class Widths(unittest.TestCase):
    SYSTEMS: dict[str, tuple[Any, Any]] = {
        "layers": (WrinkleMesh, MeshSettings(layers="CLOTH", wavelength=0.06)),
        "field": (WrinkleField, FieldSettings(output="GEOMETRY", wavelength=0.08)),
        "paths": (WrinklePaths, PathsSettings(width=0.04, threshold=1.1)),
    }

    def setUp(self) -> None:
        self.base = sheet(30, 30, 0.6)
        self.middle = 0.5 * (self.base.positions.min(axis=0) + self.base.positions.max(axis=0))
        self.normal = int(np.ptp(self.base.positions, axis=0).argmin())
        self.plane = [k for k in range(3) if k != self.normal]
        self.posed = self.base.positions.copy()
        self.posed[:, self.plane[0]] += (SQUEEZE - 1.0) * (self.posed - self.middle)[:, self.plane[0]]

    def solved(self, name: str, weights: np.ndarray | None) -> tuple[Any, Any]:
        base = replace(self.base, narrowest=narrowest_of(weights))
        return play(*self.SYSTEMS[name], base, self.posed, {} if weights is None else {WIDTH: weights})

    def test_half_painted_is_as_half_set_in_every_system(self) -> None:
        weights = np.full(len(self.base.positions), 0.5, np.float32)
        for name, (system, settings) in self.SYSTEMS.items():
            with self.subTest(name):
                length = "width" if name == "paths" else "wavelength"
                halved = replace(settings, **{length: 0.5 * getattr(settings, length)})
                as_set = wave_length(*play(system, halved, self.base, self.posed, {}), self.plane, self.normal,
                                     self.middle)
                painted, whole = (wave_length(*self.solved(name, w), self.plane, self.normal, self.middle)
                                  for w in (weights, None))
                self.assertLess(abs(painted / as_set - 1.0), 0.1)
                self.assertLess(painted, 0.92 * whole)

    def test_between_them_paths_are_as_wide_as_asked(self) -> None:
        whole, less = (wave_length(*self.solved("paths", w), self.plane, self.normal, self.middle)
                       for w in (None, np.full(len(self.base.positions), 0.75, np.float32)))
        self.assertLess(abs(less / whole / 0.75 - 1.0), 0.1)

    def test_a_map_that_is_1_everywhere_changes_no_bit(self) -> None:
        for name in self.SYSTEMS:
            _, bare = self.solved(name, None)
            _, painted = self.solved(name, np.ones(len(self.base.positions), np.float32))
            np.testing.assert_array_equal(painted.positions, bare.positions, name)

    def test_what_is_painted_narrower_changes_nothing_three_wavelengths_away(self) -> None:
        """Of the same fine mesh: a finer one has vertices elsewhere."""
        first = self.plane[0]
        away = self.base.positions[:, first] - self.base.positions[:, first].min()
        for name in ("layers", "paths"):
            with self.subTest(name):
                results = []
                for factor in (0.99, 0.5):  # so little that the same mesh is made
                    weights = np.where(away < 0.12, factor, 1.0).astype(np.float32)
                    results.append(self.solved(name, weights))
                rest = results[0][0].shown.positions_rest
                moved = np.linalg.norm(results[0][1].positions - results[1][1].positions, axis=1)
                far = rest[:, first] - rest[:, first].min() > 0.14 + 3.0 * 0.08
                self.assertGreater(moved.max(), 1e-3)
                self.assertLess(np.percentile(moved[far], 99), 1e-4)

    def test_factors_stay_within_what_meshes_are_made_for(self) -> None:
        np.testing.assert_array_equal(fold_width(np.array([np.nan, 0.0, 0.7, 2.0], np.float32)),
                                      np.array([1.0, NARROWEST, 0.7, 1.0], np.float32))
        self.assertEqual(narrowest_of(None), 1.0)
        self.assertEqual(narrowest_of(np.ones(3, np.float32)), 1.0)
        self.assertEqual(narrowest_of(np.array([1.0, 0.8], np.float32)), NARROWEST)


class Paint(unittest.TestCase):
    def test_a_direction_that_does_not_fit_is_refused_in_words(self) -> None:
        base = sheet(4, 4, 0.2)
        for name, (system, settings) in SYSTEMS.items():
            mesh = system.build(base, settings)
            for bad in (np.full((len(base.positions), 3), 2.0, np.float32), np.zeros((3, 3), np.float32)):
                with self.subTest(name), self.assertRaisesRegex(ValueError, "along"):
                    mesh._take_paint({ALONG: bad})  # pylint: disable=protected-access
                    if name == "field":
                        mesh._paint = mesh._take_paint({ALONG: bad})  # pylint: disable=protected-access
                        mesh._paint.of(mesh.model)


if __name__ == "__main__":
    unittest.main()
