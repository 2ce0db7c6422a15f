# SPDX-License-Identifier: GPL-3.0-or-later
"""The zips of dist/, installed by Blender itself into a fresh user folder, then used."""
from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import unittest
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
DIST = HERE.parent.parent / "dist"


PLATFORMS = ("linux-x64", "macos-arm64", "macos-x64", "windows-x64")


def the_zip(pattern: str) -> Path:
    found = [path for path in zips() if re.fullmatch(pattern, path.name)]
    if len(found) != 1:
        raise AssertionError(f"expected one zip {pattern} in {DIST} (scripts/package), found {found}")
    return found[0]


def zips() -> list[Path]:
    """All, in the order of their names. None is an error: nothing would be tested."""
    found = sorted(DIST.glob("rumple-*.zip"))
    if not found:
        raise AssertionError(f"no zips in {DIST} (scripts/package)")
    return found


def of_platforms() -> list[Path]:
    """Those of one platform each."""
    found = [path for path in zips() if re.fullmatch(one_platform(f"({'|'.join(PLATFORMS)})"), path.name)]
    if not found:
        raise AssertionError(f"no zip of one platform in {DIST} (scripts/package)")
    return found


LEGACY, ALL = r"rumple-legacy-[\d.]+\.zip", r"rumple-[\d.]+\.zip"


def one_platform(name: str) -> str:
    return rf"rumple-[\d.]+-{name}\.zip"


def blender_version() -> tuple[int, ...]:
    said = subprocess.run(["blender", "--version"], capture_output=True, text=True, check=True).stdout
    return tuple(map(int, re.match(r"Blender (\d+)\.(\d+)", said).groups()))


