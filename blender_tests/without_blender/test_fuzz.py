# SPDX-License-Identifier: GPL-3.0-or-later
"""What the fuzzer of the C header (native/fuzz) promises of itself; scripts/suite fuzz runs it."""
from __future__ import annotations

import re
import tarfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT / "native/fuzz/corpus.tar.gz"


def exported() -> set[str]:
    """The functions of the header."""
    return {name for header in (ROOT / "native/include/rumple").glob("*.h")
            for name in re.findall(r"RUMPLE_API [^(;]*\b(rumple_\w+)\(", header.read_text())}


class Fuzzer(unittest.TestCase):
    def test_every_function_of_the_header_is_called(self) -> None:
        """That each gets an answer, too, is held when it runs."""
        code = "\n".join(file.read_text() for file in (ROOT / "native/fuzz").glob("*.cpp"))
        pools = (ROOT / "native/fuzz/world.h").read_text()
        called = set(re.findall(r"\b(?:CALL|RUN)\(\s*(rumple_\w+)", code))
        called |= set(re.findall(r"\bMAKE\(\s*rumple_\w+,\s*(rumple_\w+)", code))
        called |= {f"{handle}_free" for handle in re.findall(r"RUMPLE_POOL\((rumple_\w+),", pools)}
        self.assertGreater(len(exported()), 150)
        self.assertEqual(exported() - called, set())
        self.assertEqual(called - exported(), set())

    def test_what_is_kept_is_small(self) -> None:
        self.assertLess(CORPUS.stat().st_size, 1 << 20)
        with tarfile.open(CORPUS) as kept:
            inputs = [entry for entry in kept.getmembers() if entry.isfile()]
        self.assertGreater(len(inputs), 100)
        self.assertLessEqual(max(entry.size for entry in inputs), 1000)


if __name__ == "__main__":
    unittest.main()
