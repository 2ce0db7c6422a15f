# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of docs/architecture.md: structure.svg, which module of addon/rumple imports which, before its folders
and now; and the lengths of functions, printed. Readable on light and on dark pages.

    docs/pictures/make_structure.py [COMMIT]    the tree before; needs the repository with its history
"""
from __future__ import annotations

import ast
import io
import re
import statistics
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "blender_tests")]
from support import imports  # noqa: E402
from without_blender.test_import_order import BLENDER, CORE, LAYERS  # noqa: E402

BEFORE = "fcaa147"
# Comments, strings, characters and directives of C++.
NO_CODE = re.compile(r'//.*|"(\\.|[^"\\])*"|\'(\\.|[^\'\\])\'|^#.*', re.MULTILINE)
SIDE, TOP, LEFT, GAP = 520, 70, 110, 150
STYLE = """
svg { --back: #ffffff; --text: #1c1e21; --line: #c3c9d0; --down: #2f6fae; --up: #d0342c; --own: #e4ecf5; }
@media (prefers-color-scheme: dark) {
    svg { --back: #16181b; --text: #e4e6e9; --line: #3a4048; --down: #7db6ea; --up: #ff6f61; --own: #222b36; }
}
text { font: 11px system-ui, "DejaVu Sans", sans-serif; fill: var(--text); }
.title { font-size: 15px; font-weight: 700; }
"""


def sorted_modules(graph: imports.Graph) -> list[str]:
    """Each behind what it imports, as far as that can be: modules of a circle stand beside one another."""
    reached = {name: _reached(graph, name) for name in graph}
    return sorted(graph, key=lambda name: (len(reached[name]), sorted(reached[name]), name))


def _reached(graph: imports.Graph, name: str) -> set[str]:
    found, todo = set(), [name]
    while todo:
        for other in graph[todo.pop()] - found:
            found.add(other)
            todo.append(other)
    return found


def matrix(graph: imports.Graph, groups: list[tuple[str, list[str]]], left: float, title: str) -> str:
    """A row for each module, a column for each that it imports; below the diagonal what stands before it."""
    order = [name for _, names in groups for name in names]
    place, cell = {name: number for number, name in enumerate(order)}, SIDE / len(order)
    marks: dict[str, list[str]] = {"down": [], "up": []}
    for name in order:
        for other in graph[name]:
            kind = "down" if place[other] < place[name] else "up"
            marks[kind].append(f"M{left + place[other] * cell:.1f} {TOP + place[name] * cell:.1f}"
                               f"h{cell:.1f}v{cell:.1f}h-{cell:.1f}z")
    parts, last = [f'<text x="{left}" y="{TOP - 40}" class="title">{title}</text>'], -20.0
    above = len(marks["up"])
    parts.append(f'<text x="{left}" y="{TOP - 22}">{len(order)} modules, {sum(map(len, graph.values()))} imports, '
                 f'{above if above else "none"} from above</text>')
    for label, names in groups:
        first, size = place[names[0]] * cell, len(names) * cell
        parts.append(f'<rect x="{left + first:.1f}" y="{TOP + first:.1f}" width="{size:.1f}" height="{size:.1f}" '
                     f'fill="var(--own)" stroke="var(--line)"/>')
        last = max(last + 12, TOP + first + size / 2 + 4)
        parts.append(f'<text x="{left - 6}" y="{last:.1f}" text-anchor="end">{label}</text>')
    parts += [f'<path d="{"".join(ways)}" fill="var(--{kind})"/>' for kind, ways in marks.items() if ways]
    parts.append(f'<rect x="{left}" y="{TOP}" width="{SIDE}" height="{SIDE}" fill="none" stroke="var(--line)"/>')
    return "".join(parts)


def groups_of(graph: imports.Graph, folders: list[str]) -> list[tuple[str, list[str]]]:
    """The modules by folders of the add-on, lowest first; a folder is `native` or `core/frame`."""
    order = sorted_modules(graph)
    found = []
    for folder in folders:
        start = ".".join(("rumple", *folder.split("/")))
        names = [name for name in order if name == start or name.startswith(start + ".")]
        order = [name for name in order if name not in names]
        found.append((folder, names))
    return [(label, names) for label, names in [*found, ("", order)] if names]


def picture(before: Path, now: Path) -> str:
    high, wide = TOP + SIDE + 50, LEFT + SIDE + GAP + SIDE + 20
    old, new = imports.graph_of(before), imports.graph_of(now)
    folders = ["native", *(f"core/{name}" for name in CORE), *(f"blender/{name}" for name in BLENDER)]
    body = matrix(old, groups_of(old, LAYERS), LEFT, f"Before ({BEFORE})")
    body += matrix(new, groups_of(new, folders), LEFT + SIDE + GAP, "Now")
    said = ("A row imports the columns with a mark. Below the diagonal: from what stands before it. Red: from above, "
            "which makes a circle.")
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" role="img" aria-label="Which module '
            f'of the add-on imports which, before and now"><style>{STYLE}</style>'
            f'<rect width="{wide}" height="{high}" fill="var(--back)"/>{body}'
            f'<text x="{LEFT}" y="{TOP + SIDE + 28}">{said}</text></svg>\n')


# ---------------------------------------------------------------- lengths of functions
def python_lengths(folder: Path) -> dict[str, int]:
    """Lines of the body of every function, without its docstring, by file and name."""
    found = {}
    for file in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.FunctionDef):
                body = node.body[1:] if ast.get_docstring(node) and len(node.body) > 1 else node.body
                found[f"{file.name}:{node.lineno} {node.name}"] = (node.end_lineno or 0) - body[0].lineno + 1
    return found


def native_lengths(folder: Path) -> dict[str, int]:
    """The same of the library's C++: what opens in namespaces and classes behind a list of parameters. A body on the
    line of its head counts as 1."""
    found = {}
    for file in [*folder.rglob("*.cpp"), *folder.rglob("*.h")]:
        if {"tests", "benchmarks", "fuzz", "include"} & set(file.parts[len(folder.parts):]):
            continue
        text = NO_CODE.sub("", file.read_text())
        scopes: list[tuple[bool, int]] = []  # of the open braces: whether of a function's body, and the line
        head, line = "", 1
        for letter in text:
            line += letter == "\n"
            if letter == "{":
                inside = any(is_body for is_body, _ in scopes)
                is_head = ")" in head and not re.search(r"=\s*$|\b(enum|namespace)\b", head)
                scopes.append((is_head and not inside, line))
            elif letter == "}" and scopes:
                is_body, began = scopes.pop()
                if is_body:
                    found[f"{file.name}:{began}"] = max(line - began - 1, 1)
            head = "" if letter in "{};" else head + letter
    return found


def main() -> None:
    commit = sys.argv[1] if len(sys.argv) > 1 else BEFORE
    with tempfile.TemporaryDirectory() as folder:
        packed = subprocess.run(["git", "archive", commit, "addon", "native"], cwd=ROOT, check=True,
                                capture_output=True).stdout
        tarfile.open(fileobj=io.BytesIO(packed)).extractall(folder)
        before = Path(folder)
        (ROOT / "docs/pictures/structure.svg").write_text(picture(before / "addon/rumple", ROOT / "addon/rumple"))
        for name, tree in (("before", before), ("now", ROOT)):
            lengths = {"Python": python_lengths(tree / "addon"), "C++": native_lengths(tree / "native")}
            for language, found in lengths.items():
                longest = sorted(found, key=found.__getitem__)[-6:][::-1]
                print(f"{name}, {language}: {len(found)} functions, median {statistics.median(found.values()):g}, "
                      "longest " + ", ".join(f"{found[one]} ({one})" for one in longest))


main()
