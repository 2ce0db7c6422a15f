# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of scripts/truth_measures.py and of the bench's measures on waves that are known beforehand."""
from __future__ import annotations

import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import bench_consistency as consistency  # noqa: E402
import bench_measures as bench  # noqa: E402
import bench_overview as overview  # noqa: E402
import truth_measures as truth  # noqa: E402

EDGE = 0.008  # metres
AMPLITUDE = 0.003  # metres


def sheet(edge: float = EDGE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A square of cloth, 80 edges wide: points (n, 3) metres, triangles (t, 3), the 64 mm patch (t,) of each."""
    count = 81
    x, y = np.meshgrid(np.arange(count) * edge, np.arange(count) * edge, indexing="ij")
    points = np.stack([x, y, np.zeros_like(x)], 2).reshape(-1, 3)
    number = np.arange(count * count).reshape(count, count)
    a, b, c, d = (n.ravel() for n in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    middle = points[triangles].mean(1)
    patch = (middle[:, 0] // 0.064).astype(int) * 100 + (middle[:, 1] // 0.064).astype(int)
    return points, triangles, patch


def waves(points: np.ndarray, length: float, direction: tuple[float, float] = (1.0, 0.0)) -> np.ndarray:
    """points (n, 3) with waves of that length in metres, AMPLITUDE high, running in a direction of the plane."""
    phase = 2.0 * np.pi * (points[:, :2] @ np.array(direction)) / length
    return points + np.stack([0.0 * phase, 0.0 * phase, AMPLITUDE * np.cos(phase)], 1)


class Measures(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.points, cls.triangles, cls.patch = sheet()
        cls.cloth = truth.build_cloth(cls.points, cls.triangles, cls.patch)

    def test_a_wave_falls_into_its_band(self) -> None:
        for length, name in ((0.040, "28_to_55"), (0.080, "55_to_110"), (0.160, "110_to_220"),
                             (0.320, "above_220")):
            with self.subTest(length):
                found = truth.measures(self.cloth, self.points, waves(self.points, length))
                whole = AMPLITUDE * 1e3 / np.sqrt(2.0)
                self.assertAlmostEqual(found["rms_mm"], whole, delta=0.03 * whole)
                self.assertGreater(found[f"rms_{name}_mm"], 0.93 * whole)
                for other in truth.BANDS:
                    if other != name:
                        self.assertLess(found[f"rms_{other}_mm"], 0.25 * whole, other)

    def test_a_short_wave_on_fine_cloth(self) -> None:
        points, triangles, _ = sheet(0.004)
        found = truth.measures(truth.build_cloth(points, triangles), points, waves(points, 0.020))
        self.assertGreater(found["rms_below_28_mm"], 0.99 * found["rms_mm"])

    def test_a_slanting_wave_is_as_long_as_a_straight_one(self) -> None:
        found = truth.measures(self.cloth, self.points, waves(self.points, 0.080, (0.6, 0.8)))
        self.assertGreater(found["rms_55_to_110_mm"], 0.93 * found["rms_mm"])

    def test_the_bands_are_the_whole(self) -> None:
        height = np.random.default_rng(1).normal(size=len(self.points))
        np.testing.assert_allclose(truth.bands(self.cloth, height).sum(0), height, atol=1e-12)

    def test_a_lifted_sheet_is_the_longest_band(self) -> None:
        found = truth.measures(self.cloth, self.points, self.points + (0.0, 0.0, 0.005))
        self.assertAlmostEqual(found["rms_above_220_mm"], 5.0, delta=0.02)
        self.assertLess(found["rms_110_to_220_mm"], 0.02)

    def test_alignment_is_1_along_the_compression_and_0_across(self) -> None:
        base = self.points * (0.9, 1.0, 1.0)
        for direction, wanted in (((1.0, 0.0), 1.0), ((0.0, 1.0), 0.0), ((0.70711, 0.70711), 0.5)):
            found = truth.measures(self.cloth, base, waves(base, 0.080, direction))
            self.assertAlmostEqual(found["alignment"], wanted, delta=0.01)

    def test_alignment_follows_a_turned_base(self) -> None:
        turn = np.array([[0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [0.8, 0.0, 0.6]])
        base = self.points * (1.0, 0.9, 1.0)
        found = truth.measures(self.cloth, base @ turn.T, waves(base, 0.080, (0.0, 1.0)) @ turn.T)
        self.assertAlmostEqual(found["alignment"], 1.0, delta=0.01)

    def test_no_compression_no_alignment(self) -> None:
        found = truth.measures(self.cloth, self.points, waves(self.points, 0.080))
        self.assertTrue(np.isnan(found["alignment"]))
        self.assertAlmostEqual(found["detail_where_not_compressed"], 1.0)

    def test_detail_beside_the_compression(self) -> None:
        base = self.points.copy()
        half = 0.32
        base[:, 0] = np.where(base[:, 0] < half, 0.9 * base[:, 0], base[:, 0] - 0.1 * half)
        found = truth.measures(self.cloth, base, waves(base, 0.080, (0.0, 1.0)))
        self.assertAlmostEqual(found["detail_where_not_compressed"], 0.5, delta=0.02)
        self.assertAlmostEqual(found["area_not_compressed"], 0.5, delta=0.01)
        self.assertAlmostEqual(found["alignment"], 0.0, delta=0.02)

    def test_area_kept(self) -> None:
        found = truth.measures(self.cloth, self.points * (0.9, 1.0, 1.0), self.points * (0.95, 1.0, 1.0))
        self.assertAlmostEqual(found["area_kept"], 0.95, places=6)
        self.assertAlmostEqual(found["area_of_base"], 0.90, places=6)

    def test_a_wave_has_its_length(self) -> None:
        for length in (0.050, 0.080, 0.120):
            found = bench.mean_wavelength(self.cloth, self.points, waves(self.points, length, (0.6, 0.8)))
            self.assertAlmostEqual(found, length, delta=0.05 * length)
        self.assertTrue(np.isnan(bench.mean_wavelength(self.cloth, self.points, self.points)))

    def test_folds_that_ride_along_do_not_change(self) -> None:
        """A walking shirt turns with the body: only what moves on it counts."""
        turn = np.array([[0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [0.8, 0.0, 0.6]])
        fine = waves(self.points, 0.080)
        before = bench.offsets_on(self.cloth, self.points, fine)
        now = bench.offsets_on(self.cloth, self.points @ turn.T + 2.0, fine @ turn.T + 2.0)
        self.assertLess(bench.change(before, now), 1e-9)

    def test_a_wave_that_runs_changes_by_what_it_moves(self) -> None:
        shifted = self.points + (0.0, 0.0, 0.003)
        before, now = (bench.offsets_on(self.cloth, self.points, fine) for fine in (self.points, shifted))
        self.assertAlmostEqual(bench.change(before, now), 0.003)

    def test_the_same_waves_overlap_wholly_and_shifted_ones_by_the_cosine_of_their_shift(self) -> None:
        length = 0.08  # 8 of them on the sheet
        usual = self.folds(waves(self.points, length))
        for turn, expected in ((0.0, 1.0), (1.0 / 6.0, 0.5), (0.25, 0.0), (0.5, -1.0)):
            shifted = waves(self.points + (turn * length, 0.0, 0.0), length) - (turn * length, 0.0, 0.0)
            self.assertAlmostEqual(usual.overlap(self.folds(shifted)), expected, delta=0.03)
        self.assertAlmostEqual(usual.overlap(self.folds(waves(self.points, length, (0.0, 1.0)))), 0.0, delta=0.03)

    def test_twice_as_high_waves_overlap_wholly_and_have_twice_the_band(self) -> None:
        fine = waves(self.points, 0.08)
        usual, higher = self.folds(fine), self.folds(2.0 * fine - self.points)
        self.assertAlmostEqual(usual.overlap(higher), 1.0, places=6)
        self.assertAlmostEqual(higher.rms["55_to_110"] / usual.rms["55_to_110"], 2.0, places=6)

    def folds(self, fine: np.ndarray) -> consistency.Folds:
        """Of a clip of two frames that are alike."""
        return consistency.Folds(self.cloth, np.stack([self.points] * 2), np.stack([fine] * 2))

    def test_moments_are_at_the_same_times_at_every_rate(self) -> None:
        for first, second in ((40, 75), (10, 40)):  # frames at 30 a second
            times = [consistency.moments(np.arange(first * rate // 30, second * rate // 30 + 1), rate) / rate
                     for rate in consistency.RATES]
            self.assertGreaterEqual(len(times[0]), consistency.MOMENTS)
            for other in times[1:]:
                np.testing.assert_allclose(other, times[0])


class Overview(unittest.TestCase):
    """The table at the head of docs/bench.md."""

    def test_it_is_written_from_the_tables_of_the_page(self) -> None:
        page = overview.PAGE.read_text(encoding="utf-8")
        self.assertEqual(overview.renewed(page), page)
        self.assertEqual(page.count(f"| {overview.SIMULATED} |"), len(overview.scenes(page)))

    def test_it_has_the_contenders_in_turn_and_folds_as_a_share(self) -> None:
        head = "|  | ms | area kept | 55 to 110 | frame to frame | in the body, % | crossings |\n| --- |\n"
        rows = "".join(f"| {name} | {number} | 1.0{number} | {2 * number}.0 | 0.{number} | {number} | 7{number} |\n"
                       for number, name in enumerate(overview.CONTENDERS, 1))
        page = f"# Bench\n\n## A cape (S9, frames 1 to 40)\n{head}{rows}\n## Density\n|  | ms |\n| --- |\n"
        self.assertEqual(overview.overview(page).splitlines()[2:], [
            "| A cape (S9) | 1 / 2 / 3 / 4 | 1.01 / 1.02 / 1.03 / 1.04 | 0.50 / 1.00 / 1.50 / 2.00 | "
            "0.1 / 0.2 / 0.3 / 0.4 | 1 / 2 / 3 / 4 | 71 / 72 / 73 / 74 |"])


if __name__ == "__main__":
    unittest.main()
