# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames that a viewport draws by itself: they are solved when somebody asks, to the same bits."""
from __future__ import annotations

import unittest
from dataclasses import replace
from unittest import mock
from typing import Any

import numpy as np
from rumple.core.base.wording import UserError
from rumple.core.frame import frame_cache
from rumple.core.mesh.body import Body
from rumple.core.mesh.frame_result import FrameResult, PreviewFrame
from rumple.core.settings.system_settings import FieldSettings, MeshSettings
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from support.frames import solve_frame
from support.meshes import compressed, tube

SETTINGS = FieldSettings(wavelength=0.06, irregularity=0.3)
FRAMES = range(1, 11)


class Counted(WrinkleField):
    """Counts how often it solves."""

    solves = 0

    def _solve(self, *arguments: Any, **named: Any) -> Any:
        self.solves += 1
        return super()._solve(*arguments, **named)


class Waiting(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(12, 12)
        self.clip = {f: compressed(self.base.positions, 1.0 - 0.05 * min(f - 1, 11 - f)) for f in FRAMES}
        self.field, self.plain = Counted.build(self.base, SETTINGS), Counted.build(self.base, SETTINGS)

    def show(self, field: WrinkleField, frame: int, for_preview: bool = False, settings: FieldSettings = SETTINGS,
             paint: dict[str, np.ndarray] | None = None, body: Body | None = None) -> FrameResult | PreviewFrame:
        return solve_frame(field, float(frame), self.clip[frame], settings, paint or {}, start=1,
                           for_preview=for_preview, body=body)

    def test_a_garment_over_waves_that_are_only_drawn_lets_them_wait(self) -> None:
        for frame in (1, 2, 3):
            self.show(self.field, frame, for_preview=True)
        solves = self.field.solves
        self.assertIsNone(self.field.worn_surface(3.0, self.clip[3], SETTINGS))
        self.assertEqual(self.field.solves, solves)

    def same(self, frame: int, settings: FieldSettings = SETTINGS) -> None:
        """What renders show of a frame, with and without the previews before it; and the state that it leaves."""
        found, expected = (self.show(field, frame, settings=settings) for field in (self.field, self.plain))
        self.assertTrue(found.shows_the_same(expected), frame)
        one, two = self.field.state_of(float(frame)), self.plain.state_of(float(frame))
        for name in ("phase", "direction", "solved_offset"):
            np.testing.assert_array_equal(getattr(one, name), getattr(two, name), f"{frame}: {name}")
        self.assertEqual(self.field.frame_cache.frames(), self.plain.frame_cache.frames())
        self.assertEqual(self.field.frame_cache.bytes, self.plain.frame_cache.bytes)

    def play(self, field: WrinkleField, for_preview: bool, frames: range = FRAMES) -> None:
        for frame in frames:
            self.show(field, frame, for_preview)

    def test_a_wild_frame_is_refused_at_once_and_those_after_it_go_on_from_the_last_good_one(self) -> None:
        """A frame that waits is solved under another's name: that would be refused in its place. And without a frame
        before it the next one would begin anew, and never be final."""
        for wild in (1e14, np.nan):
            self.setUp()
            self.clip[5] = self.clip[5].copy()
            self.clip[5][7, 0] = wild
            for field, for_preview in ((self.field, True), (self.plain, False)):
                self.play(field, for_preview, range(1, 5))
                with self.assertRaisesRegex(UserError, "vertex 7 (is|has) .* in this frame"):
                    self.show(field, 5, for_preview)
                self.play(field, for_preview, range(6, 11))
            self.assertEqual(self.plain.frame_cache.frames(), [(float(f), True) for f in FRAMES if f != 5])
            self.assertEqual(self.field.solves, 1)
            for frame in (10, 6, 7):
                self.same(frame)

    def test_only_the_first_frame_is_solved_while_the_preview_plays(self) -> None:
        self.play(self.field, True)
        self.play(self.field, True)  # the clip again: they are stored, and wait
        self.assertEqual(self.field.solves, 1)
        self.field.state_of(4.0)
        self.assertEqual(self.field.solves, 4)
        self.field.state_of(4.0)
        self.assertEqual(self.field.solves, 4)

    def test_renders_after_a_preview_have_the_same_bits_in_any_order(self) -> None:
        for order in (FRAMES, reversed(FRAMES), (6, 2, 10, 1, 3)):
            self.setUp()
            self.play(self.field, True)
            self.play(self.plain, False)
            for frame in order:
                self.same(frame)
            self.assertLessEqual(self.field.solves, len(FRAMES))

    def test_jumps_and_playing_through_afterwards(self) -> None:
        for frame in (6, 7, 8, 3, 4):
            self.show(self.field, frame, True)
            self.show(self.plain, frame)
        self.assertEqual(self.field.solves, 2)  # the two that were jumped to
        self.same(8)
        self.play(self.field, True)
        self.play(self.plain, False)
        for frame in (4, 7, 10):
            self.same(frame)

    def test_another_setting_and_other_paint(self) -> None:
        """Animated from one frame to the next, and changed at the same frame."""
        weak, mask = replace(SETTINGS, strength=0.5), {"mask": np.full(len(self.base.positions), 0.5, np.float32)}
        for field, for_preview in ((self.field, True), (self.plain, False)):
            for frame in range(1, 8):
                self.show(field, frame, for_preview, weak if frame > 4 else SETTINGS)
        self.same(7, weak)
        for field, for_preview in ((self.field, True), (self.plain, False)):
            self.show(field, 8, for_preview)
            self.show(field, 8, for_preview, weak)
            self.show(field, 9, for_preview, weak)
            self.show(field, 9, for_preview, weak, mask)
            self.show(field, 10, for_preview, weak, mask)
        found, expected = (self.show(field, 10, False, weak, mask) for field in (self.field, self.plain))
        self.assertTrue(found.shows_the_same(expected))

    def test_no_more_than_so_many_wait(self) -> None:
        with mock.patch.object(frame_cache, "MOST_WAITING", 3):
            self.play(self.field, True)
            self.assertEqual(self.field.solves, len(FRAMES) - 3)
            self.play(self.plain, False)
            self.same(10)
        self.setUp()
        with mock.patch.object(frame_cache, "MOST_WAITING_BYTES", 0):
            self.play(self.field, True)
            self.assertEqual(self.field.solves, len(FRAMES))

    def test_no_row_waits_for_longer_than_so_many_seconds(self) -> None:
        """Who needs the last frame of a row waits until all of them are solved."""
        self.show(self.field, 1)
        first = self.field.frame_cache.get(1.0)
        assert first is not None
        self.assertGreater(first.solve_seconds, 0.0)
        first.solve_seconds = 1.5
        self.play(self.field, True, range(2, 8))
        self.assertEqual(self.field.frame_cache.seconds_until_solved(7.0), 4.5)  # of three frames
        self.assertEqual(self.field.frame_cache.seconds_until_solved(4.0), 0.0)
        self.play(self.plain, False, range(1, 8))
        self.same(7)

    def test_frames_whose_state_is_read_do_not_wait(self) -> None:
        body = Body(4.0 * np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32))
        for settings, worn in ((replace(SETTINGS, stateless=True), None), (replace(SETTINGS, base_cloth="HANG"), None),
                               (replace(SETTINGS, rest_shape="ADAPTIVE"), None), (SETTINGS, body)):
            field = Counted.build(self.base, settings)
            for frame in FRAMES:
                result = self.show(field, frame, True, settings, body=worn)
                self.assertIsNotNone(result.report)
            self.assertEqual(field.solves, len(FRAMES))

    def test_a_pose_that_is_not_finite_is_refused_at_once(self) -> None:
        self.play(self.field, True, range(1, 5))
        self.clip[5] = np.full_like(self.clip[5], np.nan)
        with self.assertRaisesRegex(ValueError, "no valid position in this frame"):
            self.show(self.field, 5, True)


