# SPDX-License-Identifier: GPL-3.0-or-later
"""Finding and opening the library on every system: what can be tested on one of them."""
from __future__ import annotations

import ctypes
import hashlib
import importlib.util
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from rumple.core.files import clip_folder
from rumple.native import library, platforms
from rumple.native.library import Library, lib

NOBODY = 65534  # Debian's user of that name
LOADED_IN_A_FOLDER = """
import sys
sys.path.insert(0, {addon!r})
from rumple.native import library
library.lib.open()
print(library.lib.path, library.lib.rumple_version().decode())
"""


class Names(unittest.TestCase):
    def test_a_platform_is_named_as_blender_does(self) -> None:
        for system, machine, name in (("win32", "amd64", "windows-x64"), ("darwin", "arm64", "macos-arm64"),
                                      ("darwin", "x86_64", "macos-x64"), ("linux", "x86_64", "linux-x64"),
                                      ("linux", "aarch64", "linux-arm64"), ("freebsd14", "amd64", "freebsd14-x64")):
            self.assertEqual(platforms.here(system, machine), name)

    def test_windows_is_asked_for_nothing_that_is_slow_and_a_process_counts_as_what_it_was_made_for(self) -> None:
        """A Blender for x64 runs on ARM, too: there was no Rumple for it. All of `platform` goes through uname()."""
        of_process = (("win-amd64", "windows-x64"), ("win-arm64", "windows-arm64"), ("win32", "windows-win32"))
        for told, name in of_process:
            with mock.patch.object(platform, "uname", side_effect=AssertionError), \
                    mock.patch.object(sys, "platform", "win32"), \
                    mock.patch.object(sysconfig, "get_platform", return_value=told):
                self.assertEqual(platforms.here(), name)
        with mock.patch.object(platform, "uname", side_effect=AssertionError):
            again = importlib.util.module_from_spec(clip_folder.__spec__)
            clip_folder.__spec__.loader.exec_module(again)
        self.assertEqual(again.HOST, clip_folder.HOST)
        self.assertTrue(platform.node() and clip_folder.HOST.startswith(re.sub("[^A-Za-z0-9]", "_", platform.node())))

    def test_every_platform_has_its_own_file(self) -> None:
        self.assertEqual([platforms.file_name(name) for name in ("windows-x64", "macos-arm64", "linux-x64")],
                         ["rumple.dll", "librumple.dylib", "librumple.so"])


class Refused(unittest.TestCase):
    """What cannot be loaded is a sentence that says what to do."""

    def setUp(self) -> None:
        self.home = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(mock.patch.object(library, "BUNDLED", self.home))
        self.enterContext(mock.patch.dict(os.environ))
        os.environ.pop("RUMPLE_NATIVE", None)

    def opened(self) -> str:
        with self.assertRaises(library.NativeMissing) as raised:
            Library().open()
        return str(raised.exception)

    def bundle(self, data: bytes) -> None:
        folder = self.home / platforms.here()
        folder.mkdir()
        (folder / platforms.file_name(platforms.here())).write_bytes(data)

    def test_no_library(self) -> None:
        self.assertIn(f"Install the Rumple package for {platforms.here()}", self.opened())

    def test_the_package_of_another_platform_is_named(self) -> None:
        (self.home / "windows-x65").mkdir()
        self.assertIn("it is the package for windows-x65", self.opened())

    def test_a_library_of_another_system(self) -> None:
        self.bundle(b"MZ" + bytes(4096))
        self.assertIn("damaged or made for another system", self.opened())

    def test_a_truncated_library(self) -> None:
        """Without its digest, Linux maps what there is, and reading beyond its end is the end of Blender."""
        self.bundle(lib_bytes()[:-5000])
        file = self.home / platforms.here() / platforms.file_name(platforms.here())
        file.with_name(file.name + ".sha256").write_text(hashlib.sha256(lib_bytes()).hexdigest())
        self.assertIn("damaged", self.opened())

    def test_an_empty_library(self) -> None:
        self.bundle(b"")
        self.assertIn("damaged", self.opened())

    def test_a_library_that_is_none_of_ours(self) -> None:
        found = subprocess.run(["gcc", "-print-file-name=libm.so.6"], capture_output=True, text=True, check=True)
        self.bundle(Path(found.stdout.strip()).read_bytes())
        self.assertIn("of another version", self.opened())

    def test_what_systems_say_becomes_advice(self) -> None:
        path = Path("/Users/Jörg Ölund/rumple/lib/macos-arm64/librumple.dylib")
        for said, advice in (
                ("/lib/libc.so.6: version `GLIBC_2.28' not found (required by librumple.so)", "older than the one"),
                ("dlopen(...): code signature in <F2> not valid for use in process: library load disallowed by "
                 "system policy", 'xattr -dr com.apple.quarantine "/Users/Jörg Ölund/rumple/lib/macos-arm64"'),
                ("[WinError 193] %1 is not a valid Win32 application", "made for another system"),
                ("mach-o file, but is an incompatible architecture (have 'x86_64', need 'arm64')", "another system"),
                ("[WinError 5] Zugriff verweigert", "virus scanner"),
                ("Could not find module 'C:\\Ä b\\rumple.dll' (or one of its dependencies).", "that it needs"),
                ("[WinError 126] Das angegebene Modul wurde nicht gefunden", "Something that it needs"),
                ("what nobody has foreseen", "Install Rumple again")):
            self.assertIn(advice, platforms.why_refused(said, path))


