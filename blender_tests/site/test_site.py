# SPDX-License-Identifier: GPL-3.0-or-later
"""The site in a browser: every page, wide and narrow, light and dark. scripts/suite site has built it."""
from __future__ import annotations

import os
import runpy
import tempfile
import unittest
from pathlib import Path

from support import site_check
from support.browser import Browser, Server

SITE = Path(os.environ["RUMPLE_SITE"])
AXE = Path(os.environ["RUMPLE_AXE"])  # the checker's file, where it could be had
_AXE = AXE.read_text(encoding="utf-8") if AXE.is_file() else ""
_BROKEN = """<!DOCTYPE html><title>Broken</title><body style="margin:0">
<p id="here" style="color:#999;background:#aaa">Grey on grey</p>
<a href="nowhere.html">A page</a> <a href="index.html#nowhere">A place</a> <a href="index.html#here">This place</a>
<img src="nowhere.png" alt="Nothing">
<img src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=">
<div style="width:%dpx">Wide</div><script>console.error("wrong")</script>
<img src="http://localhost:9/x.png" alt="Elsewhere">"""
_FOCUS = """(() => { const one = document.activeElement, style = getComputedStyle(one),
    box = one.getBoundingClientRect();
    return [one.tagName, one.href || one.id || one.className || one.tagName,
            style.outlineStyle != 'none' || style.boxShadow != 'none' || one.matches('input'),
            box.width > 0 && box.height > 0] })()"""

_VIDEOS = "[...document.querySelectorAll('video')]"
_SOON = "new Promise(done => setTimeout(done, 500)).then(() =>"

# Pages that have all that is coloured: tables, listings of every language, names of Python, the search.
DARK = ("index", "search", "wrinkle_maps", "farm", "c_base", "python_core_fabrics")


def is_checked(name: str) -> bool:
    """Whether the checker of accessibility looks at a page. Of the pages that are made alike, at some."""
    return not name.startswith("reference/") or Path(name).stem in (
        "c", "c_base", "python", "python_native_base_cloth", "python_core_fabrics")


class Checks(unittest.TestCase):
    """Each finds what it is there for."""

    def looked_at(self, width: int) -> tuple[site_check.Page, list[str]]:
        with tempfile.TemporaryDirectory() as folder, Browser() as browser:
            Path(folder, "index.html").write_text(_BROKEN % width)
            server = Server(Path(folder))
            try:
                page = site_check.look(browser, server.address, "index.html", _AXE)
                return page, site_check.dead_links({"index.html": page}, server.address, Path(folder))
            finally:
                server.close()

    def test_a_broken_page_is_broken_in_every_way(self) -> None:
        page, dead = self.looked_at(1000)
        self.assertEqual(dead, ["index.html: nowhere.html", "index.html: index.html#nowhere"])
        kinds = {"picture", "words for a picture", "console", "elsewhere", "400 pixels"}
        self.assertEqual(page.problems.keys() - {"accessibility"}, kinds)
        self.assertTrue(any("wrong" in words for words in page.problems["console"]))
        if _AXE:
            found = " ".join(page.problems["accessibility"])
            for rule in ("color-contrast", "html-has-lang", "image-alt", "landmark-one-main"):
                self.assertIn(rule, found)

    def test_what_is_wider_than_a_desk(self) -> None:
        self.assertIn("1600 pixels", self.looked_at(1700)[0].problems)


