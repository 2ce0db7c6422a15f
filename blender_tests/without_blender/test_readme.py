# SPDX-License-Identifier: GPL-3.0-or-later
"""What the README promises."""
from __future__ import annotations

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class Readme(unittest.TestCase):
    def test_its_example_runs_and_wrinkles(self) -> None:
        code = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S).group(1)
        names: dict = {}
        exec(code, names)
        self.assertEqual(names["wrinkled"].shape, (4225, 3))
        self.assertGreater(abs(names["wrinkled"][:, 2]).max(), 0.01)
        self.assertLess(names["report"].error_after, names["report"].error_before)

    def test_every_picture_and_page_it_and_the_docs_name_is_there(self) -> None:
        for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
            for target in re.findall(r"\]\(([\w./-]+)\)", page.read_text(encoding="utf-8")):
                self.assertTrue((page.parent / target).is_file(), f"{page.name} names {target}")


if __name__ == "__main__":
    unittest.main()
