# SPDX-License-Identifier: GPL-3.0-or-later
"""The rules of docs/architecture.md that a search can hold. Imports and includes: test_import_order.py."""
from __future__ import annotations

import ast
import re
import subprocess
import unittest
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CODE = {".h", ".cpp", ".py", ".glsl"}
TOP = {"native", "addon", "blender_tests", "shaders", "docs", "scripts", "CMakeLists.txt", "CMakePresets.json",
       "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "README.md"}  # and names that begin with a dot


def sources(*folders: str) -> list[Path]:
    """Source files below the given folders. A folder without any is an error: the rule would hold nothing."""
    found = {folder: [f for f in sorted((ROOT / folder).rglob("*")) if f.suffix in CODE] for folder in folders}
    empty = [folder for folder, files in found.items() if not files]
    if empty:
        raise AssertionError(f"no source files below {', '.join(empty)}")
    return [f for files in found.values() for f in files]


# What may hold braces that begin and end no block; and what begins the block of a type, or a table of constants.
NO_CODE = re.compile(r"""//.*|"(\\.|[^"\\])*"|'[{}]'""")
NO_FUNCTION = re.compile(r"\s*(inline )?(namespace|extern|class|struct|enum|union)\b|.*= \{$")


def native_blocks(text: str) -> Iterator[tuple[int, int]]:
    """First and last lines of functions, and of what is in them: from a '{' that ends a line to its '}'."""
    opened: list[tuple[int, bool]] = []
    for number, line in enumerate(text.splitlines(), 1):
        code = NO_CODE.sub("", line).rstrip()
        for brace in re.findall("[{}]", code):
            if brace == "{":
                opened.append((number, code.endswith("{") and not NO_FUNCTION.match(code)))
                continue
            first, is_block = opened.pop()
            if is_block:
                yield first, number
    if opened:
        raise AssertionError(f"no end of what begins in line {opened[-1][0]}")


class Conventions(unittest.TestCase):
    def test_no_result_depends_on_the_functions_of_a_system(self) -> None:
        """Sines of two systems differ in their last bit, or by more: native/base/elementary.h has them for all."""
        differ = ("sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot"
                  "|polar|arg")
        for layer in ("shared", "base", "surface", "systems", "api"):
            # The sine and the cosine of formulas are those of elementary: base/formulas.h.
            pattern = (r"\b(?:tan|asin|acos|atan|exp|exp2|log|log2|pow)\(" if layer == "shared" else
                       rf"\b(?:std|glm)::(?:{differ}|angleAxis|slerp|rotate|lgamma|erf)f?\(")
            for file in sources("shaders/shared" if layer == "shared" else f"native/{layer}"):
                code = re.sub(r"//[^\n]*", "", file.read_text())
                self.assertIsNone(re.search(pattern, code), f"{file}: see native/base/elementary.h")

    def test_the_blender_layer_does_no_linear_algebra(self) -> None:
        for file in sources("addon/rumple/blender"):
            self.assertNotRegex(file.read_text(), r"np\.(linalg|einsum|cross|dot)\b", str(file))

    def test_no_path_is_resolved(self) -> None:
        """On some drives of Windows that raises: the add-on could not be enabled there. os.path.abspath() does not."""
        for file in sources("addon/rumple"):
            self.assertNotRegex(file.read_text(), r"\.resolve\(|realpath\(", str(file))

    def test_native_tests_that_set_threads_say_so_in_their_names(self) -> None:
        """By that word scripts/suite picks what runs under ThreadSanitizer."""
        named = 0
        for file in sources("native/tests"):
            for test in re.split(r"(?m)^TEST(?:_F|_P)?\(", file.read_text())[1:]:
                name = test[:test.index(")")]
                body = test[:test.index("\n}")]
                if re.search(r"\bthreads\b|std::j?thread\b|\btogether\(", body):
                    self.assertIn("Thread", name, f"{file}: {name}")
                    named += 1
        self.assertGreaterEqual(named, 8)

    def test_what_one_blender_alone_tests_is_in_a_file_that_it_runs(self) -> None:
        """With three Blenders the first runs a third of the files: scripts/test, run_suite.py."""
        thirds = re.search(r'background,"\$\{versions\[0\]\}"\) echo (\S+)', (ROOT / "scripts" / "test").read_text())
        files = sorted((ROOT / "blender_tests" / "background").glob("test_*.py"))
        left = [path.name for number, path in enumerate(files) if str(1 + number % 3) not in thirds.group(1)]
        alone = [name for name in left
                 if "in_one_blender" in (ROOT / "blender_tests" / "background" / name).read_text(encoding="utf-8")]
        self.assertGreater(len(left), 10)
        self.assertEqual(alone, [], "name them so that they stand elsewhere in the list")

    def test_every_source_says_its_licence_first(self) -> None:
        for file in sources("native", "addon", "blender_tests", "shaders", "scripts"):
            head = file.read_text().splitlines()[:2]
            self.assertTrue(any("SPDX-License-Identifier: GPL-3.0-or-later" in line for line in head), str(file))

    def test_the_version_is_that_of_the_c_header(self) -> None:
        """The one place. Blender reads these two as they are; CMake and native/c are made from the header."""
        found = re.search(r'#define RUMPLE_VERSION "(.+)"', (ROOT / "native/include/rumple/base.h").read_text())
        version = found.group(1)
        manifest = (ROOT / "addon/rumple/blender_manifest.toml").read_text()
        self.assertEqual(re.findall(r'(?m)^version = "(.+)"', manifest), [version])
        info = ast.literal_eval(re.search(r"bl_info = ({.*?\n})", (ROOT / "addon/rumple/__init__.py").read_text(),
                                          re.DOTALL).group(1))
        self.assertEqual(".".join(map(str, info["version"])), version)
        self.assertTrue((ROOT / "CHANGELOG.md").read_text().split("\n## ")[1].startswith(version))

    def test_lines_fit_on_the_screen(self) -> None:
        for file in sources("native", "addon", "blender_tests", "scripts", "docs"):
            most = 120 if file.suffix == ".py" else 110
            for number, line in enumerate(file.read_text().splitlines(), 1):
                self.assertLessEqual(len(line), most, f"{file}:{number}")

    def test_nothing_else_lies_at_the_top(self) -> None:
        """A script once wrote a folder named --help, which was committed."""
        if not (ROOT / ".git").exists():
            self.skipTest("no checkout")
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        top = {line.split("/")[0] for line in listed.splitlines()}
        self.assertEqual({name for name in top if not name.startswith(".")}, TOP)

    def test_files_stay_readable_in_one_sitting(self) -> None:
        for file in sources("native", "addon", "scripts", "blender_tests"):
            self.assertLessEqual(len(file.read_text().splitlines()), 400, str(file))

    def test_functions_of_the_add_on_do_one_thing(self) -> None:
        """As far as their lines say so: without head and docstring."""
        found = 0
        for file in sources("addon"):
            for node in ast.walk(ast.parse(file.read_text())):
                if isinstance(node, ast.FunctionDef):
                    body = node.body[1:] if ast.get_docstring(node) and len(node.body) > 1 else node.body
                    self.assertLessEqual(node.end_lineno - body[0].lineno + 1, 40, f"{file}: {node.name}")
                    found += 1
        self.assertGreater(found, 1000)

    def test_functions_of_the_library_do_one_thing(self) -> None:
        """Likewise, without the head, but with both braces."""
        found = 0
        for file in sources(*(f"native/{layer}" for layer in ("base", "surface", "systems", "api"))):
            for first, last in native_blocks(file.read_text()):
                self.assertLessEqual(last - first + 1, 40, f"{file}:{first}")
                found += 1
        self.assertGreater(found, 1000)


if __name__ == "__main__":
    unittest.main()
