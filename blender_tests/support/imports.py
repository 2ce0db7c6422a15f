# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads which modules of a package import which, imports inside functions included, and which native folders
include which, and says what is wrong with that."""
from __future__ import annotations

import ast
import re
from pathlib import Path

Graph = dict[str, set[str]]  # module -> modules, by their full names


def modules_of(package: Path) -> dict[str, Path]:
    """Full name -> file. A folder is named as its __init__.py."""
    found = {}
    for file in sorted(package.rglob("*.py")):
        parts = (package.name, *file.relative_to(package).with_suffix("").parts)
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imported(name: str, file: Path) -> set[str]:
    """All full names that a module imports or may import: of `from a import b` both a and a.b."""
    here = name.split(".") if file.name == "__init__.py" else name.split(".")[:-1]
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = here[:len(here) - node.level + 1] if node.level else []
            source = ".".join((*above, *filter(None, [node.module])))
            found |= {source} | {f"{source}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and _last_name(node.func) in ("import_module", "__import__"):
            if not (node.args and isinstance(node.args[0], ast.Constant)):
                raise AssertionError(f"{file}:{node.lineno}: an import that nobody can read: {ast.unparse(node)}")
            found.add(str(node.args[0].value))
    return found


def _last_name(function: ast.expr) -> str:
    return getattr(function, "attr", getattr(function, "id", ""))


def graph_of(package: Path) -> Graph:
    """What each module of a package imports of it. `from folder import module` counts as the module alone."""
    modules = modules_of(package)
    graph = {}
    for name, file in modules.items():
        used = {other for other in imported(name, file) if other in modules}
        graph[name] = {other for other in used if not any(deeper.startswith(f"{other}.") for deeper in used)}
    return graph


def cycle_in(graph: Graph) -> list[str]:
    """Modules that import one another in a circle, the first one again at the end; empty where there are none."""
    done: set[str] = set()

    def visit(name: str, path: list[str]) -> list[str]:
        if name in path:
            return [*path[path.index(name):], name]
        if name in done:
            return []
        for other in sorted(graph[name]):
            found = visit(other, [*path, name])
            if found:
                return found
        done.add(name)
        return []

    return next((found for found in (visit(name, []) for name in sorted(graph)) if found), [])


def wrong_order(package: Path, order: list[str]) -> list[str]:
    """What is wrong, in sentences. order: files and folders of the package, each may import those before it."""
    there = {file.stem for file in package.glob("*.py") if file.name != "__init__.py"}
    there |= {folder.name for folder in package.iterdir() if any(folder.rglob("*.py"))}  # others hold data
    wrong = [f"{name} is not in {package.name}" for name in order if name not in there]
    wrong += [f"{package.name}/{name} has no place in the order" for name in sorted(there - set(order))]
    wrong += [f"{package.name}/{name} has no modules" for name in order if (package / name).is_dir()
              and not any(file.name != "__init__.py" for file in (package / name).rglob("*.py"))]
    if wrong:
        return wrong
    for name, others in graph_of(package).items():
        below = order[:order.index(_part(name)) + 1] if _part(name) else ["", *order]
        wrong += [f"{name} imports {other}" for other in sorted(others) if _part(other) not in below]
    return wrong


def _part(name: str) -> str:
    """The file or folder of a package that a module belongs to; empty for its __init__.py."""
    return (name.split(".") + [""])[1]


def wrong_includes(root: Path, order: list[str], beside: set[str], search: list[Path]) -> list[str]:
    """What is wrong with the includes of a tree of C++ sources, in sentences.

    order: its folders with sources, each may include itself and those before it. beside: those of them that stand side
    by side: none includes another. search: where a name between quotation marks is looked for, after the folder of the
    file; what is found outside root may be included by all.
    """
    files = [file for ending in ("*.h", "*.cpp") for file in sorted(root.rglob(ending))]
    there = {file.parent.relative_to(root).as_posix() for file in files}
    wrong = [f"{name} has no sources" for name in order if name not in there]
    wrong += [f"{name} has no place in the order" for name in sorted(there - set(order))]
    if wrong:
        return wrong
    for file in files:
        here = file.parent.relative_to(root).as_posix()
        below = {name for name in order[:order.index(here) + 1] if name == here or not {name, here} <= beside}
        for name in re.findall(r'^#include "([^"]+)"', file.read_text(), re.MULTILINE):
            found = next((folder / name for folder in (file.parent, *search) if (folder / name).is_file()), None)
            if found is None:
                wrong.append(f"{file.relative_to(root)} includes {name}, which is nowhere")
            elif found.is_relative_to(root) and found.parent.relative_to(root).as_posix() not in below:
                wrong.append(f"{file.relative_to(root)} includes {name}")
    return wrong
