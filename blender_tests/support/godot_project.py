# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets Godot's editor import the files of a project, for the engines suite."""
from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

IMPORTED = (".glb", ".png", ".exr")  # file types
TRIES = 5


def import_all(project: Path, run_editor: Callable[[], object]) -> None:
    """run_editor: `godot3-server -e -q`, which quits after its first look at the files: where the machine is busy,
    before all are imported."""
    for _ in range(TRIES):
        run_editor()
        missing = [file for file in project.rglob("*") if file.suffix in IMPORTED and not _is_imported(project, file)]
        if not missing:
            return
    raise AssertionError(f"Godot did not import {missing}")


def _is_imported(project: Path, file: Path) -> bool:
    imports = project / ".import"
    return imports in file.parents or any(imports.glob(f"{file.name}-*"))
