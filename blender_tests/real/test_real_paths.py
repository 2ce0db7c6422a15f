# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole clips of the real scenes with the Wrinkle Paths, default settings: laws, and how much folds move.

The scenes are beside the project (RUMPLE_DATA); SOURCES.md there says whose they are. What was measured goes to
RUMPLE_OUT, a JSON file for each clip.
"""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple import native
from rumple.blender import compat
from rumple.blender.objects import runtimes
from support.one_blender import in_one_blender, long_one
from support.real_clip import digest
from support.real_garment import PlayedOnce


class Folding(PlayedOnce):
    method = "PATHS"

    @classmethod
    def look(cls, frame: int) -> dict:
        """Show a frame and measure it."""
        cls.scene.frame_set(frame)
        mesh = cls.garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        shown = compat.positions(mesh)
        runtime = runtimes.of(cls.garment)
        state, report = cls.fine.frame_cache.get(float(frame)).state, runtime.result.report
        return dict(frame=frame, message=cls.garment.rumple.message, finite=bool(np.isfinite(shown).all()),
                    digest=digest(shown), fault=native.load().wrinkle_path_fault(state),
                    paths=report.paths, born=report.born, moved=report.moved_most,
                    height=float(np.abs(runtime.result.attributes["rumple_height"]).max()),
                    milliseconds=sum(runtime.result.milliseconds.values()))

    @classmethod
    def summary(cls) -> dict:
        return dict(width=cls.garment.rumple.paths.width, shown_vertices=cls.fine.vertex_count,
                    paths_mean=float(np.mean([s["paths"] for s in cls.seen])), born=sum(s["born"] for s in cls.seen),
                    moved_99_mean=float(np.mean([s["moved"] for s in cls.seen])),
                    milliseconds=float(np.median([s["milliseconds"] for s in cls.seen])))

    def test_every_path_lies_on_the_surface(self) -> None:
        self.assertEqual([(s["frame"], s["fault"]) for s in self.seen if s["fault"]], [])

    def test_folds_come_and_go_and_are_no_higher_than_wide(self) -> None:
        self.assertGreater(max(s["paths"] for s in self.seen), 3)
        self.assertGreater(sum(s["born"] for s in self.seen), 5)
        width = self.garment.rumple.paths.width
        self.assertGreater(max(s["height"] for s in self.seen), 0.2 * width)
        self.assertLess(max(s["height"] for s in self.seen), 1.5 * width)


class WalkingShirt(Folding, unittest.TestCase):
    file, name = "S1_walk_shirt", "shirt"


@long_one
class WalkingTrousers(Folding, unittest.TestCase):
    file, name = "S1_walk_shirt", "trousers"


@in_one_blender
class JumpingTrousers(Folding, unittest.TestCase):
    file, name = "S2_squat_trousers", "trousers"


@in_one_blender
class SimulatedSkirt(Folding, unittest.TestCase):
    file, name = "S3_skirt_sim", "skirt"
