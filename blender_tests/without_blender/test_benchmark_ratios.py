# SPDX-License-Identifier: GPL-3.0-or-later
"""What scripts/benchmark_ratios.py says of numbers: nothing is timed here."""
from __future__ import annotations

import json
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.append(str(SCRIPTS))
import benchmark_ratios  # noqa: E402


class Fallen(unittest.TestCase):
    def test_more_than_a_fifth_less_is_said(self) -> None:
        now, stored = dict(a=7.9, b=8.1, c=30.0), dict(a=10.0, b=10.0, c=10.0)
        lines, fallen = benchmark_ratios.compare(now, stored)
        self.assertEqual([line.split(":")[0] for line in fallen], ["a"])
        self.assertEqual([line.split()[0] for line in lines if line.endswith("FELL")], ["a"])

    def test_what_is_measured_or_stored_alone_is_named_and_did_not_fall(self) -> None:
        lines, fallen = benchmark_ratios.compare(dict(a=1.0, new=1.0), dict(a=1.0, old=9.0))
        self.assertEqual(fallen, [])
        self.assertEqual([line.split()[0] for line in lines[1:]], ["a", "new", "old"])
        self.assertTrue(lines[2].endswith("new") and lines[3].endswith("not measured here"), lines)


class Store(unittest.TestCase):
    def test_the_stored_ratios_can_be_read(self) -> None:
        self.assertGreaterEqual(len(benchmark_ratios.read_store(benchmark_ratios.STORE)), 7)

    def test_a_store_that_is_missing_or_damaged_is_an_error(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "ratios.json"
            with self.assertRaises(benchmark_ratios.StoreError):
                benchmark_ratios.read_store(path)
            path.write_text(json.dumps(dict(a=2.0)))
            self.assertEqual(benchmark_ratios.read_store(path), dict(a=2.0))
            for damaged in ("", '{"a": 2.0', "[2.0]", "{}", '{"a": 0}', '{"a": NaN}', '{"a": "2"}', '{"a": true}'):
                with self.subTest(damaged):
                    path.write_text(damaged)
                    with self.assertRaises(benchmark_ratios.StoreError):
                        benchmark_ratios.read_store(path)
