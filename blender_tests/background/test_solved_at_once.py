# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments that are not worn over one another are solved at the same time: each has its own bits and errors."""
from __future__ import annotations

import threading
import unittest
from types import FrameType
from typing import Any, Iterator
from unittest import mock

import bpy
import numpy as np
from rumple.blender.frame import garment_frame
from rumple.blender.objects import bodies, modifier, runtimes
from rumple.core.base import at_once
from rumple.core.base.wording import UserError
from rumple.core.frame import engine
from support import sleeve
from support.cloth_scenes import hang

PEOPLE, LAST = 3, 6
Pictures = dict[str, list[np.ndarray]]  # positions of all frames, by garment


def in_turn(calls: list) -> None:
    for call in calls:
        call()


def on(processors: int) -> Any:
    return mock.patch.object(at_once, "_processors", return_value=processors)


def people() -> None:
    """Arms in two sleeves each, one over the other. By their names the outer ones come first."""
    body = sleeve.skinned(sleeve.tube("Body"), bpy.data.objects["Arm"], "Body")
    for vertex in body.data.vertices:
        vertex.co.yz *= 0.7
    for number in range(PEOPLE):
        inner, outer = (sleeve.skinned(sleeve.tube(name), bpy.data.objects["Arm"], name)
                        for name in (f"Under {number}", f"Over {number}"))
        for vertex in inner.data.vertices:
            vertex.co.yz *= 0.85 + 0.01 * number  # no two are the same
        for obj, under in ((inner, body), (outer, inner)):
            hang(obj, room=0.02)
            obj.rumple.body, obj.rumple.body_collection = under, None
    bpy.context.view_layer.update()


