# SPDX-License-Identifier: GPL-3.0-or-later
"""The last result of a function is used again for equal arguments only."""
from __future__ import annotations

import unittest
from typing import Any

import numpy as np
from rumple.core.base.last_result import LastResult
from rumple.core.settings.system_settings import MeshSettings


class Last(unittest.TestCase):

    def setUp(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self.last = LastResult(self.called)

    def called(self, *arguments: Any) -> int:
        self.calls.append(arguments)
        return len(self.calls)

    def test_equal_arguments_call_it_once(self) -> None:
        for _ in range(3):
            self.assertEqual(self.last(MeshSettings(gravity=0.5), np.eye(3), None, 2), 1)

    def test_arguments_that_their_owner_changes_are_others(self) -> None:
        settings, matrix = MeshSettings(), np.eye(3)
        self.assertEqual(self.last(settings, matrix), 1)
        settings.gravity = 0.25
        self.assertEqual(self.last(settings, matrix), 2)
        matrix[0, 1] = 1e-7
        self.assertEqual(self.last(settings, matrix), 3)
        self.assertEqual(self.last(settings, None), 4)
        self.assertEqual(self.last(settings, matrix), 5)

    def test_numbers_of_another_type_are_others(self) -> None:
        self.assertEqual([self.last(1), self.last(1.0), self.last(True), self.last(True)], [1, 2, 3, 3])
