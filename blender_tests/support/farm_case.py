# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of a farm on a shot of three garments, in the Blender of the test."""
from __future__ import annotations

import contextlib
import hashlib
import io
import json
import tempfile
import unittest
from pathlib import Path

from rumple.blender.farm import command
from rumple.core.files import clip_folder
from support import farm_scene

FRAMES = 8


class Case(unittest.TestCase):

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.blend, self.clips = self.folder / "shot.blend", self.folder / "rumple"
        farm_scene.shot(FRAMES)
        farm_scene.save(self.blend)

    def run_command(self, *words: str) -> int:
        """The exit code; what it said is in self.out and self.err."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = command.main([words[0], str(self.blend), *words[1:]])
        self.out, self.err = out.getvalue(), err.getvalue()
        return code

    def data(self, *words: str) -> dict:
        """What it says to machines."""
        self.run_command(*words, "--json")
        return json.loads(self.out.splitlines()[-1].removeprefix("Rumple: "))

    def clip(self, name: str) -> Path:
        """That of a garment: of its readable name."""
        return next(self.clips.glob(f"shot-{clip_folder.clip_name('', name)[1:-13]}-*.pc2"))

    def read_all(self, folder: Path | None = None) -> dict[str, str]:
        """Hashes: unittest takes minutes to compare what is long and differs."""
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest()
                for path in sorted((folder or self.clips).iterdir())}
