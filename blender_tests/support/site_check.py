# SPDX-License-Identifier: GPL-3.0-or-later
"""What a browser finds wrong with a page of the site."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urldefrag

from support.browser import Browser

WIDE, NARROW = (1600, 1000), (400, 800)
_FOUND = """({
    links: [...document.links].map(link => link.href),
    ids: [...document.querySelectorAll('[id]')].map(one => one.id),
    pictures: [...document.images].map(one => [one.src, one.naturalWidth, one.alt]),
    title: document.title,
})"""
# An element that scrolls by itself may be wider than the window: a table, a listing.
_OVERFLOW = """document.documentElement.scrollWidth <= innerWidth ? [] : [...document.querySelectorAll('body *')]
    .filter(one => one.getBoundingClientRect().right > innerWidth + 1).slice(0, 3)
    .map(one => one.tagName + '.' + one.className + ' ' + one.textContent.slice(0, 60))"""
_AXE = """axe.run(document, {resultTypes: ['violations'], runOnly: %s}).then(found => found.violations.map(
    one => one.id + ': ' + one.help + ': ' + one.nodes.slice(0, 3).map(node => node.html.slice(0, 120)
    + (node.any[0] ? ' ' + node.any[0].message : '')).join(' | ')))"""
_ALL = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
_CONTRAST = ["color-contrast", "link-in-text-block"]  # what alone differs by the colours


@dataclass
class Page:
    """What was found on one page."""

    links: list[str] = field(default_factory=list)
    ids: set[str] = field(default_factory=set)
    problems: dict[str, list[str]] = field(default_factory=dict)  # by kind


def look(browser: Browser, address: str, page: str, axe: str, dark: bool = True) -> Page:
    """Open a page of the site at `address` and look at it. axe: the checker's source; empty: not checked. dark: whether
    in dark colours, too."""
    browser.size(*WIDE)
    browser.scheme("light")
    browser.open(address + page)
    found = browser.run(_FOUND)
    problems = {
        "picture": [src for src, width, _ in found["pictures"] if not width],
        "words for a picture": [src for src, _, alt in found["pictures"] if not alt],
        "title": [] if found["title"] else ["none"],
        "elsewhere": sorted(url for url in browser.loaded if not url.startswith((address, "data:"))),
    }
    for name, size in (("1600 pixels", WIDE), ("400 pixels", NARROW)):
        browser.size(*size)
        problems[name] = browser.run(_OVERFLOW)
    problems["accessibility"] = _accessible(browser, axe, dark) if axe else []
    problems["console"] = list(browser.problems)
    return Page(found["links"], set(found["ids"]), {kind: words for kind, words in problems.items() if words})


def _accessible(browser: Browser, axe: str, dark: bool) -> list[str]:
    """Narrow and light: everything. Wide and dark: the colours."""
    browser.run(axe + "; 0")
    words: list[str] = []
    for scheme, size, rules in (("light", NARROW, _ALL), ("dark", WIDE, _CONTRAST))[:1 + dark]:
        browser.scheme(scheme)
        browser.size(*size)
        words += [f"{scheme}: {one}" for one in browser.run(_AXE % rules)]
    return words


def dead_links(pages: dict[str, Page], address: str, folder: Path) -> list[str]:
    """Links between pages that lead to no page, no file or no place on the page."""
    dead = []
    for name, page in pages.items():
        for link in page.links:
            if not link.startswith(address):
                continue
            url, anchor = urldefrag(link)
            target = unquote(url.removeprefix(address)).split("?")[0] or "index.html"
            known: Any = pages.get(target)
            if not (folder / target).is_file() or (anchor and known is not None and unquote(anchor) not in known.ids):
                dead.append(f"{name}: {link.removeprefix(address)}")
    return dead


def reached(pages: dict[str, Page], address: str) -> set[str]:
    """Pages to which links lead from the first one."""
    found, new = set(), {"index.html"}
    while new:
        found |= new
        links = {unquote(urldefrag(link)[0].removeprefix(address)) for name in new for link in pages[name].links
                 if link.startswith(address)}
        new = (links & pages.keys()) - found
    return found