def lib_bytes() -> bytes:
    lib.open()
    assert lib.path
    return lib.path.read_bytes()


class Moved(unittest.TestCase):
    """Windows refuses a rename while anybody looks at the file."""

    def setUp(self) -> None:
        self.home = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.waited: list[float] = []
        self.enterContext(mock.patch("time.sleep", self.waited.append))
        (self.home / "new").write_text("new")

    def move(self, refusals: int, on_windows: bool) -> bool:
        """Whether it came to its place."""
        answers = [PermissionError(13, "in use")] * refusals
        replace = os.replace

        def scanned(source: Path, target: Path) -> None:
            if answers:
                raise answers.pop()
            replace(source, target)
        with mock.patch("os.replace", scanned), mock.patch.object(platforms, "ON_WINDOWS", on_windows):
            try:
                clip_folder.put(self.home / "new", self.home / "place")
            except PermissionError:
                return False
        return (self.home / "place").read_text() == "new"

    def test_it_is_tried_again_for_some_seconds(self) -> None:
        self.assertTrue(self.move(2, True))
        self.assertEqual(len(self.waited), 2)

    def test_and_not_for_ever(self) -> None:
        self.assertFalse(self.move(1000, True))
        self.assertTrue(2.0 < sum(self.waited) < 5.0)

    def test_other_systems_say_so_at_once(self) -> None:
        self.assertFalse(self.move(1, False))
        self.assertEqual(self.waited, [])


