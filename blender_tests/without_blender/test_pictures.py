# SPDX-License-Identifier: GPL-3.0-or-later
"""Every picture of the docs has a command, and every command its picture: docs/pictures/commands.txt."""
from __future__ import annotations

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "docs" / "pictures"
KINDS = {".jpg", ".png", ".svg", ".webp"}


def commands() -> dict[str, str]:
    """Names of pictures, or patterns, -> what scripts/pictures does."""
    found = {}
    for line in (PICTURES / "commands.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            names, _, command = line.partition(":")
            found.update(dict.fromkeys(names.split(), command.strip()))
    return found


class Commands(unittest.TestCase):
    def test_each_picture_is_named(self) -> None:
        pictures = {file.relative_to(PICTURES).as_posix() for file in PICTURES.rglob("*") if file.suffix in KINDS}
        self.assertEqual(pictures, {name for name in commands() if not name.startswith("addon/")})
        self.assertGreater(len(pictures), 60)

    def test_what_lies_elsewhere_is_there(self) -> None:
        elsewhere = [name for name in commands() if name.startswith("addon/")]
        self.assertTrue(elsewhere)
        for name in elsewhere:
            self.assertTrue(list(ROOT.glob(name)), name)

    def test_the_commands_are_known(self) -> None:
        """Each is a function of scripts/pictures, and the script, clip, scene or lesson that it names is there."""
        known = set(re.findall(r"(?m)^(\w+)\(\)", (ROOT / "scripts" / "pictures").read_text(encoding="utf-8")))
        places = {"clip": "scripts/gallery_clips.py", "bench": "scripts/bench", "lesson": "scripts/lessons"}
        for command in commands().values():
            kind, *words = command.split()
            self.assertIn(kind, known)
            if kind in places:
                self.assertRegex((ROOT / places[kind]).read_text(encoding="utf-8"), rf"\b{words[0]}\b")
            for word in words if kind != "hand" else ():
                self.assertTrue(not word.endswith(".py") or (PICTURES / word).is_file(), word)

    def test_each_maker_is_used(self) -> None:
        makers = {file.name for file in PICTURES.glob("make_*.py")}
        named = {word for command in commands().values() for word in command.split() if word.endswith(".py")}
        self.assertEqual(makers - named, {"make_ground_truth.py"})  # of the command ground_truth


if __name__ == "__main__":
    unittest.main()
