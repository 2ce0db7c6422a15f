# SPDX-License-Identifier: GPL-3.0-or-later
"""Laws of what is called at the same time: nothing is left out, and whatever is solved has the bits of its own."""
from __future__ import annotations

import threading
import unittest
from typing import Any
from unittest import mock

import numpy as np
from rumple.core.base import at_once
from rumple.core.base.at_once import call_at_once
from rumple.core.base.wording import UserError
from rumple.core.frame.engine import FrameResult, Wrinkles
from rumple.core.frame.frame_input import FrameRequest
from rumple.core.settings.system_settings import FieldSettings, MeshSettings, PathsSettings
from rumple.core.systems.all_systems import SYSTEMS
from support.frames import solve_frame
from support.meshes import compressed, tube

FRAMES = range(1, 6)
PATIENCE = 10.0  # seconds until a thread that waits for another gives up
CLOTH = dict(base_cloth="HANG", room=0.02, thickness=0.002)
GARMENTS: list[tuple[str, Any]] = [
    ("MESH", MeshSettings(density="LEVEL", level=2)), ("MESH", MeshSettings(density="LEVEL", level=2, **CLOTH)),
    ("FIELD", FieldSettings(output="GEOMETRY", wavelength=0.05, detail=4)),
    ("FIELD", FieldSettings(wavelength=0.06, irregularity=0.3, **CLOTH)),
    ("PATHS", PathsSettings(width=0.02, detail=2, threshold=1.1, smoothing=0.0))]


def on(processors: int) -> Any:
    return mock.patch.object(at_once, "_processors", return_value=processors)


class Calls(unittest.TestCase):
    def test_every_one_is_called_once_on_any_number_of_threads(self) -> None:
        for processors in (1, 2, 3, 16):
            for count in (0, 1, 2, 7):
                called: list[int] = []
                with on(processors):
                    call_at_once([lambda number=number: called.append(number) for number in range(count)])
                self.assertEqual(sorted(called), list(range(count)))

    def test_they_are_called_at_the_same_time(self) -> None:
        meeting = threading.Barrier(3)
        with on(3):
            call_at_once([lambda: meeting.wait(PATIENCE) and None] * 3)
        self.assertFalse(meeting.broken)

    def test_one_alone_and_those_of_one_processor_take_no_thread(self) -> None:
        for processors, count in ((8, 0), (8, 1), (1, 3)):
            called: list[int] = []
            with on(processors), mock.patch.object(threading, "Thread") as threads:
                call_at_once([lambda number=number: called.append(number) for number in range(count)])
            self.assertEqual(called, list(range(count)))
            threads.assert_not_called()

    def test_where_the_system_gives_no_thread_this_one_calls_all(self) -> None:
        called: list[int] = []
        with on(4), mock.patch.object(threading.Thread, "start", side_effect=RuntimeError("no more threads")):
            call_at_once([lambda number=number: called.append(number) for number in range(4)])
        self.assertEqual(called, [0, 1, 2, 3])


class Solved(unittest.TestCase):
    def setUp(self) -> None:
        self.base = tube(16, 14)
        self.clip = {f: compressed(self.base.positions, 1.0 - 0.06 * (f - 1)) for f in FRAMES}

    def built(self) -> list[Wrinkles]:
        return [SYSTEMS[method].wrinkles.build(self.base, settings) for method, settings in GARMENTS]

    def request(self, number: int, frame: int, **more: Any) -> FrameRequest:
        return FrameRequest(float(frame), self.clip[frame], GARMENTS[number][1], {}, 1, np.eye(3, dtype=np.float32),
                            **more)

    def played(self, processors: int, order: int = 1) -> list[FrameResult]:
        """All frames of all garments, by frame. order: -1 begins with the last garment."""
        garments, found = self.built(), []
        for frame in FRAMES:
            looked_up = [one.find_frame(self.request(number, frame)) for number, one in enumerate(garments)]
            results: dict[int, Any] = {}

            def solve(number: int) -> None:
                results[number] = garments[number].finish_frame(looked_up[number])

            with on(processors):
                call_at_once([lambda number=number: solve(number) for number in range(len(garments))][::order])
            found += [results[number] for number in range(len(garments))]
        return found

    def test_whatever_is_solved_beside_it_a_frame_has_the_same_bits(self) -> None:
        alone = self.played(1)
        for processors, order in ((1, -1), (2, 1), (3, -1), (8, 1)):
            for one, other in zip(alone, self.played(processors, order), strict=True):
                self.assertFalse(other.replayed)
                self.assertTrue(one.shows_the_same(other))
                np.testing.assert_array_equal(one.positions, other.positions)

    def test_a_frame_in_two_halves_is_that_of_one_call(self) -> None:
        for number, (whole, halves) in enumerate(zip(self.built(), self.built())):
            for frame in FRAMES:
                one = solve_frame(whole, float(frame), self.clip[frame], GARMENTS[number][1], {}, start=1,
                                  world_from_object=np.eye(3, dtype=np.float32))
                other = halves.finish_frame(halves.find_frame(self.request(number, frame)))
                self.assertTrue(one.shows_the_same(other))
            self.assertEqual(whole.frame_cache.frames(), halves.frame_cache.frames())

    def test_only_what_is_not_stored_must_be_solved(self) -> None:
        for number, fine in enumerate(self.built()):
            for must_be_solved in (True, False):
                found = fine.find_frame(self.request(number, 1))
                self.assertEqual(found.must_be_solved, must_be_solved)
                self.assertEqual(fine.finish_frame(found).replayed, not must_be_solved)

    def test_a_frame_that_waits_is_quickly_made_until_somebody_asks_for_it(self) -> None:
        settings = FieldSettings(wavelength=0.06)
        field = SYSTEMS["FIELD"].wrinkles.build(self.base, settings)

        def found(frame: int, for_preview: bool) -> Any:
            return field.find_frame(FrameRequest(float(frame), self.clip[frame], settings, {}, 1,
                                                 for_preview=for_preview))

        field.finish_frame(found(1, True))
        self.assertFalse(found(2, True).must_be_solved)
        field.finish_frame(found(2, True))
        self.assertFalse(found(2, True).must_be_solved)
        self.assertTrue(found(2, False).must_be_solved)

    def test_a_wild_frame_is_refused_in_either_half_and_the_next_one_goes_on(self) -> None:
        for number, fine in enumerate(self.built()):
            fine.finish_frame(fine.find_frame(self.request(number, 1)))
            good, self.clip[2] = self.clip[2], self.clip[2] + np.float32(1e14)
            with self.assertRaisesRegex(UserError, "in this frame"):
                fine.finish_frame(fine.find_frame(self.request(number, 2)))
            self.clip[2] = good
            found = fine.find_frame(self.request(number, 3))
            self.assertTrue(found.final)
            self.assertIs(found.before, fine.frame_cache.get(1.0))


if __name__ == "__main__":
    unittest.main()
