# SPDX-License-Identifier: GPL-3.0-or-later
"""The promises of docs/architecture.md that a search can hold."""
from __future__ import annotations

import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FLOORS = ["shared", "base", "surface", "systems", "api"]  # shared: the formulas of shaders/shared
SISTERS = ["wrinkle_mesh", "wrinkle_field", "wrinkle_paths", "wrinkle_maps"]
CODE = {".h", ".cpp", ".py", ".glsl"}


def sources(*folders: str) -> list[Path]:
    """Source files below the given folders of the project."""
    return [f for folder in folders for f in sorted((ROOT / folder).rglob("*")) if f.suffix in CODE]


class House(unittest.TestCase):
    def test_a_floor_includes_only_itself_and_what_lies_below(self) -> None:
        for height, floor in enumerate(FLOORS):
            for file in sources(f"native/{floor}", f"shaders/{floor}"):
                for included in re.findall(r'#include "(\w+)/', file.read_text()):
                    self.assertIn(included, FLOORS[:height + 1], f"{file} includes {included}")

    def test_systems_never_include_one_another(self) -> None:
        for file in sources("native/systems"):
            home = next((s for s in SISTERS if file.name.startswith(s)), None)
            self.assertIsNotNone(home, f"{file} belongs to no system")
            for included in re.findall(r'#include "systems/(\w+)\.h"', file.read_text()):
                self.assertTrue(included.startswith(home), f"{file} includes {included}")

    def test_the_core_never_sees_blender(self) -> None:
        for file in sources("addon/rumple/core", "addon/rumple/native"):
            self.assertNotRegex(file.read_text(), r"(?m)^\s*(import|from) (bpy|bmesh|mathutils|gpu)", str(file))

    def test_the_blender_layer_does_no_linear_algebra(self) -> None:
        for file in sources("addon/rumple/blender"):
            self.assertNotRegex(file.read_text(), r"np\.(linalg|einsum|cross|dot)\b", str(file))

    def test_every_source_says_its_licence_first(self) -> None:
        for file in sources("native", "addon", "blender_tests", "shaders", "scripts"):
            head = file.read_text().splitlines()[:2]
            self.assertTrue(any("SPDX-License-Identifier: GPL-3.0-or-later" in line for line in head), str(file))

    def test_lines_fit_on_the_screen(self) -> None:
        for file in sources("native", "addon", "blender_tests", "scripts", "docs"):
            most = 120 if file.suffix == ".py" else 110
            for number, line in enumerate(file.read_text().splitlines(), 1):
                self.assertLessEqual(len(line), most, f"{file}:{number}")

    def test_files_stay_readable_in_one_sitting(self) -> None:
        for file in sources("native", "addon", "scripts"):
            self.assertLessEqual(len(file.read_text().splitlines()), 400, str(file))


if __name__ == "__main__":
    unittest.main()
