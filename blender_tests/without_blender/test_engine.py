# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of the engine: what a frame looks like does not depend on how one got there."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np
from rumple.core.base.wording import UserError
from rumple.core.frame import frame_cache
from rumple.core.frame.frame_cache import CachedFrame, FrameCache
from rumple.core.mesh.base_mesh import BaseMesh
from rumple.core.mesh.body import Body
from rumple.core.settings.presets import MESH_PRESETS
from rumple.core.settings.system_settings import MeshSettings
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support.frames import solve_frame
from support.meshes import compressed, quad_mesh, rotated, sheet, tube

SETTINGS = MeshSettings(density="LEVEL", level=2)
FRAMES = range(1, 9)


def clip(base: BaseMesh) -> dict[int, np.ndarray]:
    """A tube squeezed more from frame to frame, then let go."""
    return {f: compressed(base.positions, 1.0 - 0.06 * min(f - 1, 9 - f)) for f in FRAMES}


class FrameLaws(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(12, 12)
        self.mesh = WrinkleMesh.build(self.base, SETTINGS)
        self.clip = clip(self.base)

    def solve(self, frame: int, mesh: WrinkleMesh | None = None, settings: MeshSettings = SETTINGS) -> Any:
        return solve_frame((mesh or self.mesh), float(frame), self.clip[frame], settings, {}, start=1)

    def play(self, mesh: WrinkleMesh | None = None) -> list[np.ndarray]:
        return [self.solve(f, mesh).positions for f in FRAMES]

    def test_a_played_clip_replays_to_the_bit_in_any_order(self) -> None:
        played = self.play()
        for frame in (5, 2, 8, 1, 7, 3, 6, 4):
            picture = self.solve(frame)
            self.assertTrue(picture.replayed)
            np.testing.assert_array_equal(picture.positions, played[frame - 1])

    def test_playing_through_gives_the_same_bits_whatever_was_jumped_to_before(self) -> None:
        fresh = self.play()
        other = WrinkleMesh.build(self.base, SETTINGS)
        for frame in (6, 7, 3, 8, 2):
            self.solve(frame, other)
        for one, two in zip(fresh, self.play(other)):
            np.testing.assert_array_equal(one, two)

    def test_what_viewports_show_changes_nothing_in_renders(self) -> None:
        """In one layer, in several, and on a dense garment."""
        dense = tube(40, 60)
        for base, settings in ((self.base, replace(SETTINGS, layers="ONE")),
                               (self.base, replace(SETTINGS, layers="CLOTH")),
                               (dense, replace(MeshSettings(), layers="CLOTH", base_cloth="HANG"))):
            poses = clip(base)
            mesh, other = WrinkleMesh.build(base, settings, viewport_steps=0), WrinkleMesh.build(base, settings)
            self.assertIsNone(other.in_viewport)
            for frame in FRAMES:
                fewer = solve_frame(mesh, float(frame), poses[frame], settings, {}, start=1, in_viewport=True)
                self.assertEqual(len(fewer.positions), mesh.in_viewport.vertex_count)
                self.assertLess(len(fewer.positions), mesh.vertex_count)
            for frame in FRAMES:
                render = solve_frame(mesh, float(frame), poses[frame], settings, {}, start=1)
                expected = solve_frame(other, float(frame), poses[frame], settings, {}, start=1)
                self.assertTrue(render.replayed)
                np.testing.assert_array_equal(render.positions, expected.positions)

    def test_a_jump_starts_canonically_and_is_provisional(self) -> None:
        self.solve(5)
        self.assertEqual(self.mesh.frame_cache.frames(), [(5.0, False)])
        self.play()
        self.assertTrue(all(final for _, final in self.mesh.frame_cache.frames()))

    def test_play_goes_on_through_a_frame_that_was_looked_at(self) -> None:
        other, _ = WrinkleMesh.build(self.base, SETTINGS), self.solve(5)
        for frame in (3, 4, 5):
            np.testing.assert_array_equal(self.solve(frame).positions, self.solve(frame, other).positions)
        self.assertTrue(all(self.solve(frame).replayed for frame in (4, 3, 5)))

    def test_independent_frames_do_not_know_their_neighbours(self) -> None:
        alone = replace(SETTINGS, stateless=True)
        forward = [self.solve(f, settings=alone).positions for f in FRAMES]
        other = WrinkleMesh.build(self.base, SETTINGS)
        for frame in reversed(FRAMES):
            np.testing.assert_array_equal(self.solve(frame, other, alone).positions, forward[frame - 1])

    def test_a_changed_pose_is_solved_again_and_so_are_the_frames_after_it(self) -> None:
        first = self.play()
        kept = self.clip[3]
        self.clip[3] = compressed(self.base.positions, 0.7)
        changed = self.play()
        self.assertTrue((changed[2] != first[2]).any())
        self.assertTrue((changed[3] != first[3]).any())
        self.clip[3] = kept
        for one, two in zip(first, self.play()):
            np.testing.assert_array_equal(one, two)

    def test_a_stored_frame_is_replayed_for_the_same_body_only(self) -> None:
        triangle = np.array([[0, 1, 2]], np.int32)
        here, there, turned = (Body(np.eye(3, dtype=np.float32) + place, order) for place, order in (
            (np.float32(0.0), triangle), (np.float32(1.0), triangle), (np.float32(0.0), triangle[:, ::-1].copy())))
        replayed = []
        for body in (None, None, here, Body(here.positions.copy(), triangle.copy()), there, turned, None):
            picture = solve_frame(self.mesh, 1.0, self.clip[1], SETTINGS, {}, start=1, body=body)
            replayed.append(picture.replayed)
        self.assertEqual(replayed, [False, True, False, True, False, False, False])
        self.assertTrue(here.same_as(Body(here.positions.copy(), triangle.copy())))
        known = replace(here, rest=np.full((3, 3), np.nan, np.float32))  # the digest counts it as well
        self.assertFalse(any(here.same_as(other) for other in (None, there, turned, known)))
        self.assertTrue(known.same_as(replace(known, rest=known.rest.copy())))

    def test_changed_settings_and_paint_forget_the_stored_frames(self) -> None:
        self.play()
        self.solve(8, settings=replace(SETTINGS, radius=0.5))
        self.assertEqual(len(self.mesh.frame_cache.frames()), 1)
        weights = np.zeros(len(self.base.positions), np.float32)
        flat = solve_frame(self.mesh, 5.0, self.clip[5], SETTINGS, {"radius": weights}, start=1)
        self.assertEqual(float(np.abs(flat.offset).max()), 0.0)

    def test_an_animated_setting_keeps_the_frames_and_their_order_does_not_matter(self) -> None:
        growing = {f: replace(SETTINGS, radius=0.4 + 0.1 * f) for f in FRAMES}
        played = [self.solve(f, settings=growing[f]).positions for f in FRAMES]
        self.assertTrue(all(final for _, final in self.mesh.frame_cache.frames()))
        for frame in (6, 2, 8, 3):
            picture = self.solve(frame, settings=growing[frame])
            self.assertTrue(picture.replayed)
            np.testing.assert_array_equal(picture.positions, played[frame - 1])

    def test_an_animated_setting_counts_while_the_pose_is_held(self) -> None:
        self.solve(1)
        self.clip[2] = self.clip[3] = self.clip[5]
        self.solve(2)
        gone = self.solve(3, settings=replace(SETTINGS, radius=0.0))
        self.assertEqual(float(np.abs(gone.offset).max()), 0.0)

    def test_a_setting_changed_between_two_frames_is_right_after_playing_through(self) -> None:
        self.play()
        other = replace(SETTINGS, radius=0.6)
        again = [self.solve(f, settings=other).positions for f in FRAMES]
        fresh = WrinkleMesh.build(self.base, SETTINGS)
        for one, two in zip(again, [self.solve(f, fresh, other).positions for f in FRAMES]):
            np.testing.assert_array_equal(one, two)

    def test_a_held_pose_stays_to_the_bit(self) -> None:
        self.play()
        self.clip.update({f: self.clip[5] for f in range(6, 12)})
        self.solve(5)
        held = [self.solve(f).positions for f in range(6, 12)]
        for later in held[1:]:
            np.testing.assert_array_equal(later, held[0])

    def test_the_memory_limit_holds_and_drops_provisional_frames_first(self) -> None:
        self.solve(6)
        size = self.mesh.frame_cache.bytes
        self.mesh.frame_cache.limit_bytes = 3 * size
        for frame in (1, 2, 3):
            self.solve(frame)
        self.assertEqual(self.mesh.frame_cache.frames(), [(1.0, True), (2.0, True), (3.0, True)])

    def test_a_small_memory_limit_leaves_what_a_frame_or_subframe_goes_on_from(self) -> None:
        """Those farthest from the newest went first: the frame before its own subframes."""
        size = 20 << 20
        samples = [frame + part / 4 for frame in FRAMES for part in range(4)]
        blurred = [frame + part for frame in FRAMES for part in (0.0, 0.25, -0.25)]  # as Cycles asks
        for order in (samples, blurred):
            for limit in (16, 64):
                cache = FrameCache(limit << 20)
                for frame in order:
                    if frame > 1.0:
                        self.assertIsNotNone(cache.before(frame), (frame, limit))
                    cache.put(frame, CachedFrame(b"", b"", True, size))
                    self.assertLessEqual(cache.bytes, 4 * size)

    def test_frames_of_another_first_frame_are_kept_beside_and_go_first(self) -> None:
        self.solve(1)
        cache, size = self.mesh.frame_cache, self.mesh.frame_cache.bytes
        cache.follow("other scene")
        cache.put(7.0, replace(self.mesh.frame_cache._timelines[(1, 0.0)][1.0]))
        self.assertEqual((cache.frames(), cache.bytes), ([(7.0, True)], 2 * size))
        self.solve(1)
        self.assertEqual((cache.frames(), cache.bytes), ([(1.0, True)], 2 * size))
        cache.limit_bytes = 2 * size
        self.solve(2)
        self.assertEqual((cache.frames(), cache.bytes), ([(1.0, True), (2.0, True)], 2 * size))
        for number in range(50):
            cache.follow(number)
        self.assertLessEqual(len(cache._timelines), frame_cache.MOST_TIMELINES)
        self.assertEqual(cache.bytes, 0)
        cache.clear()
        cache.follow((1, 0.0))
        self.assertEqual(cache.frames(), [])

    def test_pictures_are_kept_from_the_second_replay_on(self) -> None:
        """Of viewports and of renders, each to the bit; a clip that is played and then baked or rendered keeps none."""
        self.mesh, other = (WrinkleMesh.build(self.base, SETTINGS, viewport_steps=0) for _ in range(2))
        poses = list(self.clip)[:3]

        def shown(mesh: WrinkleMesh, frame: int, in_viewport: bool) -> np.ndarray:
            return solve_frame(mesh, float(frame), self.clip[frame], SETTINGS, {}, start=1,
                               in_viewport=in_viewport).positions

        expected = {(frame, where): shown(other, frame, where) for where in (False, True) for frame in poses}
        for _ in range(2):
            for frame in poses:
                shown(self.mesh, frame, False)
        self.assertEqual(self.pictures(), 0)
        for _ in range(3):
            for (frame, where), positions in expected.items():
                np.testing.assert_array_equal(shown(self.mesh, frame, where), positions)
        self.assertEqual(self.pictures(), 6)
        with mock.patch.object(self.mesh, "_show", side_effect=AssertionError):
            self.assertTrue(self.solve(2).replayed)

    def test_pictures_do_not_outlive_what_they_were_solved_from(self) -> None:
        for _ in range(4):
            first = self.play()
        kept, self.clip[3] = self.clip[3], compressed(self.base.positions, 0.7)
        for _ in range(4):
            changed = self.play()
        for one, two in zip(changed, self.play(WrinkleMesh.build(self.base, SETTINGS))):
            np.testing.assert_array_equal(one, two)
        self.assertTrue((changed[3] != first[3]).any())
        self.clip[3] = kept
        for _ in range(4):
            np.testing.assert_array_equal(self.play()[2], first[2])

    def test_pictures_take_the_memory_that_states_leave(self) -> None:
        cache = self.mesh.frame_cache
        self.play()
        size = self.solve(1).nbytes
        cache.clear()
        self.play()
        cache.limit_bytes = cache.bytes + 2 * size + size // 2
        for _ in range(3):
            self.play()
        self.assertEqual(self.pictures(), 2)
        self.clip[9] = self.clip[5]
        cache.limit_bytes = cache.bytes + size
        self.solve(9)
        self.assertEqual([frame for frame, _ in cache.frames()], [float(frame) for frame in (*FRAMES, 9)])
        self.assertEqual(self.pictures(), 0)
        cache.limit_bytes = cache.bytes + size
        self.play()
        self.assertEqual(self.pictures(), 1)
        self.assertLessEqual(cache.bytes + self.pictures() * size, cache.limit_bytes)

    def pictures(self) -> int:
        return sum(len(cached.pictures) for *_, cached in self.mesh.frame_cache._all())

    def test_folds_ride_with_a_rigid_motion(self) -> None:
        here = self.solve(5)
        self.clip[5] = rotated(self.clip[5], 70.0)
        there = self.solve(5)
        np.testing.assert_allclose(there.positions, rotated(here.positions, 70.0), atol=2e-4)
        self.assertGreater(float(np.linalg.norm(here.offset, axis=1).max()), 1e-3)


class PictureLaws(unittest.TestCase):
    def test_the_rest_pose_has_stretch_one_and_stays_at_rest(self) -> None:
        base = tube(16, 8)
        settings = replace(SETTINGS, prestretch=1.0)
        picture = solve_frame(WrinkleMesh.build(base, settings), 1.0, base.positions, settings, {}, start=1)
        np.testing.assert_allclose(picture.attributes["rumple_stretch_min"], 1.0, atol=1e-5)
        np.testing.assert_allclose(picture.attributes["rumple_stretch_max"], 1.0, atol=1e-5)
        self.assertLess(float(np.abs(picture.offset).max()), 1e-6)

    def test_stretch_of_a_squeezed_sheet_is_its_squeeze_and_direction(self) -> None:
        base = sheet(6, 6)
        squeezed = compressed(compressed(base.positions, 0.8, axis=0), 1.1, axis=1)
        picture = solve_frame(WrinkleMesh.build(base, SETTINGS), 1.0, squeezed, SETTINGS, {}, start=1)
        np.testing.assert_allclose(picture.attributes["rumple_stretch_min"], 0.8, atol=1e-5)
        np.testing.assert_allclose(picture.attributes["rumple_stretch_max"], 1.1, atol=1e-5)
        np.testing.assert_allclose(np.abs(picture.attributes["rumple_stretch_direction"][:, 0]), 1.0, atol=1e-4)

    def test_local_offsets_rebuild_the_positions_as_the_node_tree_does(self) -> None:
        base = tube(12, 10)
        mesh = WrinkleMesh.build(base, SETTINGS)
        pose = rotated(compressed(base.positions, 0.75), 40.0)
        picture = solve_frame(mesh, 1.0, pose, SETTINGS, {}, start=1)
        p0, p1, p2 = (pose[mesh.triangle_vertex[:, k]].astype(np.float64) for k in range(3))
        unit = lambda v: v / np.linalg.norm(v, axis=1, keepdims=True)
        tangent, normal = unit(p1 - p0), unit(np.cross(p1 - p0, p2 - p0))
        frame = np.stack([tangent, np.cross(normal, tangent), normal], 1)
        b0, b1 = mesh.barycentric[:, :1], mesh.barycentric[:, 1:]
        rebuilt = p0 + b0 * (p1 - p0) + b1 * (p2 - p0) + np.einsum("vi,vij->vj", picture.local_offset, frame)
        np.testing.assert_allclose(rebuilt, picture.positions, atol=2e-6)

    def test_every_preset_makes_finite_folds_on_a_squeezed_tube(self) -> None:
        base = tube(16, 16)
        for name, preset in MESH_PRESETS.items():
            settings = replace(SETTINGS, **preset.values)
            mesh = WrinkleMesh.build(base, settings)
            picture = solve_frame(mesh, 1.0, compressed(base.positions, 0.75), settings, {}, start=1)
            self.assertTrue(np.isfinite(picture.positions).all(), name)
            self.assertGreater(float(np.linalg.norm(picture.offset, axis=1).max()), 1e-4, name)


class FineMesh(unittest.TestCase):
    def test_corner_values_keep_their_seam(self) -> None:
        base = tube(8, 2)
        mesh = WrinkleMesh.build(base, SETTINGS)
        u = np.tile(np.array([0, 1, 1, 0], np.float32), 16) + np.repeat(np.tile(np.arange(8), 2), 4)
        fine = mesh.carry_corners(u.reshape(-1, 1).astype(np.float32))[:, 0]
        self.assertEqual((fine.min(), fine.max()), (0.0, 8.0))
        spans = np.ptp(fine.reshape(-1, 4), axis=1)
        np.testing.assert_allclose(spans, 1 / 8, atol=1e-6)  # no face reaches over the seam

    def test_own_mesh_keeps_its_rest_shape(self) -> None:
        base, settings = tube(12, 6), replace(SETTINGS, source="OBJECT", prestretch=1.0)
        mesh = WrinkleMesh.build(base, settings, own=tube(40, 30, radius=0.052))
        picture = solve_frame(mesh, 1.0, base.positions, settings, {}, start=1)
        np.testing.assert_allclose(picture.positions, mesh.positions_rest, atol=1e-6)

    def test_own_mesh_says_how_many_vertices_are_not_attached(self) -> None:
        base, own = tube(12, 6), tube(20, 12)
        attached = np.ones(len(own.positions), bool)
        attached[:3] = False
        mesh = WrinkleMesh.build(base, replace(SETTINGS, source="OBJECT"), own=own, attached=attached)
        self.assertIn("Tube: 3 vertices are not attached", mesh.warnings)


def bent_to_a_u(positions: np.ndarray, gap: float) -> np.ndarray:
    """A sheet in the xy plane bent about its middle, its two sides gap metres apart and a tenth shorter."""
    size = np.ptp(positions[:, 0])
    along, turn = positions[:, 0] - 0.5 * size, 0.2 * size
    radius, angle = turn / np.pi, np.clip(along / (0.5 * turn), -1.0, 1.0) * np.pi / 2.0
    left = np.maximum(np.abs(along) - 0.5 * turn, 0.0)
    height = np.where(left > 0.0, 0.5 * gap, radius) * np.sin(angle)
    bent = np.stack([radius * np.cos(angle) - left, positions[:, 1], height], 1)
    return np.ascontiguousarray(0.9 * bent, np.float32)


class KeptApart(unittest.TestCase):
    def test_the_status_counts_what_was_kept_from_crossing(self) -> None:
        base = sheet(20, 6, size=0.4)
        settings = MeshSettings(density="LEVEL", level=2, layers="CLOTH", prestretch=1.1)
        mesh = WrinkleMesh.build(base, settings)
        for positions, kept in ((base.positions, False), (bent_to_a_u(base.positions, 0.004), True)):
            picture = solve_frame(mesh, 1.0 + kept, positions, settings, {}, start=1)
            status = "\n".join(mesh.status(picture))
            (self.assertRegex if kept else self.assertNotRegex)(status, r"\d+ vertices kept from crossing")


class BadInput(unittest.TestCase):
    def refused(self, base: BaseMesh, settings: Any = SETTINGS, **arguments: Any) -> str:
        with self.assertRaises(UserError) as caught:
            WrinkleMesh.build(base, settings, **arguments)
        return str(caught.exception)

    def test_messages_name_the_object_and_the_first_bad_element(self) -> None:
        base = sheet(4, 4)
        base.positions[7, 1] = np.nan
        self.assertRegex(self.refused(base), r"^Sheet: .*\b7\b")
        self.assertRegex(self.refused(quad_mesh("Empty", np.zeros((0, 3)), np.zeros((0, 4), int))), r"^Empty: ")

    def test_a_scale_of_zero_and_a_missing_own_mesh_are_refused(self) -> None:
        self.assertIn("scale is zero", self.refused(sheet(2, 2), unit_scale=0.0))
        self.assertIn("choose your own", self.refused(sheet(2, 2), replace(SETTINGS, source="OBJECT")))

    def test_an_own_mesh_far_away_names_its_vertex(self) -> None:
        own = sheet(4, 4)
        own.positions += 5.0
        self.assertRegex(self.refused(sheet(2, 2), replace(SETTINGS, source="OBJECT"), own=own), r"vertex \d+ .* away")

    def test_too_many_vertices_are_refused_before_they_are_made(self) -> None:
        self.assertIn("vertices, more than", self.refused(sheet(60, 60), replace(SETTINGS, level=5, display_steps=2)))

    def test_a_bad_pose_is_refused_and_the_stored_frames_stay(self) -> None:
        base = sheet(4, 4)
        mesh = WrinkleMesh.build(base, SETTINGS)
        solve_frame(mesh, 1.0, base.positions, SETTINGS, {}, start=1)
        bad = base.positions.copy()
        bad[3, 0] = np.inf
        with self.assertRaisesRegex(UserError, r"^Sheet: .*\b3\b"):
            solve_frame(mesh, 2.0, bad, SETTINGS, {}, start=1)
        self.assertEqual(mesh.frame_cache.frames(), [(1.0, True)])


if __name__ == "__main__":
    unittest.main()
