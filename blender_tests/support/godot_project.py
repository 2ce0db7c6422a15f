# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of the sample for Godot: its files are imported, and it is played in a window. For the engines suite."""
from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "docs" / "examples" / "godot"
IMPORTED = (".glb", ".png", ".exr")  # file types
TRIES = 5


def said_by(*command: object, code: int = 0, **more: object) -> str:
    """What a command says; AssertionError if it does not end with `code`."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=240, **more)
    said = done.stdout + done.stderr
    if done.returncode != code:
        raise AssertionError(f"{command}: {done.returncode}: {said}")
    return said


class GodotProject:
    """folder: an existing one, for the project, Godot's settings and those of the screen."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "project"
        shutil.copytree(SAMPLE, self.path)
        self._authority = folder / "Xauthority"
        self._environment = {**os.environ, "HOME": str(folder), "LIBGL_ALWAYS_SOFTWARE": "1", "LC_ALL": "C.UTF-8"}

    def import_all(self) -> None:
        """The editor quits after its first look at the files: where the machine is busy, before all are imported."""
        for _ in range(TRIES):
            said_by("godot3-server", "--path", self.path, "-e", "-q", env=self._environment)
            missing = [file for file in self.path.rglob("*") if file.suffix in IMPORTED and not self._is_imported(file)]
            if not missing:
                return
        raise AssertionError(f"Godot did not import {missing}")

    def _is_imported(self, file: Path) -> bool:
        imports = self.path / ".import"
        return imports in file.parents or any(imports.glob(f"{file.name}-*"))

    def play(self, size: int, *words: object, code: int = 0) -> str:
        """What the sample says in a window of size x size pixels. -f: else xvfb-run makes a folder of its own and,
        where the server still writes to it, fails at its end."""
        screen = 100 + os.getpid() % 5000
        said = said_by("xvfb-run", "-f", self._authority, "-n", screen, "-a", "-s", "-screen 0 640x640x24", "godot3",
                       "--path", self.path, "--audio-driver", "Dummy", "--resolution", f"{size}x{size}", *words,
                       code=code, env=self._environment)
        if "SCRIPT ERROR" in said or "SHADER ERROR" in said:
            raise AssertionError(said)
        return said