class Site(unittest.TestCase):
    server: Server
    pages: dict[str, site_check.Page]

    @classmethod
    def setUpClass(cls) -> None:
        cls.server = Server(SITE)
        names = sorted(path.relative_to(SITE).as_posix() for path in SITE.rglob("*.html") if "files" not in path.parts)
        with Browser() as browser:
            cls.pages = {name: site_check.look(browser, cls.server.address, name, _AXE if is_checked(name) else "",
                                               Path(name).stem in DARK) for name in names}

    @classmethod
    def tearDownClass(cls) -> None:
        cls.server.close()

    def without(self, *kinds: str) -> None:
        """No page has such a problem."""
        wrong = [f"{name}: {kind}: {word}" for name, page in self.pages.items() for kind in kinds
                 for word in page.problems.get(kind, [])]
        self.assertEqual(wrong, [], "\n".join(wrong[:40]))

    def test_the_pages_are_there_and_links_lead_to_each(self) -> None:
        for name in ("index", "install", "which_system", "gallery", "user_guide", "lessons/first_wrinkles",
                     "platforms", "farm", "publishing", "reference/c_wrinkle_mesh",
                     "reference/python_native_wrinkle_mesh"):
            self.assertIn(f"{name}.html", self.pages)
        for path in Path(__file__).resolve().parents[2].joinpath("docs").rglob("*.md"):
            self.assertIn(path.with_suffix(".html").name, {Path(name).name for name in self.pages})
        alone = self.pages.keys() - {"search.html"} - site_check.reached(self.pages, self.server.address)
        self.assertEqual(alone, set())

    def test_every_link_and_anchor_leads_somewhere(self) -> None:
        links = sum(link.startswith(self.server.address) for page in self.pages.values() for link in page.links)
        self.assertGreater(links, 1000)
        self.assertEqual(site_check.dead_links(self.pages, self.server.address, SITE), [])

    def test_the_add_on_knows_the_anchors_of_the_guide(self) -> None:
        guide = runpy.run_path(str(Path(__file__).resolve().parents[2] / "addon/rumple/core/settings/guide.py"))
        page = (SITE / guide["PAGE"]).read_text(encoding="utf-8")
        for anchor in guide["anchors"]():
            self.assertIn(f'<section id="{anchor}">', page)

    def test_every_picture_loads_and_is_said_in_words(self) -> None:
        self.without("picture", "words for a picture")

    def test_nothing_complains_and_nothing_comes_from_elsewhere(self) -> None:
        self.without("console", "elsewhere", "title")

    def test_no_page_is_wider_than_a_phone_or_a_desk(self) -> None:
        self.without("400 pixels", "1600 pixels")

    def test_contrast_and_landmarks(self) -> None:
        if not _AXE:
            self.skipTest("npm has no axe-core for us: accessibility is NOT TESTED")
        self.without("accessibility")

    def test_the_start_page_can_be_walked_by_keyboard(self) -> None:
        """Tab comes to every link of the text, and the link it is at is seen."""
        wanted = {link for link in self.pages["index.html"].links if "#" not in link}
        with Browser() as browser:
            browser.size(*site_check.WIDE)
            browser.open(self.server.address + "index.html")
            visited = set()
            for _ in range(len(self.pages["index.html"].links) + 20):
                browser.press("Tab")
                tag, name, ringed, seen = browser.run(_FOCUS)
                if tag == "A" and seen:
                    visited.add(name)
                    self.assertTrue(ringed, name)
        missing = {link for link in wanted if link not in visited}
        hidden = {link for link in missing if "/reference/" in link or "/lessons/" in link}  # folded up at the side
        self.assertEqual(missing - hidden, set())
        self.assertGreater(len(visited), 15)

    def test_clips_play_and_a_keyboard_stops_them(self) -> None:
        """Each is a video that stands still where less motion is wanted, and plays while it is seen elsewhere."""
        clips = list((SITE / "_static" / "clips").glob("*.mp4"))
        if not clips:
            self.skipTest("no ffmpeg or no Pillow when the site was built: its clips are animated WebP, NOT TESTED")
        with Browser() as browser:
            browser.size(*site_check.NARROW)
            browser.scheme("light")
            browser.open(self.server.address + "gallery.html")
            self.assertEqual(sorted(browser.run(f"{_VIDEOS}.map(one => one.src.split('/').pop())")),
                             sorted(clip.name for clip in clips))
            self.assertEqual(browser.run(f"{_VIDEOS}.filter(one => !one.paused || !one.ariaLabel).length"), 0)
            browser.run(f"{_VIDEOS}[0].focus()")
            for is_playing in (True, False):
                browser.press(" ")
                self.assertIs(browser.run(f"{_SOON} !{_VIDEOS}[0].paused)"), is_playing)
            played = browser.run("Promise.all(%s.map(one => one.play().then(() => new Promise(done => "
                                 "one.addEventListener('timeupdate', () => one.currentTime > 0 && done(one.duration)))"
                                 ")))" % _VIDEOS)
            self.assertEqual([seconds for seconds in played if not 1.0 < seconds < 6.1], [])
            self.assertEqual(browser.problems, [])
            browser.call("Emulation.setEmulatedMedia", features=[])
            browser.open(self.server.address + "index.html")
            browser.run(f"{_VIDEOS}[0].scrollIntoView()")
            self.assertIs(browser.run(f"{_SOON} !{_VIDEOS}[0].paused)"), True)


if __name__ == "__main__":
    unittest.main()