class Folders(unittest.TestCase):
    """The add-on in folders as artists have them, each in a Python of its own."""

    def loaded_in(self, folder: Path) -> str:
        source = Path(library.__file__).parent.parent
        shutil.copytree(source, folder / "rumple", ignore=shutil.ignore_patterns("__pycache__", "lib"))
        bundled = folder / "rumple" / "lib" / platforms.here()
        bundled.mkdir(parents=True)
        lib.open()
        assert lib.path
        for file in lib.path.parent.iterdir():     # and what it needs beside it
            if ".so" in file.name:
                shutil.copy(file, bundled)
        return self.run_there(folder)

    def run_there(self, folder: Path, user: int | None = None) -> str:
        environment = {name: value for name, value in os.environ.items() if not name.startswith("RUMPLE_")}
        run = subprocess.run([sys.executable, "-c", LOADED_IN_A_FOLDER.format(addon=str(folder))], cwd=folder,
                             user=user, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(run.returncode, 0, run.stdout)
        return run.stdout

    def test_spaces_umlauts_and_other_scripts(self) -> None:
        home = Path(self.enterContext(tempfile.TemporaryDirectory(prefix="Jörg's Blender % 资 ")))
        self.assertIn(str(home), self.loaded_in(home))

    def test_a_folder_that_nobody_may_write(self) -> None:
        """By another user, where the tests are run by root, who may write everywhere."""
        home = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.loaded_in(home)
        for path in (home, *home.rglob("*")):
            path.chmod(0o555)
        self.addCleanup(lambda: [path.chmod(0o755) for path in (home, *home.rglob("*")) if path.is_dir()])
        self.assertIn(str(home), self.run_there(home, user=NOBODY if os.geteuid() == 0 else None))

    def test_each_installation_loads_its_own_library(self) -> None:
        first, second = (Path(self.enterContext(tempfile.TemporaryDirectory())) for _ in range(2))
        self.loaded_in(first)
        self.assertIn(str(second), self.loaded_in(second))


class Copies(unittest.TestCase):
    """Windows locks a library that is loaded: a copy is loaded."""

    def setUp(self) -> None:
        self.home = Path(self.enterContext(tempfile.TemporaryDirectory(prefix="Zwischen raum ä")))
        self.copies = self.home / "copies"
        self.library = self.home / "rumple.dll"
        self.library.write_bytes(b"first version")

    def test_the_installed_file_may_go_while_its_copy_is_held(self) -> None:
        copy = platforms.copy_to_load(self.library, self.copies)
        self.assertNotEqual(copy, self.library)
        self.assertEqual(copy.name, "rumple.dll")
        with copy.open("rb") as held:
            self.library.unlink()
            self.assertEqual(held.read(), b"first version")

    def test_a_second_start_copies_nothing(self) -> None:
        copy = platforms.copy_to_load(self.library, self.copies)
        before = copy.stat().st_mtime_ns, copy.stat().st_ino
        self.assertEqual(platforms.copy_to_load(self.library, self.copies), copy)
        self.assertEqual((copy.stat().st_mtime_ns, copy.stat().st_ino), before)

    def test_an_update_gets_a_copy_of_its_own_and_the_old_one_goes(self) -> None:
        old = platforms.copy_to_load(self.library, self.copies)
        self.library.write_bytes(b"second version")
        new = platforms.copy_to_load(self.library, self.copies)
        self.assertEqual(new.read_bytes(), b"second version")
        self.assertFalse(old.exists())

    def test_a_copy_that_another_blender_holds_stays(self) -> None:
        old = platforms.copy_to_load(self.library, self.copies)
        self.library.write_bytes(b"second version")
        with mock.patch("os.unlink", side_effect=PermissionError("[WinError 5] held")), \
                mock.patch("os.rmdir", side_effect=PermissionError("[WinError 5] held")):
            new = platforms.copy_to_load(self.library, self.copies)
        self.assertTrue(old.exists())
        self.assertEqual(new.read_bytes(), b"second version")

    def test_a_damaged_copy_is_made_again(self) -> None:
        copy = platforms.copy_to_load(self.library, self.copies)
        copy.write_bytes(b"first ver")
        self.assertEqual(platforms.copy_to_load(self.library, self.copies).read_bytes(), b"first version")

    def test_without_a_place_for_copies_the_library_itself_is_loaded(self) -> None:
        self.copies.write_bytes(b"a file, no folder")
        self.assertEqual(platforms.copy_to_load(self.library, self.copies), self.library)

    def test_a_copy_that_another_blender_made_meanwhile_is_loaded(self) -> None:
        """It holds the copy already, so this one's rename is refused."""
        def taken(source: Path, target: Path) -> None:
            shutil.copy(source, target)
            raise PermissionError(13, "[WinError 5] held")
        with mock.patch("os.replace", taken):
            copy = platforms.copy_to_load(self.library, self.copies)
        self.assertNotEqual(copy, self.library)
        self.assertEqual([file.name for file in copy.parent.iterdir()], ["rumple.dll"])

    def test_a_copy_that_cannot_be_put_in_place_leaves_nothing(self) -> None:
        with mock.patch("os.replace", side_effect=PermissionError(13, "[WinError 5] held")):
            self.assertEqual(platforms.copy_to_load(self.library, self.copies), self.library)
        self.assertEqual([file for file in self.copies.rglob("*") if file.is_file()], [])

    def test_where_copies_may_not_be_loaded_the_installed_file_is(self) -> None:
        """Rules of a studio forbid libraries in the folder for temporary files."""
        lib.open()
        load = ctypes.CDLL

        def ruled(path: str) -> ctypes.CDLL:
            if path.startswith(str(self.home)):
                raise OSError("[WinError 1260] blocked by group policy")
            return load(path)
        with mock.patch.object(platforms, "is_locked_when_open", return_value=True), \
                mock.patch("tempfile.gettempdir", return_value=str(self.home)), mock.patch("ctypes.CDLL", ruled):
            second = Library()
            second.open()
        self.assertEqual(second.path, library.library_file())

    def test_a_library_loads_from_its_copy(self) -> None:
        lib.open()
        assert lib.path
        with mock.patch.object(platforms, "is_locked_when_open", return_value=True), \
                mock.patch("tempfile.gettempdir", return_value=str(self.home)):
            second = Library()
            second.open()
        self.assertTrue(str(second.path).startswith(str(self.home)))
        self.assertEqual(second.rumple_version(), lib.rumple_version())


if __name__ == "__main__":
    unittest.main()
