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

    def test_every_picture_page_and_heading_it_and_the_docs_name_is_there(self) -> None:
        links = headings = 0
        for page in [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]:
            for target, _, anchor in links_of(page):
                file = page.parent / target if target else page
                self.assertTrue(file.exists(), f"{page.relative_to(ROOT)} names {target}")
                links += 1
                if anchor:
                    self.assertIn(anchor, anchors(file), f"{page.relative_to(ROOT)} names {target}#{anchor}")
                    headings += 1
        self.assertGreater(links, 200)
        self.assertGreater(headings, 20)

    def test_links_and_anchors_are_found(self) -> None:
        """Links with an anchor were passed over, and the folders below docs/."""
        self.assertIn(("docs/lessons/first_wrinkles.md", "", ""), links_of(ROOT / "README.md"))
        self.assertIn(("../user_guide.md", "#", "bake"), links_of(ROOT / "docs" / "lessons" / "bake.md"))
        self.assertIn("what-is-built-and-what-has-run", anchors(ROOT / "docs" / "platforms.md"))
        self.assertNotIn("what", anchors(ROOT / "docs" / "platforms.md"))


def links_of(page: Path) -> list[tuple[str, str, str]]:
    """(file, # or nothing, anchor) of those within this tree."""
    targets = re.findall(r"\]\(([^)\s]+)\)", without_code(page))
    return [target.partition("#") for target in targets if not re.match(r"[a-z]+:", target)]


def anchors(page: Path) -> set[str]:
    """Of the headings of a page: as GitHub makes them."""
    titles = re.findall(r"(?m)^#+ +(.+?) *$", without_code(page))
    return {re.sub(r"[^\w\- ]", "", re.sub(r"\]\([^)]*\)", "", title)).lower().replace(" ", "-") for title in titles}


def without_code(page: Path) -> str:
    return re.sub(r"(?ms)^ *```.*?^ *```", "", page.read_text(encoding="utf-8"))


if __name__ == "__main__":
    unittest.main()