class WaitingMesh(unittest.TestCase):
    """A single Wrinkle Mesh over the animation waits as well."""

    def test_renders_after_a_preview_have_the_same_bits(self) -> None:
        settings = MeshSettings(density="LEVEL", level=1)
        base = tube(12, 12)
        clip = {f: compressed(base.positions, 1.0 - 0.05 * min(f - 1, 11 - f)) for f in FRAMES}
        previewed, plain = WrinkleMesh.build(base, settings), WrinkleMesh.build(base, settings)
        for frame in FRAMES:
            shown = solve_frame(previewed, float(frame), clip[frame], settings, {}, start=1, for_preview=True)
            assert isinstance(shown, PreviewFrame) and shown.proxy_offset is not None
            self.assertEqual(previewed.frame_cache.seconds_until_solved(float(frame)) > 0.0, frame > 1)
            self.assertEqual(shown.proxy_offset.shape, base.positions.shape)
            self.assertGreater(np.abs(shown.proxy_offset).max(), 0.0)  # to the smooth surface
        for frame in reversed(FRAMES):
            found = solve_frame(previewed, float(frame), clip[frame], settings, {}, start=1)
            solve_frame(plain, float(frame), clip[frame], settings, {}, start=1)
        for frame in FRAMES:
            found, expected = (solve_frame(mesh, float(frame), clip[frame], settings, {}, start=1)
                               for mesh in (previewed, plain))
            self.assertTrue(found.shows_the_same(expected), frame)

    def test_what_the_card_cannot_solve_does_not_wait(self) -> None:
        base = tube(12, 12)
        for values in (dict(base_cloth="HANG"), dict(layers="CLOTH"), dict(collision="NEIGHBOURHOOD"),
                       dict(offset_space="WORLD"), dict(rest_shape="ADAPTIVE")):
            settings = MeshSettings(**{"density": "LEVEL", "level": 1, **values})
            mesh = WrinkleMesh.build(base, settings)
            for frame in (1, 2):
                shown = solve_frame(mesh, float(frame), base.positions, settings, {}, start=1, for_preview=True,
                                    world_from_object=np.eye(3, dtype=np.float32))
                self.assertIsInstance(shown, FrameResult, values)


if __name__ == "__main__":
    unittest.main()
