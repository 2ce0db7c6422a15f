# SPDX-License-Identifier: GPL-3.0-or-later
"""Random steps with Wrinkle Maps end with no crash and the right masks."""
from __future__ import annotations

import tempfile
import unittest
from support import maps_walk, random_walk


class MapsWalk(unittest.TestCase):

    def test_many_steps(self) -> None:
        for seed in random_walk.seeds(1):
            with tempfile.TemporaryDirectory() as folder:
                for _ in maps_walk.Walk(seed, folder).steps(100):
                    pass
