# SPDX-License-Identifier: GPL-3.0-or-later
"""What is submitted to a queue, and in which order."""
from __future__ import annotations

import argparse
import random
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import farm_jobs  # noqa: E402
from farm_jobs import Cut, Refused, Task  # noqa: E402


def task(number: int, *needs: int, frames: int = 10, size: int = 0) -> Task:
    return Task(number, "shot.blend", f"g{number}", list(needs), frames, size)


class Order(unittest.TestCase):

    def order(self, tasks: list[Task]) -> list[int]:
        """In which they begin where one worker takes them all; each array behind those that it waits for."""
        done: list[int] = []
        for array in farm_jobs._arrays(tasks):
            self.assertLessEqual(len(array.tasks), farm_jobs.MOST_IN_ARRAY)
            for number in array.tasks:
                self.assertEqual(sorted(tasks[number].needs), array.needs)
            self.assertLessEqual(set(array.needs), set(done))
            done += array.tasks
        self.assertEqual(sorted(done), [one.number for one in tasks])
        return done

    def test_each_is_once_behind_what_it_waits_for(self) -> None:
        chance = random.Random(1)
        for size in (1, 7, 300, 2500):
            tasks: list[Task] = []
            for number in range(size):
                needs = {chance.randrange(max(number - 9, 0), number) for _ in range(chance.choice((0, 0, 0, 1, 2)))
                         if number}
                tasks.append(task(number, *needs, frames=chance.randrange(3), size=chance.randrange(3)))
            self.order(tasks)

    def test_what_others_rest_on_and_long_ones_are_first(self) -> None:
        self.assertEqual(self.order([task(0, frames=10), task(1, frames=5), task(2, frames=20), task(3, 1, frames=40)]),
                         [1, 2, 0, 3])
        # By bytes, where all are known: a garment of many points is slower than one of few.
        self.assertEqual(self.order([task(0, frames=9, size=1), task(1, frames=1, size=9)]), [1, 0])
        self.assertEqual(self.order([task(0, frames=9, size=1), task(1, frames=1, size=0)]), [0, 1])

    def test_what_rests_on_others_comes_before_what_is_short(self) -> None:
        """A queue starts arrays in the order in which they are submitted: in one array all that waits for nothing would
        begin before all that rests on it."""
        tasks = [task(number, frames=1 + number) for number in range(200)]
        tasks.append(task(200, 199, frames=150))
        order = self.order(tasks)
        self.assertEqual(order[0], 199)
        self.assertLess(order.index(200), order.index(20))


class Pieces(unittest.TestCase):

    def cut(self, **chosen: object) -> Cut:
        return Cut.of(argparse.Namespace(**chosen))

    def test_all_pieces_are_before_their_joining(self) -> None:
        whole = task(0, 4, frames=41, size=410)
        found = self.cut(pieces=4, pre_roll=0, tolerance=None).tasks(whole, "independent", 40, 7)
        self.assertEqual([one.number for one in found], [7, 8, 9, 10, 11])
        self.assertEqual([one.words for one in found], [[f"--piece={k}/4"] for k in (1, 2, 3, 4)] + [["--join=4"]])
        self.assertEqual([one.needs for one in found], [[4]] * 4 + [[7, 8, 9, 10]])
        self.assertEqual(found[0].name, "g0 1/4")
        self.assertEqual(found[-1].name, "g0")

    def test_only_what_may_be_cut_is_cut(self) -> None:
        plain, rolled = self.cut(pieces=4), self.cut(pieces=4, pre_roll=5, tolerance=1e-3)
        for cut, kind, frames, count in ((plain, "independent", 40, 5), (plain, "pre-roll", 40, 1), (plain, "", 40, 1),
                                         (rolled, "independent", 40, 5), (rolled, "pre-roll", 40, 5),
                                         (rolled, "", 40, 1), (plain, "independent", 2, 3),
                                         (plain, "independent", 1, 1), (plain, "independent", 0, 1),
                                         (self.cut(), "independent", 40, 1)):
            self.assertEqual(len(cut.tasks(task(0), kind, frames, 0)), count)
        self.assertEqual(rolled.tasks(task(0), "pre-roll", 9, 0)[0].words,
                         ["--piece=1/4", "--pre-roll=5", "--tolerance=0.001"])

    def test_words_that_cannot_be_followed(self) -> None:
        for words in (dict(pieces=0), dict(pieces=1001), dict(pieces=2, pre_roll=-1), dict(pieces=2, pre_roll=1),
                      dict(pieces=2, tolerance=1.0), dict(pieces=1, pre_roll=1, tolerance=1.0)):
            self.assertRaises(Refused, self.cut, **words)
