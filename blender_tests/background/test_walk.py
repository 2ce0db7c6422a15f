# SPDX-License-Identifier: GPL-3.0-or-later
"""Random steps end with no crash, no lost paint, and the right mesh."""
from __future__ import annotations

import tempfile
import unittest
from support import file_walk, garment_walk, random_walk


class RandomWalk(unittest.TestCase):

    def test_many_steps(self) -> None:
        for seed in random_walk.seeds(1):
            with tempfile.TemporaryDirectory() as folder:
                for _ in garment_walk.Walk(seed, folder).steps(100):
                    pass

    def test_between_scenes_and_files(self) -> None:
        for seed in random_walk.seeds(1):
            with tempfile.TemporaryDirectory() as folder:
                for _ in file_walk.Walk(seed, folder).steps(60):
                    pass
