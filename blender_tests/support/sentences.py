# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts in the add-on's sources, as the translators' files have them: {0}, {1}, ... for values."""
from __future__ import annotations

import ast
import re
from pathlib import Path


def of_sources(folder: Path) -> set[str]:
    """Every string and f-string. What the library says has the object's name in front."""
    found: set[str] = set()
    for file in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            text = template(node)
            found |= {text, "{0}: " + re.sub(r"\\(\d)", r"{\1}", text)}
    return found


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