class AtOnce(unittest.TestCase):
    def setUp(self) -> None:
        sleeve.empty_file()
        sleeve.arm()
        sleeve.bend_until(LAST)
        people()
        sleeve.at(0)
        self.garments = [obj for obj, _ours in modifier.wrinkled_objects()]
        self.assertEqual(len(self.garments), 2 * PEOPLE)
        self.solved: list[tuple[str, bool]] = []  # names, and whether in the thread that Blender calls
        finish = engine.Wrinkles.finish_frame

        def noted(fine: engine.Wrinkles, found: Any) -> Any:
            self.solved.append((fine.name, threading.current_thread() is threading.main_thread()))
            return finish(fine, found)

        self.enterContext(mock.patch.object(engine.Wrinkles, "finish_frame", noted))

    def forget(self) -> None:
        for obj in self.garments:
            runtimes.of(obj).evaluator.frame_cache.clear()
            runtimes.of(obj).forget_inputs()
        self.solved.clear()

    def played(self, forget: bool = True) -> Pictures:
        if forget:
            self.forget()
        found: Pictures = {obj.name: [] for obj in self.garments}
        for frame in range(1, LAST + 1):
            sleeve.at(frame)
            for obj in self.garments:
                found[obj.name].append(np.concatenate([sleeve.shown(obj), sleeve.picture(obj).positions]))
        return found

    def same(self, one: Pictures, other: Pictures, but: str = "") -> None:
        self.assertEqual(one.keys(), other.keys())
        for name in one.keys() - {but}:
            for frame, (positions, expected) in enumerate(zip(one[name], other[name], strict=True), 1):
                np.testing.assert_array_equal(positions, expected, f"{name}, frame {frame}")

    def test_the_bits_are_those_of_one_at_a_time(self) -> None:
        with mock.patch.object(garment_frame, "call_at_once", in_turn):
            alone = self.played()
        self.assertEqual({here for _name, here in self.solved}, {True})
        for processors in (2, 3, 8):
            with on(processors):
                self.same(alone, self.played())
            self.assertIn(False, {here for _name, here in self.solved})
        moved = max(float(np.abs(pictures[-1] - pictures[0]).max()) for pictures in alone.values())
        self.assertGreater(moved, 0.05)

    def test_what_is_worn_under_another_is_solved_before_it(self) -> None:
        with on(8):
            self.played()
        order = [name for name, _here in self.solved]
        self.assertEqual(len(order), 2 * PEOPLE * LAST)
        for frame in range(LAST):
            now = order[2 * PEOPLE * frame:2 * PEOPLE * (frame + 1)]
            self.assertEqual({name.split()[0] for name in now[:PEOPLE]}, {"Under"})
            self.assertEqual({name.split()[0] for name in now[PEOPLE:]}, {"Over"})

    def test_it_is_solved_over_the_surface_of_the_same_frame(self) -> None:
        with on(8):
            for frame in range(1, LAST + 1):
                sleeve.at(frame)
                for number in range(PEOPLE):
                    under = runtimes.of(bpy.data.objects[f"Under {number}"])
                    over = runtimes.of(bpy.data.objects[f"Over {number}"])
                    inputs = under.inputs
                    surface = under.evaluator.worn_surface(float(frame), inputs.positions, inputs.settings)
                    np.testing.assert_allclose(over.inputs.body.positions, surface.positions, atol=1e-6)

    def test_an_error_is_that_of_its_garment_alone(self) -> None:
        with mock.patch.object(garment_frame, "call_at_once", in_turn):
            alone = self.played()
        self.forget()
        wrong = bpy.data.objects["Over 1"]
        for error, words in ((UserError("on purpose"), "on purpose"), (MemoryError(), "not enough memory"),
                             (ZeroDivisionError("a fault"), "ZeroDivisionError in ")):
            with on(8), mock.patch.object(runtimes.of(wrong).evaluator, "finish_frame", side_effect=error):
                found = self.played()
            self.same(alone, found, wrong.name)
            self.assertIn(words, runtimes.message(wrong))
            self.assertEqual([obj for obj in self.garments if runtimes.message(obj)], [wrong])
        with on(8):
            self.same(alone, self.played())
        self.assertEqual(runtimes.message(wrong), "")

    def test_without_the_one_under_it_a_garment_is_solved_over_what_is_animated(self) -> None:
        with on(8), mock.patch.object(runtimes.of(bpy.data.objects["Under 1"]).evaluator, "finish_frame",
                                      side_effect=UserError("on purpose")):
            self.played()
        self.assertEqual([obj.name for obj in self.garments if runtimes.message(obj)], ["Under 1"])

    def test_other_threads_run_nothing_that_uses_blender(self) -> None:
        called: set[str] = set()

        def note(frame: FrameType, event: str, _argument: object) -> None:
            if event == "call":
                called.add(frame.f_globals.get("__name__", ""))

        threading.setprofile(note)
        self.addCleanup(threading.setprofile, None)
        with on(8):
            self.played()
        self.assertIn("rumple.core.frame.engine", called)
        self.assertEqual({name for name in called if name.startswith(("rumple.blender", "bpy"))},
                         {"rumple.blender.frame.garment_frame"})

    def test_stored_frames_and_one_garment_alone_take_no_thread(self) -> None:
        with on(8), mock.patch.object(threading, "Thread", wraps=threading.Thread) as threads:
            shown = self.played()
            self.assertGreater(threads.call_count, 0)
            threads.reset_mock()
            self.same(shown, self.played(forget=False))
            for obj in self.garments[1:]:
                bpy.data.objects.remove(obj)
            self.garments = self.garments[:1]
            self.played()
            threads.assert_not_called()


class Levels(unittest.TestCase):
    def setUp(self) -> None:
        sleeve.scene()
        for name in "ABC":
            sleeve.another(name)

    def worn(self, *pairs: str) -> None:
        """Which one is worn over which one."""
        for pair in pairs:
            bpy.data.objects[pair[0]].rumple.body = bpy.data.objects[pair[1]]

    def levels(self) -> list[str]:
        self.wrinkled = list(modifier.wrinkled_objects())
        return ["".join(obj.name[0] for obj, _ours in level) for level in bodies.in_levels(self.wrinkled)]

    def flat(self) -> Iterator[str]:
        return (obj.name[0] for obj, _ours in bodies.in_order(self.wrinkled))

    def test_each_is_in_the_level_after_the_highest_under_it(self) -> None:
        for pairs, expected, order in (((), ["ABCS"], "ABCS"), (("AB",), ["BCS", "A"], "BACS"),
                                       (("BC",), ["CS", "B", "A"], "CBAS")):
            self.worn(*pairs)
            self.assertEqual(self.levels(), expected)
            self.assertEqual("".join(self.flat()), order)

    def test_a_circle_ends(self) -> None:
        self.worn("AB", "BC", "CA")
        self.assertEqual(sorted("".join(self.levels())), list("ABCS"))
        self.assertEqual(sorted(self.flat()), list("ABCS"))
        self.assertEqual(bodies.in_levels([]), [])


if __name__ == "__main__":
    unittest.main()
