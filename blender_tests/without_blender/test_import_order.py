# SPDX-License-Identifier: GPL-3.0-or-later
"""Python imports run one way: native, core, blender, and within core and blender from folder to folder. No circle
anywhere. C++ includes run one way, too, from folder to folder of native/."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from support import imports


ROOT = Path(__file__).resolve().parents[2]
ADDON = ROOT / "addon" / "rumple"
# Lowest first. A file or folder imports itself and what stands before it. __init__.py imports any.
LAYERS = ["native", "core", "blender"]
CORE = ["base", "settings", "mesh", "parts", "paint", "cloth", "frame", "systems", "files"]
BLENDER = ["compat", "manual", "translation", "scheduler", "nodes", "objects", "first_click", "viewport", "frame",
           "ui_base", "maps", "brush", "bake", "farm", "ui", "render_lock", "handlers"]
# Folders of native/, lowest first, in the same way. The systems stand side by side: none includes another.
SYSTEMS = ["systems/wrinkle_maps", "systems/wrinkle_mesh", "systems/wrinkle_field", "systems/wrinkle_paths"]
NATIVE = ["include/rumple", "include", "base", "surface/query", "surface/mesh", "surface/refine", "surface/contact",
          "surface/strain", "surface/output", "surface/cloth", *SYSTEMS, "api", "fuzz", "tests", "benchmarks"]
SEARCHED = [ROOT / "native", ROOT / "shaders", ROOT / "native" / "include"]  # as CMakeLists.txt has it
HOST = {"bpy", "bmesh", "mathutils", "gpu", "gpu_extras", "bl_ui", "bpy_extras", "addon_utils"}


class Order(unittest.TestCase):
    def test_layers_import_only_what_stands_below(self) -> None:
        self.assertEqual(imports.wrong_order(ADDON, LAYERS), [])

    def test_folders_of_the_core_import_only_what_stands_below(self) -> None:
        self.assertEqual(imports.wrong_order(ADDON / "core", CORE), [])

    def test_folders_of_the_blender_layer_import_only_what_stands_below(self) -> None:
        self.assertEqual(imports.wrong_order(ADDON / "blender", BLENDER), [])

    def test_no_modules_import_one_another_in_a_circle(self) -> None:
        graph = imports.graph_of(ADDON)
        self.assertGreater(len(graph), 60)
        self.assertGreater(sum(map(len, graph.values())), 200)
        self.assertEqual(imports.cycle_in(graph), [])

    def test_only_the_blender_layer_sees_blender(self) -> None:
        seen = {}
        for name, file in imports.modules_of(ADDON).items():
            hosts = {other.split(".")[0] for other in imports.imported(name, file)} & HOST
            seen[name] = hosts
            if not name.startswith("rumple.blender"):
                self.assertEqual(hosts, set(), name)
        self.assertIn("bpy", seen["rumple.blender.objects.modifier"])  # else the search finds nothing


class Includes(unittest.TestCase):
    def test_native_folders_include_only_what_stands_below(self) -> None:
        self.assertEqual(imports.wrong_includes(ROOT / "native", NATIVE, set(SYSTEMS), SEARCHED), [])


class Reader(unittest.TestCase):
    """The reader sees what it is there to see, in small packages made for it."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.package = Path(folder.name) / "cloth"

    def write(self, files: dict[str, str]) -> None:
        """Modules by their paths."""
        for name, text in files.items():
            file = self.package / f"{name}.py"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)

    def test_a_circle_by_an_import_inside_a_function(self) -> None:
        self.write({"a": "from . import b", "b": "def f():\n    from .a import g", "c": "from . import a, b"})
        self.assertEqual(imports.cycle_in(imports.graph_of(self.package)), ["cloth.a", "cloth.b", "cloth.a"])
        self.write({"b": ""})
        self.assertEqual(imports.cycle_in(imports.graph_of(self.package)), [])

    def test_an_import_from_above(self) -> None:
        order = ["core", "blender"]
        for text in ("def f():\n    from ..blender.deep import b", "import cloth.blender.deep.b",
                     "from cloth.blender.deep.b import f"):
            self.write({"core/a": text, "blender/deep/b": ""})
            self.assertEqual(imports.wrong_order(self.package, order), ["cloth.core.a imports cloth.blender.deep.b"])
        self.write({"core/a": "", "blender/deep/b": "from ...core import a"})
        self.assertEqual(imports.wrong_order(self.package, order), [])

    def test_a_folder_that_is_empty_missing_renamed_or_new(self) -> None:
        self.write({"core/a": "", "blender/__init__": ""})
        self.assertEqual(imports.wrong_order(self.package, ["core", "blender"]), ["cloth/blender has no modules"])
        self.write({"blender/b": ""})
        self.assertEqual(imports.wrong_order(self.package, ["core", "blender"]), [])
        self.assertEqual(imports.wrong_order(self.package, ["kernel", "blender"]),
                         ["kernel is not in cloth", "cloth/core has no place in the order"])

    def test_an_import_that_nobody_can_read(self) -> None:
        self.write({"a": "import importlib\nimportlib.import_module('cloth.b')", "b": "from . import a"})
        self.assertEqual(imports.cycle_in(imports.graph_of(self.package)), ["cloth.a", "cloth.b", "cloth.a"])
        self.write({"a": "import importlib\nimportlib.import_module('cloth.' + __name__)"})
        with self.assertRaisesRegex(AssertionError, "nobody can read"):
            imports.graph_of(self.package)


class IncludeReader(unittest.TestCase):
    """The reader of includes, on a small tree made for it."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name) / "native"
        for name in ("base/a.h", "systems/x/x.h", "systems/y/y.h"):
            self.write(name, "")

    def write(self, name: str, text: str) -> None:
        file = self.root / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def wrong(self, *order: str) -> list[str]:
        return imports.wrong_includes(self.root, list(order or ("base", "systems/x", "systems/y")),
                                      {"systems/x", "systems/y"}, [self.root])

    def test_what_stands_above_and_what_stands_beside(self) -> None:
        self.write("systems/y/y.cpp", '#include <vector>\n#include "y.h"\n#include "base/a.h"\n')
        self.assertEqual(self.wrong(), [])
        self.write("base/a.cpp", '#include "base/a.h"\n#include "systems/x/x.h"\n')
        self.write("systems/y/y.cpp", '#include "systems/x/x.h"\n')
        self.assertEqual(self.wrong(), ["base/a.cpp includes systems/x/x.h", "systems/y/y.cpp includes systems/x/x.h"])

    def test_a_name_that_is_nowhere(self) -> None:
        self.write("base/a.cpp", '#include "base/b.h"\n')
        self.assertEqual(self.wrong(), ["base/a.cpp includes base/b.h, which is nowhere"])

    def test_a_folder_that_is_empty_renamed_or_new(self) -> None:
        (self.root / "systems/y/y.h").rename(self.root / "systems/y/y.txt")
        self.assertEqual(self.wrong(), ["systems/y has no sources"])
        self.write("systems/z/z.h", "")
        self.assertEqual(self.wrong("base", "systems/x"), ["systems/z has no place in the order"])


if __name__ == "__main__":
    unittest.main()
