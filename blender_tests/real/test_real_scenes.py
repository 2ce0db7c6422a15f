# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole clips of the real scenes with default settings: one click, play, look at every frame.

The scenes are beside the project (RUMPLE_DATA); SOURCES.md there says whose they are. Each class plays one
clip once and its tests are laws about it. What was measured goes to RUMPLE_OUT, a JSON file for each clip.
"""
from __future__ import annotations

import json
import math
import unittest
from dataclasses import asdict

import bpy
import numpy as np
from rumple.blender.objects import modifier
from rumple.core.systems.fold_density import EDGES_PER_WAVELENGTH
from support.one_blender import in_one_blender, long_one
from support.real_clip import Clip, Seen, digest
from support.real_garment import OUT, EveryFrame

HELD = 8  # frames for which a pose is held
LONGEST = 3.0  # no shown edge is longer than this many times the same edge on the unwrinkled surface, or at rest
COMPRESSED = 0.9  # frames whose compressed regions have at most this share of their rest area are judged by it
# Folds of the default radius (one fine edge, as amplitude of a sine) and width (EDGES_PER_WAVELENGTH edges) make a
# compressed sheet at most this many times as large: 1 + (pi amplitude / wavelength)^2.
FOLDS_REACH = 1.0 + (math.pi / EDGES_PER_WAVELENGTH) ** 2


class PlayedThrough(EveryFrame):
    """The laws of a clip that was played through once, with default settings."""

    file: str
    name: str

    @classmethod
    def setUpClass(cls) -> None:
        cls.clip = Clip(cls.file, cls.name)
        cls.seen = cls.clip.play()
        cls.report()

    @classmethod
    def report(cls) -> None:
        OUT.mkdir(parents=True, exist_ok=True)
        summary = dict(
            file=cls.file, garment=cls.name, blender=bpy.app.version_string, frames=len(cls.seen),
            shown_vertices=cls.clip.fine.vertex_count, solved_vertices=cls.clip.fine.solve_vertex_count,
            worst_spike=max(s.spike for s in cls.seen),
            worst_attachment_violation=max(s.attachment_violation for s in cls.seen),
            least_area_before=min(s.compressed_area_before for s in cls.seen),
            least_area_after=min(s.compressed_area_after for s in cls.seen),
            largest_offset_change=max(s.largest_offset_change for s in cls.seen))
        text = json.dumps(dict(summary=summary, frames=[asdict(s) for s in cls.seen]), indent=1)
        (OUT / f"real_{cls.file}_{cls.name}.json").write_text(text)

    def test_every_frame_is_there_and_finite(self) -> None:
        self.assertGreaterEqual(len(self.seen), 100)
        self.for_every_frame(lambda s: s.message == "" and s.finite and s.vertices == self.clip.fine.vertex_count)

    def test_what_is_shown_is_what_was_solved(self) -> None:
        self.for_every_frame(lambda s: s.off_solved < 2e-5)

    def test_it_moves_and_has_folds(self) -> None:
        self.assertEqual(len({s.digest for s in self.seen}), len(self.seen))
        self.assertGreater(max(s.largest_offset for s in self.seen), 0.25 * self.clip.fine.edge_mean)

    def test_no_vertex_leaves_its_radius(self) -> None:
        self.for_every_frame(lambda s: s.attachment_violation < 1e-3)

    def test_no_spikes(self) -> None:
        self.for_every_frame(lambda s: s.spike < LONGEST)

    def test_compressed_regions_come_nearer_to_their_rest_area(self) -> None:
        judged = [s for s in self.seen if s.compressed_area_before < COMPRESSED]
        self.assertGreater(len(judged), 10)
        self.for_every_frame(lambda s: s not in judged or abs(1.0 - s.compressed_area_after)
                             < 0.6 * abs(1.0 - s.compressed_area_before))

    def test_compressed_regions_come_as_near_as_folds_reach_and_no_farther(self) -> None:
        self.for_every_frame(lambda s: s.compressed_area_after > 0.9 * min(1.0, FOLDS_REACH * s.compressed_area_before)
                             and s.compressed_area_after < max(1.1, s.compressed_area_before))

    def test_edges_come_nearer_to_their_rest_lengths(self) -> None:
        before, after = (np.array([getattr(s, f"edge_error_{when}_rms") for s in self.seen])
                         for when in ("before", "after"))
        self.assertLess(after.mean(), before.mean())

    def test_replayed_in_any_order_to_the_bit(self) -> None:
        order = np.random.default_rng(1).permutation(len(self.seen))[:24]
        for index in (len(self.seen) - 1, 0, *order):
            self.same(self.seen[index])

    def same(self, seen: Seen) -> None:
        self.assertEqual(digest(self.clip.show(seen.frame)), seen.digest, f"frame {seen.frame}")

    def test_a_frame_set_again_stays_to_the_bit(self) -> None:
        seen = self.seen[len(self.seen) // 2]
        for _ in range(3):
            self.same(seen)

    def test_jumps_before_playing_leave_no_trace(self) -> None:
        first = self.clip.frames[0]
        bpy.context.view_layer.objects.active = self.clip.garment
        bpy.ops.object.rumple_clear_frames()
        for place in (12, 3, 19, 60):
            self.clip.show(first + place)
        for seen in self.seen[:20]:
            self.same(seen)

    def test_standing_still_nothing_moves(self) -> None:
        if any(m.type == "CLOTH" for m in self.clip.garment.modifiers):
            self.skipTest("a baked Cloth simulation cannot be held")
        held = self.clip.frames[len(self.clip.frames) // 2]
        for frame in range(self.clip.frames[0], held + HELD):  # stored again, as played
            self.clip.show(frame)
        self.clip.hold_from(held)
        expected = self.seen[held - self.clip.frames[0]].digest
        for frame in (*range(held, held + HELD), held + 2, held + 2, held):
            self.assertEqual(digest(self.clip.show(frame)), expected, f"frame {frame}, held from {held} on")


class WalkingShirt(PlayedThrough, unittest.TestCase):
    file, name = "S1_walk_shirt", "shirt"


@long_one
class WalkingTrousers(PlayedThrough, unittest.TestCase):
    file, name = "S1_walk_shirt", "trousers"


@in_one_blender
class JumpingTrousers(PlayedThrough, unittest.TestCase):
    file, name = "S2_squat_trousers", "trousers"


@in_one_blender
class JumpingSweater(PlayedThrough, unittest.TestCase):
    file, name = "S2_squat_trousers", "sweater"


@in_one_blender
class SimulatedSkirt(PlayedThrough, unittest.TestCase):
    file, name = "S3_skirt_sim", "skirt"


class SkirtWithLiveCloth(PlayedThrough, unittest.TestCase):
    file, name = "S3_skirt_sim_livecloth", "skirt"

    def test_wrinkles_stand_behind_cloth(self) -> None:
        self.assertEqual([m.type for m in self.clip.garment.modifiers], ["ARMATURE", "CLOTH", "NODES"])
        self.assertEqual(self.clip.garment.modifiers[2], modifier.find(self.clip.garment))

    def test_wrinkles_are_those_of_the_same_simulation_as_shape_keys(self) -> None:
        twin = Clip(SimulatedSkirt.file, SimulatedSkirt.name)
        self.assertEqual(len(twin.frames), len(self.seen))
        for frame, seen in list(zip(twin.frames, self.seen))[:40]:
            found = twin.look(frame)
            self.assertAlmostEqual(found.compressed_area_before, seen.compressed_area_before, delta=0.01)
            self.assertAlmostEqual(found.compressed_area_after, seen.compressed_area_after, delta=0.02)


@in_one_blender
class Flag(PlayedThrough, unittest.TestCase):
    file, name = "S5_flag", "flag"


class TwoGarments(unittest.TestCase):
    """Garments of one figure, wrinkled together, look as each does alone."""

    def check(self, file: str, *garments: str) -> None:
        together = self.digests(file, *garments)
        for garment in garments:
            alone = self.digests(file, garment)
            self.assertEqual([row[garment] for row in together], [row[garment] for row in alone], garment)

    def digests(self, file: str, *garments: str) -> list[dict[str, str]]:
        clip = Clip(file, *garments)
        rows = []
        for frame in clip.frames[:12]:
            clip.scene.frame_set(frame)
            rows.append({garment.name: digest(clip.shown(garment)) for garment in clip.garments})
        return rows

    def test_shirt_and_trousers(self) -> None:
        self.check("S1_walk_shirt", "shirt", "trousers")

    def test_sweater_and_trousers(self) -> None:
        self.check("S2_squat_trousers", "sweater", "trousers")


if __name__ == "__main__":
    unittest.main()