class InstalledPackage(unittest.TestCase):

    def setUp(self) -> None:
        self.home = self.enterContext(tempfile.TemporaryDirectory())

    def blender(self, *arguments: str) -> str:
        """Runs Blender with nothing but the fresh user folder; returns what it said."""
        environment = {name: value for name, value in os.environ.items()
                       if name != "PYTHONPATH" and not name.startswith("RUMPLE_")}
        environment |= {"HOME": self.home, "XDG_CONFIG_HOME": self.home, "XDG_CACHE_HOME": self.home,
                        "BLENDER_USER_RESOURCES": f"{self.home}/blender"}
        run = subprocess.run(["blender", *arguments], env=environment, text=True, timeout=300,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        # A refused platform is said, with exit status 0.
        for sign in ("Traceback", "ERROR"):
            self.assertNotIn(sign, run.stdout)
        self.assertEqual(run.returncode, 0, run.stdout)
        return run.stdout

    def install(self, package: Path) -> None:
        self.blender("--command", "extension", "validate", str(package))
        self.blender("--command", "extension", "install-file", "-r", "user_default", "-e", str(package))
        self.use()

    def use(self) -> None:
        said = self.blender("-b", "--python-exit-code", "1", "--python", str(HERE / "use_addon.py"), "--", self.home)
        self.assertIn("RUMPLE WORKS", said)
        words = ["bake", f"{self.home}/worn.blend"]
        call = ["--command", "rumple", *words] if blender_version() >= (4, 2) else \
            ["-b", "--python-expr", f"from rumple.blender.farm import command; command.run_and_exit({words})"]
        self.assertIn("Rumple: 1 of 1 baked", self.blender(*call))
        self.assertEqual(len(list(Path(self.home, "rumple").glob("worn-Sleeve-*.pc2"))), 1)

    def test_extension(self) -> None:
        if blender_version() < (4, 2):
            self.skipTest("extensions came with Blender 4.2")
        self.install(the_zip(one_platform("linux-x64")))

    def test_extension_with_all_platforms(self) -> None:
        if blender_version() < (4, 2):
            self.skipTest("extensions came with Blender 4.2")
        self.install(the_zip(ALL))

    def test_extensions_of_other_platforms_are_valid(self) -> None:
        if blender_version() < (4, 2):
            self.skipTest("extensions came with Blender 4.2")
        for path in of_platforms():
            self.blender("--command", "extension", "validate", str(path))

    def test_legacy(self) -> None:
        self.blender("-b", "--python-exit-code", "1", "--python", str(HERE / "install_legacy.py"), "--",
                     str(the_zip(LEGACY)))
        self.use()


class Zips(unittest.TestCase):
    """What is in them, whatever the Blender."""

    def test_a_platform_has_its_own_library_and_no_other(self) -> None:
        made = [name for name in PLATFORMS if any(DIST.glob(f"rumple-*-{name}.zip"))]
        self.assertIn("linux-x64", made)
        for name in made:
            with zipfile.ZipFile(the_zip(one_platform(name))) as archive:
                folders = {entry.split("/")[1] for entry in archive.namelist() if entry.startswith("lib/")}
                manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
            self.assertEqual((folders, manifest["platforms"]), ({name}, [name]))
        for pattern, below in ((ALL, "lib/"), (LEGACY, "rumple/lib/")):
            with zipfile.ZipFile(the_zip(pattern)) as archive:
                folders = {entry.removeprefix(below).split("/")[0] for entry in archive.namelist()
                           if entry.startswith(below)}
            self.assertEqual(folders, set(made))

    def test_every_library_has_its_digest(self) -> None:
        for path in zips():
            with zipfile.ZipFile(path) as archive:
                libraries = [name for name in archive.namelist() if "lib/" in name and not name.endswith(".sha256")]
                self.assertTrue(libraries)
                for name in libraries:
                    self.assertEqual(archive.read(f"{name}.sha256").decode(),
                                     hashlib.sha256(archive.read(name)).hexdigest(), f"{path.name}: {name}")

    @unittest.skipUnless(shutil.which("x86_64-w64-mingw32-objdump"), "there are no tools to look into libraries")
    def test_a_library_asks_only_for_what_every_machine_has(self) -> None:
        sys.path.insert(0, str(DIST.parent / "scripts"))
        from library_facts import facts_of
        of_the_system = {
            "linux-x64": {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1",
                          "ld-linux-x86-64.so.2"},
            "windows-x64": {"KERNEL32.dll", "msvcrt.dll"},
            "macos-arm64": {"/usr/lib/libSystem.B.dylib"}, "macos-x64": {"/usr/lib/libSystem.B.dylib"}}
        header = "".join(file.read_text() for file in (DIST.parent / "native" / "include" / "rumple").glob("*.h"))
        promised = set(re.findall(r"\b(rumple_\w+)\(", re.sub(r"//[^\n]*", "", header)))
        with tempfile.TemporaryDirectory() as home, zipfile.ZipFile(the_zip(ALL)) as archive:
            archive.extractall(home)
            checked = 0
            for folder in sorted(Path(home, "lib").iterdir()):
                file = next(path for path in folder.iterdir() if path.suffix != ".sha256")
                if (folder / "libosdCPU.so.3.5.0").exists():
                    continue    # this machine's own build: it needs Debian's libraries, which lie beside it
                checked += 1
                facts = facts_of(file)
                self.assertLessEqual(set(facts.needs), of_the_system[folder.name], folder.name)
                self.assertEqual(set(facts.exports), promised, folder.name)
                self.assertEqual(facts.faults, [], folder.name)
                # OpenSubdiv's cosines, of irregular vertices; what is ours has its own (native/base/elementary.h).
                self.assertLessEqual({name.strip("_").removesuffix("_stret").removesuffix("f")
                                      for name in facts.mathematics()}, {"cos", "sin", "sincos"}, folder.name)
                if folder.name == "linux-x64":
                    self.assertLessEqual(tuple(map(int, facts.system.split()[1].split("."))), (2, 28))
                if folder.name.startswith("macos"):
                    self.assertEqual(facts.system, "macOS 11.0")
                if folder.name == "macos-arm64":
                    self.assertTrue(facts.signed)
            self.assertGreater(checked, 0)

    def test_pictures_of_fabrics_and_three_examples_come_along(self) -> None:
        pictures = {path.name for path in (DIST.parent / "addon" / "rumple" / "thumbnails").iterdir()}
        self.assertGreater(len(pictures), 10)
        for path in zips():
            with zipfile.ZipFile(path) as archive:
                names = archive.namelist()
            self.assertEqual({name.split("/")[-1] for name in names if "thumbnails/" in name}, pictures, path.name)
            self.assertEqual({name.split("/")[-1] for name in names if ".blend" in name},
                             {"Face.blend", "Shirt.blend", "Skirt.blend"}, path.name)

    def test_a_platform_has_at_most_eight_megabytes(self) -> None:
        for path in of_platforms():
            self.assertLess(path.stat().st_size, 8e6, path.name)
