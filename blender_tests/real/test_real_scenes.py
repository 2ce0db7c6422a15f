# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole clips of the real scenes with default settings: one click, play, look at every frame.

The scenes are beside the project (RUMPLE_DATA); SOURCES.md there says whose they are. A table of what was
measured goes to RUMPLE_OUT.
"""
from __future__ import annotations

import json
import os
import unittest
from pathlib import Path

import bpy
import numpy as np
from rumple.blender import modifier, properties, registry

DATA = Path(os.environ["RUMPLE_DATA"])
OUT = Path(os.environ["RUMPLE_OUT"])
HELD = 6  # frames past the end of the clip, where every pose is held
LONGEST = 4.0  # no shown edge is longer than this many times the same edge on the unwrinkled surface, or at rest


class Clip:
    """One garment of one file, wrinkled and ready to play."""

    def __init__(self, file: str, garment: str) -> None:
        bpy.ops.wm.open_mainfile(filepath=str(DATA / f"{file}.blend"))
        self.scene = bpy.context.scene
        self.garment = bpy.data.objects[garment]
        bpy.context.view_layer.objects.active = self.garment
        for other in bpy.data.objects:  # bodies and lights do not matter here, and cost time
            if other.type == "MESH" and other != self.garment and "COLLISION" not in {m.type for m in other.modifiers}:
                other.hide_viewport = True
        self.frames = range(self.scene.frame_start, self.scene.frame_end + 1)
        self.scene.frame_set(self.frames[0])
        assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}, self.garment.rumple.message
        self.fine = registry.runtime(self.garment).fine
        corners = self.fine.corner_vertex.reshape(-1, 4)
        self.edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]])

    def show(self, frame: int) -> np.ndarray:
        """Positions that Blender shows at a frame, (d, 3)."""
        self.scene.frame_set(frame)
        mesh = self.garment.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        flat = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", flat)
        return flat.reshape(-1, 3)

    def measures(self, frame: int):
        """The native measures of a frame that has just been shown."""
        entry = registry.runtime(self.garment)
        return self.fine.measure_frame(float(frame), entry.inputs.positions,
                                       properties.settings_of(self.garment, self.scene))

    def lengths(self, positions: np.ndarray) -> np.ndarray:
        return np.linalg.norm(positions[self.edges[:, 0]] - positions[self.edges[:, 1]], axis=1)


class RealClips(unittest.TestCase):

    def check(self, file: str, garment: str) -> None:
        clip = Clip(file, garment)
        rest = clip.lengths(clip.fine.positions_rest)
        rows, kept = [], {}
        for frame in clip.frames:
            shown = clip.show(frame)
            where = f"{file}, {garment}, frame {frame}"
            self.assertEqual(clip.garment.rumple.message, "", where)
            self.assertEqual(len(shown), clip.fine.vertex_count, where)
            self.assertTrue(np.isfinite(shown).all(), where)
            picture = registry.runtime(clip.garment).picture
            np.testing.assert_allclose(shown, picture.positions, atol=2e-5, err_msg=where)
            unwrinkled = clip.lengths(shown - picture.offset)
            spikes = clip.lengths(shown) / np.maximum(np.maximum(unwrinkled, rest), 0.5 * rest.mean())
            self.assertLess(float(spikes.max()), LONGEST, where)
            measures = clip.measures(frame)
            self.assertLess(measures.attachment_violation, 1e-3, where)
            rows.append((frame, measures.compressed_area_before, measures.compressed_area_after,
                         measures.edge_error_before_rms, measures.edge_error_after_rms, measures.largest_offset))
            if frame % 37 == 0:
                kept[frame] = shown
        self.check_areas(np.array(rows), f"{file}, {garment}")
        for frame in sorted(kept, reverse=True):
            np.testing.assert_array_equal(clip.show(frame), kept[frame], err_msg=f"{file}: frame {frame} replayed")
        self.check_hold(clip)
        self.report(file, garment, rows)

    def check_areas(self, rows: np.ndarray, where: str) -> None:
        """Compressed regions come nearer to their rest area, and edges to their rest lengths, over the clip."""
        before, after = np.abs(1.0 - rows[:, 1]).mean(), np.abs(1.0 - rows[:, 2]).mean()
        self.assertLess(after, 0.5 * before, f"{where}: area")
        self.assertLess(rows[:, 4].mean(), rows[:, 3].mean(), f"{where}: edges")

    def check_hold(self, clip: Clip) -> None:
        """Past the end of the animation nothing moves, to the bit."""
        if clip.garment.modifiers[0].type == "CLOTH" or any(m.type == "CLOTH" for m in clip.garment.modifiers):
            return  # live Cloth has no cache past its end
        last = clip.show(clip.frames[-1])
        for frame in range(clip.frames[-1] + 1, clip.frames[-1] + HELD):
            np.testing.assert_array_equal(clip.show(frame), last)

    def report(self, file: str, garment: str, rows: list) -> None:
        OUT.mkdir(parents=True, exist_ok=True)
        names = ("frame", "compressed_area_before", "compressed_area_after", "edge_error_before_rms",
                 "edge_error_after_rms", "largest_offset")
        table = [dict(zip(names, map(float, row))) for row in rows]
        (OUT / f"real_{file}_{garment}.json").write_text(json.dumps(table, indent=1))

    def test_walking_shirt(self) -> None:
        self.check("S1_walk_shirt", "shirt")

    def test_walking_trousers(self) -> None:
        self.check("S1_walk_shirt", "trousers")

    def test_jumping_trousers(self) -> None:
        self.check("S2_squat_trousers", "trousers")

    def test_jumping_sweater(self) -> None:
        self.check("S2_squat_trousers", "sweater")

    def test_simulated_skirt(self) -> None:
        self.check("S3_skirt_sim", "skirt")

    def test_skirt_with_live_cloth(self) -> None:
        self.check("S3_skirt_sim_livecloth", "skirt")

    def test_flag(self) -> None:
        self.check("S5_flag", "flag")


class LiveStack(unittest.TestCase):

    def test_wrinkles_stand_behind_cloth_and_before_solidify(self) -> None:
        clip = Clip("S3_skirt_sim_livecloth", "skirt")
        kinds = [m.type for m in clip.garment.modifiers]
        self.assertEqual(kinds, ["ARMATURE", "CLOTH", "NODES"])
        self.assertEqual(clip.garment.modifiers[2], modifier.find(clip.garment))


if __name__ == "__main__":
    unittest.main()
