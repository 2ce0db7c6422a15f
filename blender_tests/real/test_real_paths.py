# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole clips of the real scenes with the Wrinkle Paths, default settings: laws, and how much folds move.

The scenes are beside the project (RUMPLE_DATA); SOURCES.md there says whose they are. What was measured goes to
RUMPLE_OUT, a JSON file for each clip.
"""
from __future__ import annotations

import json
import unittest

import bpy
import numpy as np
from rumple import native
from rumple.blender import registry, versions
from test_real_scenes import DATA, OUT, digest


class Folding:
    """One garment, played through once."""

    file: str
    name: str

    @classmethod
    def setUpClass(cls) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{cls.file}.blend"))
        cls.scene, cls.garment = bpy.context.scene, bpy.data.objects[cls.name]
        for other in bpy.data.objects:  # bodies do not matter here, and cost time
            if other.type == "MESH" and other != cls.garment:
                other.hide_viewport = True
        bpy.context.view_layer.objects.active = cls.garment
        cls.frames = range(cls.scene.frame_start, cls.scene.frame_end + 1)
        cls.scene.frame_set(cls.frames[0])
        assert bpy.ops.object.rumple_add(method="PATHS") == {"FINISHED"}, cls.garment.rumple.message
        cls.fine = registry.runtime(cls.garment).fine
        cls.seen = [cls.look(frame) for frame in cls.frames]
        cls.report()

    @classmethod
    def look(cls, frame: int) -> dict:
        """Show a frame and measure it."""
        cls.scene.frame_set(frame)
        mesh = cls.garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        shown = versions.positions(mesh)
        entry = registry.runtime(cls.garment)
        state, report = cls.fine.history.get(float(frame)).state, entry.picture.report
        return dict(frame=frame, message=cls.garment.rumple.message, finite=bool(np.isfinite(shown).all()),
                    digest=digest(shown), fault=native.load().wrinkle_path_fault(cls.fine.model, state),
                    paths=report.paths, born=report.born, moved=report.moved_most,
                    height=float(np.abs(entry.picture.attributes["rumple_height"]).max()),
                    milliseconds=sum(entry.picture.milliseconds.values()))

    @classmethod
    def report(cls) -> None:
        OUT.mkdir(parents=True, exist_ok=True)
        summary = dict(file=cls.file, garment=cls.name, blender=bpy.app.version_string, frames=len(cls.seen),
                       width=cls.garment.rumple.paths.width, shown_vertices=cls.fine.vertex_count,
                       paths_mean=float(np.mean([s["paths"] for s in cls.seen])), born=sum(s["born"] for s in cls.seen),
                       moved_99_mean=float(np.mean([s["moved"] for s in cls.seen])),
                       milliseconds=float(np.median([s["milliseconds"] for s in cls.seen])))
        (OUT / f"paths_{cls.file}_{cls.name}.json").write_text(json.dumps(summary, indent=1))

    def test_every_frame_is_there_and_finite(self) -> None:
        self.assertGreaterEqual(len(self.seen), 100)
        for seen in self.seen:
            self.assertEqual((seen["message"], seen["finite"]), ("", True), seen["frame"])

    def test_every_path_lies_on_the_surface(self) -> None:
        self.assertEqual([(s["frame"], s["fault"]) for s in self.seen if s["fault"]], [])

    def test_folds_come_and_go_and_are_no_higher_than_wide(self) -> None:
        self.assertGreater(max(s["paths"] for s in self.seen), 3)
        self.assertGreater(sum(s["born"] for s in self.seen), 5)
        width = self.garment.rumple.paths.width
        self.assertGreater(max(s["height"] for s in self.seen), 0.2 * width)
        self.assertLess(max(s["height"] for s in self.seen), 1.5 * width)

    def test_replayed_in_any_order_to_the_bit(self) -> None:
        for index in (len(self.seen) - 1, 0, *np.random.default_rng(1).permutation(len(self.seen))[:16]):
            self.assertEqual(self.look(self.seen[index]["frame"])["digest"], self.seen[index]["digest"])


class WalkingShirt(Folding, unittest.TestCase):
    file, name = "S1_walk_shirt", "shirt"


class WalkingTrousers(Folding, unittest.TestCase):
    file, name = "S1_walk_shirt", "trousers"


class JumpingTrousers(Folding, unittest.TestCase):
    file, name = "S2_squat_trousers", "trousers"


class SimulatedSkirt(Folding, unittest.TestCase):
    file, name = "S3_skirt_sim", "skirt"
