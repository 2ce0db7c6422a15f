# SPDX-License-Identifier: GPL-3.0-or-later
"""Rest shapes that adapt: their frames are stored, replayed and jumped to as any others. Every system alike."""
from __future__ import annotations

import unittest
from dataclasses import replace
from typing import Any, Iterator

import numpy as np
import rumple_native as native
from rumple.core.frame.engine import FrameResult, Wrinkles
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings, reference_settings
from rumple.core.systems.wrinkle_field import WrinkleField
from rumple.core.systems.wrinkle_mesh import WrinkleMesh
from rumple.core.systems.wrinkle_paths import WrinklePaths
from support.frames import solve_frame
from support.meshes import compressed, tube

FRAMES = range(1, 13)
SYSTEMS = (
    (WrinkleMesh, MeshSettings(density="LEVEL", level=1, display_steps=0, rest_shape="ADAPTIVE")),
    (WrinkleField, FieldSettings(wavelength=0.03, rest_shape="ADAPTIVE")),
    (WrinklePaths, PathsSettings(width=0.01)),
)


class OnATube(unittest.TestCase):
    """A tube that is squeezed, and what reads of any system."""

    def setUp(self) -> None:
        self.base = tube(12, 12)
        self.clip = {f: compressed(self.base.positions, 1.0 - 0.04 * (f - 1)) for f in FRAMES}

    def solve(self, fine: Wrinkles, frame: float, settings: Any, rate: float = 30.0, start: int = 1) -> FrameResult:
        whole, part = int(frame), np.float32(frame % 1.0)
        pose = self.clip[whole] if part == 0 else (1 - part) * self.clip[whole] + part * self.clip[whole + 1]
        return solve_frame(fine, float(frame), pose, settings, {}, start=start, frame_rate=rate)

    def reference(self, fine: Wrinkles, frame: float) -> np.ndarray:
        state = fine.frame_cache.get(float(frame)).state
        return (state.arrays if isinstance(fine, WrinklePaths) else state.reference)["reference"]

    def put(self, fine: Any, frame: float, state: Any) -> None:
        """In place of a frame that was solved: a state as it is stored."""
        solved = (self.stored(fine.model, state), None)
        fine.frame_cache.put(frame, replace(fine.frame_cache.get(frame), final=True, _solved=solved))

    def stored(self, model: Any, state: Any) -> Any:
        if isinstance(state, native.WrinkleMeshState):
            return native.WrinkleMeshState(model, state.offset, state.solved_length, state.reference)
        if isinstance(state, native.WrinkleFieldState):
            return native.WrinkleFieldState(model, state.phase, state.direction, state.solved_offset, state.reference)
        return native.WrinklePathsState(model, state.arrays)

    def each(self) -> Iterator[Any]:
        for system, settings in SYSTEMS:
            with self.subTest(system.__name__):
                yield system, settings


class Effects(OnATube):
    """The panel of the Wrinkle Paths drew Relaxation, Growth and Time Window where they change nothing."""

    OTHER = dict(relaxation=0.5, growth=1.3, window=0.0)

    def pose(self, system: Any, frame: int) -> np.ndarray:
        """Paths are squeezed and then turned slowly; the others stretched and then squeezed: there Growth counts."""
        if system is not WrinklePaths:
            return compressed(self.base.positions, 1.0 + 0.05 * min(frame - 1, 5) - 0.12 * max(frame - 6, 0))
        turned = compressed(self.base.positions, 1.0 - 0.05 * min(frame - 1, 7))
        turned[:, 0] += 0.03 * max(frame - 6, 0) * turned[:, 2]
        return turned

    def played(self, system: Any, settings: Any) -> np.ndarray:
        fine, self.clip = system.build(self.base, settings), {frame: self.pose(system, frame) for frame in FRAMES}
        return np.stack([self.solve(fine, frame, settings).positions for frame in FRAMES])

    def test_panels_draw_what_has_an_effect(self) -> None:
        seen = set()
        for system, settings in self.each():
            settings = replace(settings, **(dict(threshold=1.1) if system is WrinklePaths else {}))
            for reference in ("REST", "FIRST_FRAME", *(("STATIC_REST",) if system is WrinklePaths else ())):
                for stateless in (False, True):
                    case = replace(settings, reference=reference, stateless=stateless)
                    expected, drawn = self.played(system, case), reference_settings(case)
                    for name, value in self.OTHER.items():
                        same = np.array_equal(self.played(system, replace(case, **{name: value})), expected)
                        self.assertTrue(same or name in drawn, (name, reference, stateless))
                        seen |= set() if same else {(system, reference, name)}
        # Cases where each can have one: among them the time window of paths that are measured against the rest shape.
        self.assertEqual({name for _, reference, name in seen if reference == "REST"}, set(self.OTHER))
        self.assertIn((WrinklePaths, "STATIC_REST", "window"), seen)


