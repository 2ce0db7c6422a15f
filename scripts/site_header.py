# SPDX-License-Identifier: GPL-3.0-or-later
"""The C header as pages: its comments are the text, its declarations the code between, each under its name.

pages(FOLDER) reads rumple.h and what it includes. Blocks of a header are what empty lines part; a comment at the
beginning of a block says what the declarations behind it do, and "// ---- words" begins a section.
"""
from __future__ import annotations

import re
from pathlib import Path

_NAME = re.compile(r"(?:RUMPLE_API\s+[\w\s*]*?\b(rumple_\w+)\(|typedef (?:struct|enum) (rumple_\w+))")
_SKIPPED = re.compile(r"^(#(?!define RUMPLE_VERSION).*|extern \"C\" \{|\})$")


def prose(lines: list[str]) -> str:
    """Comment lines as Markdown: those that are indented stay as they are, what begins in capitals stands out."""
    paragraphs: list[str] = []
    for block in re.split(r"\n\s*\n", "\n".join(line.removeprefix("//").removeprefix(" ") for line in lines)):
        if block.startswith("   "):
            paragraphs.append("```none\n" + re.sub(r"(?m)^    ", "", block) + "\n```")
            continue
        text = re.sub(r"([\\*_<>\[\]|`])", r"\\\1", block)
        text = re.sub(r"\brumple(?:\\_\w+?)+\b(?:\(\))?", lambda name: f"`{name[0]}`".replace("\\", ""), text)
        paragraphs.append(re.sub(r"^([A-Z]{4,}(?: [A-Z]+)*)\b", r"**\1**", text))
    return "\n\n".join(paragraphs)


def names_of(code: str) -> list[str]:
    """What a block declares, each once."""
    return list(dict.fromkeys(one or other for one, other in _NAME.findall(code)))


def block_text(block: str, seen: set[str], depth: int) -> str:
    """A block between two empty lines: a heading of what is new in it, the comment, the code. depth: of headings."""
    lines = [line for line in block.splitlines() if not _SKIPPED.match(line)]
    count = next((n for n, line in enumerate(lines) if not line.startswith("//")), len(lines))
    comment, code = lines[:count], "\n".join(lines[count:])
    parts: list[str] = []
    if comment and comment[0].startswith("// ---- "):
        parts.append("## " + comment[0].removeprefix("// ---- ")[:1].upper() + comment[0].removeprefix("// ---- ")[1:])
        comment = comment[1:]
    names = [name for name in names_of(code) if name not in seen]
    seen.update(names)
    parts += [f"({name})=" for name in names[1:]]
    if names:
        parts.append(f"({names[0]})=\n{'#' * depth} {names[0].removeprefix('rumple_').replace('_', ' ')}")
    if comment:
        parts.append(prose(comment))
    if code.strip():
        parts.append(f"```c\n{code.strip()}\n```")
    return "\n\n".join(parts)


def page(path: Path) -> tuple[str, list[str]]:
    """The page of one header, and the names that it declares."""
    lines = path.read_text(encoding="utf-8").splitlines()[1:]  # without the licence
    count = next(n for n, line in enumerate(lines) if not line.startswith("//"))
    seen: set[str] = set()
    blocks, depth = [], 2
    for block in re.split(r"\n\s*\n(?!    )", "\n".join(lines[count:])):
        depth = 3 if block.startswith("// ---- ") else depth
        blocks.append(block_text(block, seen, depth))
    return "\n\n".join([f"# rumple/{path.name}", prose(lines[:count]), *filter(None, blocks)]) + "\n", sorted(seen)


def pages(include: Path) -> dict[str, str]:
    """Markdown by name: c, and c_NAME for each header that rumple.h includes."""
    text = (include / "rumple.h").read_text(encoding="utf-8")
    headers = re.findall(r'#include "rumple/(\w+)\.h"', text)
    found = {f"c_{name}": page(include / "rumple" / f"{name}.h") for name in headers}
    lines = text.splitlines()[1:]
    grammar = prose(lines[:next(n for n, line in enumerate(lines) if not line.startswith("//"))])
    listed = "\n".join(f"- [rumple/{name}.h](c_{name}.md)" for name in headers)
    names = sorted(name for _, declared in found.values() for name in declared)
    index = ",\n".join(f"[{name}]({name})" for name in names)
    front = f"# C\n\n{grammar}\n\n## The headers\n\n{listed}\n\n## Every name\n\n{index}\n"
    return {"c": front, **{name: text for name, (text, _) in found.items()}}
