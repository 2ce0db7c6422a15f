# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole clips of the real scenes with the Wrinkle Field, as geometry, and the Wrinkle Paths over a base cloth, by one
click: how much area they show, and how much they change from frame to frame.

The scenes are beside the project (RUMPLE_DATA); SOURCES.md there says whose they are. What was measured goes to
RUMPLE_OUT, a JSON file for each clip.
"""
from __future__ import annotations

import unittest

import bpy
import numpy as np
from rumple.blender import compat
from rumple.blender.objects import runtimes
from support.one_blender import in_one_blender
from support.real_clip import digest
from support.real_garment import PlayedOnce

MOST_AREA = 1.06  # over that at rest: what the base is stretched across its waves comes on top of the length kept


class OnCloth(PlayedOnce):
    settings: dict = {}
    variant = "_on_cloth"
    most_change = 2.2  # mm, 99th percentile from frame to frame, mean of the clip: the cloth alone has most of it

    @classmethod
    def look(cls, frame: int) -> dict:
        """Show a frame and measure it."""
        cls.scene.frame_set(frame)
        mesh = cls.garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        shown = compat.positions(mesh).copy()
        runtime = runtimes.of(cls.garment)
        picture, cloth = runtime.result, cls.fine.solved_over(float(frame), runtime.inputs.positions)
        area = cls.area(picture.positions) / cls.area(cls.fine.positions_rest)
        return dict(frame=frame, message=cls.garment.rumple.message, finite=bool(np.isfinite(shown).all()),
                    digest=digest(shown), area=area, offset=picture.offset.copy(),
                    hangs=1e3 * float(np.linalg.norm(cloth - runtime.inputs.positions, axis=1).mean()))

    @classmethod
    def area(cls, positions: np.ndarray) -> float:
        quads = cls.fine.corner_vertex.reshape(-1, int(np.diff(cls.fine.polygon_start[:2])[0]))
        one, other = (positions[quads[:, k]] - positions[quads[:, m]] for k, m in ((2, 0), (-1, 1)))
        return 0.5 * float(np.linalg.norm(np.cross(one, other), axis=1).sum())

    @classmethod
    def summary(cls) -> dict:
        cls.changes = [1e3 * float(np.percentile(np.linalg.norm(after["offset"] - before["offset"], axis=1), 99))
                       for before, after in zip(cls.seen, cls.seen[1:])]
        for seen in cls.seen:
            del seen["offset"]
        return dict(change_99_mean=float(np.mean(cls.changes)), change_99_worst=max(cls.changes),
                    area=[min(s["area"] for s in cls.seen), max(s["area"] for s in cls.seen)],
                    hangs_mm=float(np.mean([s["hangs"] for s in cls.seen])))

    def test_it_hangs_by_one_click_over_its_body(self) -> None:
        self.assertEqual(getattr(self.garment.rumple, self.method.lower()).base_cloth, "HANG")
        self.assertIsNotNone(self.garment.rumple.body)
        self.assertGreater(np.mean([seen["hangs"] for seen in self.seen]), 3.0)

    def test_there_is_no_more_cloth_than_at_rest_but_for_what_is_stretched(self) -> None:
        self.assertLess(max(seen["area"] for seen in self.seen), MOST_AREA)

    def test_it_changes_little_from_frame_to_frame(self) -> None:
        self.assertLess(np.mean(self.changes), self.most_change)


class WavesOfAWalkingShirt(OnCloth, unittest.TestCase):
    file, name, method = "S1_walk_shirt", "shirt", "FIELD"
    settings = {"output": "GEOMETRY"}


@in_one_blender
class WavesOfJumpingTrousers(OnCloth, unittest.TestCase):
    file, name, method = "S2_squat_trousers", "trousers", "FIELD"
    settings = {"output": "GEOMETRY"}
    most_change = 3.5


@in_one_blender
class FoldsOfJumpingTrousers(OnCloth, unittest.TestCase):
    file, name, method = "S2_squat_trousers", "trousers", "PATHS"
    most_change = 3.5


if __name__ == "__main__":
    unittest.main()