class Adapting(OnATube):
    def test_played_frames_replay_to_the_bit_in_any_order(self) -> None:
        for system, settings in self.each():
            fine = system.build(self.base, settings)
            played = {f: self.solve(fine, f, settings).positions for f in FRAMES}
            self.assertFalse(np.array_equal(self.reference(fine, 12), self.reference(fine, 1)))  # it has given in
            for frame in (5, 2, 12, 1, 7):
                picture = self.solve(fine, frame, settings)
                self.assertTrue(picture.replayed)
                np.testing.assert_array_equal(picture.positions, played[frame])
            half = self.solve(fine, 6.5, settings).positions
            np.testing.assert_array_equal(self.solve(fine, 7, settings).positions, played[7])  # and no frame after it
            np.testing.assert_array_equal(self.solve(fine, 6.5, settings).positions, half)

    def test_playing_through_does_not_know_what_was_jumped_to(self) -> None:
        for system, settings in self.each():
            fresh, other = system.build(self.base, settings), system.build(self.base, settings)
            for frame in (9, 4, 10, 5):
                self.solve(other, frame, settings)
            for f in FRAMES:
                np.testing.assert_array_equal(self.solve(fresh, f, settings).positions,
                                              self.solve(other, f, settings).positions)
                np.testing.assert_array_equal(self.reference(fresh, f), self.reference(other, f))

    def test_the_frame_rate_counts_where_the_rest_shape_adapts_and_nowhere_else(self) -> None:
        for system, settings in self.each():
            fine = system.build(self.base, settings)
            for f in FRAMES:
                self.solve(fine, f, settings)
            slow = self.reference(fine, 12)
            self.solve(fine, 5, settings, rate=60.0)  # elsewhere: what is stored is of other times now
            self.assertEqual(len(fine.frame_cache.frames()), 1)
            for f in FRAMES:
                self.solve(fine, f, settings, rate=60.0)
            self.assertGreater(np.abs(self.reference(fine, 12) - slow).max(), 1e-6)
        for system, settings in SYSTEMS[:2]:
            still = replace(settings, rest_shape="REST_POSE")
            fine = system.build(self.base, still)
            for f in FRAMES:
                self.solve(fine, f, still)
            self.assertTrue(self.solve(fine, 5, still, rate=60.0).replayed)

    def test_without_a_rest_pose_the_first_frame_is_unwrinkled(self) -> None:
        for system, settings in self.each():
            free = replace(settings, reference="FIRST_FRAME")
            fine = system.build(self.base, free)
            begun, folded = self.solve(fine, 8, free, start=8), self.solve(fine, 8, settings, start=8)
            self.assertLess(np.abs(begun.offset).max(), 0.1 * np.abs(folded.offset).max() + 1e-9)
            for f in (9, 10, 11, 12):
                later = self.solve(fine, f, free, start=8)
            self.assertTrue(np.isfinite(later.positions).all())

    def test_independent_frames_are_measured_against_the_rest_pose(self) -> None:
        for system, settings in self.each():
            alone = replace(settings, stateless=True, reference="FIRST_FRAME")
            fine = system.build(self.base, alone)
            backwards = {f: self.solve(fine, f, alone).positions for f in reversed(FRAMES)}
            still = replace(alone, reference="STATIC_REST") if system is WrinklePaths else replace(
                alone, rest_shape="REST_POSE")
            other = system.build(self.base, still)
            for f in FRAMES:
                np.testing.assert_array_equal(self.solve(other, f, still).positions, backwards[f])

    def test_a_stored_state_continues_as_the_one_that_was_stored(self) -> None:
        for system, settings in self.each():
            fine = system.build(self.base, settings)
            for f in range(1, 8):
                self.solve(fine, f, settings)
            entry = fine.frame_cache.get(6.0)
            expected = self.solve(fine, 7, settings).positions
            other = system.build(self.base, settings)
            self.solve(other, 6, settings)
            self.put(other, 6.0, entry.state)
            np.testing.assert_array_equal(self.solve(other, 7, settings).positions, expected)
            self.assertGreater(entry.state.nbytes, self.clip[1].nbytes)

    def test_a_spoiled_reference_is_named(self) -> None:
        settings = SYSTEMS[0][1]
        fine = WrinkleMesh.build(self.base, settings)
        self.solve(fine, 1, settings)
        state = fine.frame_cache.get(1.0).state
        good = state.reference
        for name, value in (("labels", good["labels"].astype(np.int32)), ("reference", good["reference"][:, :2]),
                            ("past_times", good["past_times"][None])):
            with self.assertRaisesRegex(ValueError, name):
                native.WrinkleMeshState(fine.model, state.offset, state.solved_length, {**good, name: value})
        with self.assertRaisesRegex(ValueError, "past_positions"):
            native.WrinkleMeshState(fine.model, state.offset, state.solved_length,
                                    {k: v for k, v in good.items() if k != "past_positions"})


