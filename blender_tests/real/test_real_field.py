# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole clips of the real scenes with the Wrinkle Field, default settings: laws, and how much phases change.

The scenes are beside the project (RUMPLE_DATA); SOURCES.md there says whose they are. What was measured goes to
RUMPLE_OUT, a JSON file for each clip.
"""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import properties, runtimes
from support.frames import solve_frame
from support.one_blender import in_one_blender
from support.real_clip import digest
from support.real_garment import PlayedOnce

HELD = 12  # frames


def turned(after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """By how much phases differ, radians."""
    return np.abs((after - before + np.pi) % (2.0 * np.pi) - np.pi)


class Waving(PlayedOnce):
    method = "FIELD"

    @classmethod
    def look(cls, frame: int) -> dict:
        """Show a frame and measure it."""
        cls.scene.frame_set(frame)
        mesh = cls.garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        values = [compat.read_attribute(mesh.attributes[a.name]) for a in cls.fine.ATTRIBUTES]
        runtime = runtimes.of(cls.garment)
        return dict(frame=frame, message=cls.garment.rumple.message, finite=all(np.isfinite(v).all() for v in values),
                    digest=digest(np.concatenate([v.ravel() for v in values])),
                    phase=cls.fine.frame_cache.get(float(frame)).state.phase,
                    wrinkled=mesh_amplitude(mesh) > 0.05 * 0.25 * runtime.inputs.settings.wavelength,
                    amplitude=float(mesh_amplitude(mesh).max()), misfit=runtime.result.report.misfit_after)

    @classmethod
    def summary(cls) -> dict:
        welded = cls.fine.model.welded_of
        cls.changes = []
        for before, after in zip(cls.seen, cls.seen[1:]):
            moved = turned(after["phase"], before["phase"])[welded][after["wrinkled"]]
            cls.changes.append(float(np.percentile(moved, 99)) if len(moved) else 0.0)
        return dict(vertices=cls.fine.model.vertex_count, wavelength=cls.garment.rumple.field.wavelength,
                    phase_change_99_mean=float(np.mean(cls.changes)), phase_change_99_worst=max(cls.changes),
                    misfit_turns_mean=float(np.mean([s["misfit"] for s in cls.seen])))

    def test_it_waves_within_the_amplitude_of_the_paper(self) -> None:
        most = 0.25 * self.garment.rumple.field.wavelength
        amplitudes = [seen["amplitude"] for seen in self.seen]
        self.assertGreater(max(amplitudes), 0.3 * most)
        self.assertLessEqual(max(amplitudes), 1.0001 * most)

    def test_phases_of_wrinkles_change_by_less_than_half_a_wave_from_frame_to_frame(self) -> None:
        self.assertLess(np.mean(self.changes), 0.5)
        self.assertLess(max(self.changes), 0.5 * np.pi)

    def test_standing_still_nothing_moves(self) -> None:
        settings = properties.settings_of(self.garment, self.scene)
        held = self.frames[len(self.frames) // 2]
        self.scene.frame_set(held)
        positions = runtimes.of(self.garment).inputs.positions.copy()
        expected = self.fine.frame_cache.get(float(held)).state.phase
        for frame in range(held + 1, held + HELD):
            solve_frame(self.fine, float(frame), positions, settings, {}, start=self.frames[0])
            np.testing.assert_array_equal(self.fine.frame_cache.get(float(frame)).state.phase, expected)
        for frame in self.frames:  # as played again
            self.scene.frame_set(frame)


def mesh_amplitude(mesh: bpy.types.Mesh) -> np.ndarray:
    return compat.read_attribute(mesh.attributes["rumple_amplitude"])[:, 0]


class WalkingShirt(Waving, unittest.TestCase):
    file, name = "S1_walk_shirt", "shirt"


@in_one_blender
class WalkingTrousers(Waving, unittest.TestCase):
    file, name = "S1_walk_shirt", "trousers"


@in_one_blender
class JumpingTrousers(Waving, unittest.TestCase):
    file, name = "S2_squat_trousers", "trousers"


@in_one_blender
class Flag(Waving, unittest.TestCase):
    file, name = "S5_flag", "flag"
