# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on knows where the guide describes what."""
from __future__ import annotations

import re
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from rumple.core.settings import guide

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import packaging  # noqa: E402
from support import sentences  # noqa: E402

GUIDE = (ROOT / "docs" / "user_guide.md").read_text(encoding="utf-8")

_NEED_NO_GUIDE = {  # what was done, and steps of it
    "{0}: folds run along {1}", "{0}: settings copied to {1}", "{0}: {1} shape keys. {2} is hidden",
    "{0}: {1} weights, {2} frames", "{0}: settling the wrinkles", "{0}: storing the map",
    "{0}: the former folds stay, and the settings are as they were",
}


def anchor_of(heading: str) -> str:
    """As Sphinx makes it of a heading: the site's test compares with the page itself."""
    return re.sub(r"[^a-z0-9]+", "-", heading.lower()).strip("-")


HEADINGS = [anchor_of(heading) for heading in re.findall(r"(?m)^#+ (.+)$", GUIDE)]


class Anchors(unittest.TestCase):
    def test_headings_are_named_once(self) -> None:
        self.assertEqual(len(set(HEADINGS)), len(HEADINGS))
        self.assertIn("attachment-constraints", HEADINGS)

    def test_every_place_is_a_heading(self) -> None:
        self.assertEqual(guide.anchors() - set(HEADINGS), set())

    def test_a_message_opens_the_part_that_has_it(self) -> None:
        trouble = GUIDE.split("\n## When something is wrong\n")[1].split("\n## ")[0]
        found = 0
        for part in trouble.split("### ")[1:]:
            heading, *rows = part.splitlines()
            for row in rows:
                cells = row.strip("| ").split(" | ")
                if len(cells) < 2 or cells[0] in ("message", "---|---"):
                    continue
                for words in cells[0].split("; "):
                    message = words.replace("...", "Shirt 12")
                    self.assertEqual(guide.place_of_message(message), anchor_of(heading), message)
                    found += 1
        self.assertGreater(found, 25)
        self.assertEqual(guide.place_of_message("Baking wrinkles: 3 of 4"), "")

    def test_every_message_opens_a_part(self) -> None:
        """From the code to the guide: a message that is new has a place there too."""
        checks = "".join(file.read_text(encoding="utf-8") for file in (ROOT / "native/surface/mesh").glob("*.cpp"))
        odd = re.findall(r'(?:\.report\(|warnings\.push_back\(\s*)"([^"]+)"', checks)  # of a mesh: notes on the panel
        self.assertGreater(len(odd), 4)
        told = sentences.told(ROOT / "addon" / "rumple") | {f"{{0}}: {note}" for note in odd}
        self.assertGreater(len(told), 180)
        self.assertLessEqual(_NEED_NO_GUIDE, told)
        self.assertEqual({text for text in told - _NEED_NO_GUIDE
                          if not guide.place_of_message(re.sub(r"\{\d\}", "12", text))}, set())

    def test_every_pattern_is_of_a_message(self) -> None:
        """None is left of a text that has changed, and none is hidden by those before it."""
        opened = {guide.place_of_message(re.sub(r"\{\d\}", "12", text))
                  for text in sentences.told(ROOT / "addon" / "rumple")}
        self.assertEqual({anchor for _pattern, anchor in guide.MESSAGES} - opened, set())


class Address(unittest.TestCase):
    def test_the_site_where_there_is_one_else_the_copy_else_none(self) -> None:
        with tempfile.TemporaryDirectory() as name, mock.patch.object(guide, "FOLDERS", (Path(name),)):
            with mock.patch.object(guide, "WEBSITE", ""):
                self.assertEqual(guide.address("bake"), "")
                Path(name, guide.PAGE).touch()
                self.assertEqual(guide.address("bake"), f"{Path(name).as_uri()}/user_guide.html#bake")
            with mock.patch.object(guide, "WEBSITE", "https://example.org/docs"):
                self.assertEqual(guide.address("bake"), "https://example.org/docs/user_guide.html#bake")
                self.assertEqual(guide.address(), "https://example.org/docs/user_guide.html")

    def test_the_manifest_says_the_same(self) -> None:
        said = re.findall(r'(?m)^website = "(.+)"', (ROOT / "addon/rumple/blender_manifest.toml").read_text())
        self.assertEqual(said, [guide.WEBSITE] if guide.WEBSITE else [])

    def test_packages_have_its_page_with_what_it_shows_and_no_way_to_pages_that_stay_out(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            site = Path(name)
            self.assertEqual(packaging.guide_files(site), {})
            for file, text in {"_images/a.png": "picture", "_static/site.css": "style", "other.html": "other",
                               guide.PAGE: '<nav class="site"><a href="other.html">Other</a></nav><script>x</script>'
                                           '<form action="search.html"></form><img src="_images/a.png">'
                                           '<a class="r" href="other.html#x"><i>Other</i></a> <a href="#here">Here</a>'
                               }.items():
                (site / file).parent.mkdir(exist_ok=True)
                (site / file).write_text(text, encoding="utf-8")
            page = b'<img src="_images/a.png"><i>Other</i> <a href="#here">Here</a>'
            self.assertEqual(packaging.guide_files(site),
                             {guide.PAGE: page, "_images/a.png": b"picture", "_static/site.css": b"style"})


if __name__ == "__main__":
    unittest.main()