class SeeingAhead(OnATube):
    """A whole clip, or one frame ahead."""

    def by_hand(self, fine: Wrinkles, settings: Any, labels: np.ndarray | None, ahead: bool = False) -> list[Any]:
        """The states of all frames, solved with the native module alone."""
        solve = {WrinkleMesh: native.solve_wrinkle_mesh, WrinkleField: native.solve_wrinkle_field,
                 WrinklePaths: native.solve_wrinkle_paths}[type(fine)]
        state, states = None, []
        for f in FRAMES:
            following = self.clip.get(f + 1) if ahead else None
            more = {} if following is None else dict(next_positions=following, next_time=(f + 1) / 30.0)
            state, _ = solve(fine.model, fine._native_settings(settings), fine._take_paint({}), self.clip[f],
                             state=state, time=f / 30.0, labels=None if labels is None else labels[f - 1], **more)
            states.append(state)
        return states

    def labels(self, fine: Wrinkles, settings: Any) -> np.ndarray:
        return native.label_clip(fine.model, fine._native_settings(settings), np.array(FRAMES) / 30.0,
                                 np.concatenate([self.clip[f] for f in FRAMES]))

    def look(self, fine: Wrinkles, settings: Any) -> None:
        fine.analyze_clip({float(f): self.clip[f] for f in FRAMES}, settings, frame_rate=30.0)

    def state_arrays(self, fine: Wrinkles, state: Any) -> dict[str, np.ndarray]:
        if isinstance(fine, WrinklePaths):
            return state.arrays
        return {**state.reference, **({"offset": state.offset} if isinstance(fine, WrinkleMesh) else
                                      {"phase": state.phase})}

    def assert_same(self, fine: Wrinkles, one: Any, two: Any) -> None:
        two = self.state_arrays(fine, two)
        for name, values in self.state_arrays(fine, one).items():
            np.testing.assert_array_equal(values, two[name], err_msg=name)

    def setUp(self) -> None:
        super().setUp()
        # Squeezed faster and faster from one end to the other: live labels are late.
        z = self.base.positions[:, 2] / self.base.positions[:, 2].max()
        for f in FRAMES:
            share = np.clip(0.12 * (f - 1) - 0.6 * z, 0.0, 1.0)[:, None].astype(np.float32)
            self.clip[f] = ((1 - share) * self.base.positions + share * compressed(self.base.positions, 0.7)).astype(
                np.float32)

    def test_a_clip_that_was_looked_at_is_solved_with_its_labels(self) -> None:
        for system, settings in self.each():
            fine = system.build(self.base, settings)
            live = self.by_hand(fine, settings, None)
            expected = self.by_hand(fine, settings, self.labels(fine, settings))
            self.look(fine, settings)
            for f in FRAMES:
                self.solve(fine, f, settings)
                self.assert_same(fine, fine.frame_cache.get(float(f)).state, expected[f - 1])
            self.assertEqual(fine.pose_mismatches, set())
            self.assertFalse(np.array_equal(self.reference(fine, 12), self.state_arrays(fine, live[-1])["reference"]))
            fine.analyze_clip({}, settings)
            self.assertEqual(fine.frame_cache.frames(), [])
            for f in FRAMES:
                self.solve(fine, f, settings)
                self.assert_same(fine, fine.frame_cache.get(float(f)).state, live[f - 1])

    def test_a_changed_frame_is_solved_as_live(self) -> None:
        for system, settings in self.each():
            fine = system.build(self.base, settings)
            self.look(fine, settings)
            self.clip[5] = np.float32(1.001) * self.clip[5]
            for f in FRAMES:
                self.solve(fine, f, settings)
            self.assertEqual(fine.pose_mismatches, {5.0})
            labels = self.labels(fine, settings)
            state = fine.frame_cache.get(5.0).state
            found = (state.arrays if system is WrinklePaths else state.reference)["labels"]
            before = fine.frame_cache.get(4.0).state
            alone = system.build(self.base, settings)
            self.solve(alone, 4, settings)
            self.put(alone, 4.0, before)
            self.solve(alone, 5, settings)
            live = alone.frame_cache.get(5.0).state
            np.testing.assert_array_equal(found, (live.arrays if system is WrinklePaths else live.reference)["labels"])
            self.assertEqual(found.shape, labels[0].shape)

    def test_a_frame_that_comes_right_in_a_second_pass_has_its_labels(self) -> None:
        """As with an object that follows another wrinkled one."""
        for system, settings in self.each():
            fine = system.build(self.base, settings)
            expected = self.by_hand(fine, settings, self.labels(fine, settings))
            self.look(fine, settings)
            for f in FRAMES:
                solve_frame(fine, float(f), self.clip[max(f - 1, 1)], settings, {}, start=1, frame_rate=30.0)
                self.solve(fine, f, settings)
                self.assert_same(fine, fine.frame_cache.get(float(f)).state, expected[f - 1])
            self.assertEqual(fine.pose_mismatches, set())

    def test_a_subframe_goes_by_the_frame_it_leads_to_and_changes_none(self) -> None:
        for system, settings in self.each():
            fine, other = system.build(self.base, settings), system.build(self.base, settings)
            labels = self.labels(fine, settings)
            for one in (fine, other):
                self.look(one, settings)
            for f in FRAMES[:-1]:
                self.solve(fine, f, settings)
                self.solve(fine, f + 0.5, settings)
                state = fine.frame_cache.get(f + 0.5).state
                found = (state.arrays if system is WrinklePaths else state.reference)["labels"]
                np.testing.assert_array_equal(found, labels[f])
                self.solve(other, f, settings)
                self.assert_same(fine, fine.frame_cache.get(float(f)).state, other.frame_cache.get(float(f)).state)

    def test_one_frame_of_look_ahead(self) -> None:
        for system, settings in self.each():
            fine = system.build(self.base, settings)
            live, ahead = self.by_hand(fine, settings, None), self.by_hand(fine, settings, None, ahead=True)
            self.assertTrue(any(not np.array_equal(self.state_arrays(fine, a)["labels"], self.state_arrays(
                fine, b)["labels"]) for a, b in zip(live, ahead)))

    def test_a_rest_shape_that_stays_sees_nothing(self) -> None:
        for system, settings in SYSTEMS[:2]:
            still = replace(settings, rest_shape="REST_POSE")
            fine = system.build(self.base, still)
            self.look(fine, still)
            seen = self.solve(fine, 3, still, start=3).positions
            fine.analyze_clip({}, still)
            np.testing.assert_array_equal(self.solve(fine, 3, still, start=3).positions, seen)
