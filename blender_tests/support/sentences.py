# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts in the add-on's sources, as the translators' files have them: {0}, {1}, ... for values."""
from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Iterator

from rumple.core.base import wording

_SAYING = frozenset(("UserError", "BakeError", "NativeMissing", "draw_message", "draw_note"))
_REFUSING = frozenset(("ValueError", "CannotGoOn"))  # an argument, or a file of the add-on's own: not said to artists
_WORD = re.compile(r"[a-z]{2,}")


def of_sources(folder: Path) -> set[str]:
    """Every string and f-string. What the library says has the object's name in front."""
    found: set[str] = set()
    for file in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            text = template(node)
            found |= {text, "{0}: " + re.sub(r"\\(\d)", r"{\1}", text)}
    return found


def told(folder: Path) -> set[str]:
    """What an artist is told: sentences with the name of an object, {0}, in front, in sources and translators' files;
    what is raised or drawn as a message; what the library's own errors become.

    Not what farm/ prints.
    """
    found = {"{0}: " + re.sub(r"\\(\d)", r"{\1}", sentence) for _pattern, sentence in wording.SENTENCES}
    for file in folder.rglob("*.py"):
        if "farm" not in file.relative_to(folder).parts:
            found |= set(_told_in(ast.parse(file.read_text(encoding="utf-8"))))
    for file in (folder / "translations").glob("*.po"):
        found |= set(re.findall(r'(?m)^msgid "(\{0\}: .+)"$', file.read_text(encoding="utf-8").replace('\\"', '"')))
    return {text for text in found if len(_WORD.findall(text)) > 1}


def _told_in(node: ast.AST, is_said: bool = False) -> Iterator[str]:
    """is_said: the node is what an error or a line of a panel says."""
    name = getattr(node.func, "id", getattr(node.func, "attr", "")) if isinstance(node, ast.Call) else ""
    text = template(node)
    if text and (is_said or text.startswith("{0}: ")):
        yield text
    elif not text and name not in _REFUSING:
        for child in ast.iter_child_nodes(node):
            yield from _told_in(child, name in _SAYING or (is_said and not isinstance(child, ast.Call)))


def template(node: ast.AST) -> str:
    """Of a string's node; empty for others."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if not isinstance(node, ast.JoinedStr):
        return ""
    parts, count = "", 0
    for part in node.values:
        if isinstance(part, ast.Constant):
            parts += part.value
        else:
            parts, count = f"{parts}{{{count}}}", count + 1
    return parts
