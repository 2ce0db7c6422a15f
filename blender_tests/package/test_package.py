# SPDX-License-Identifier: GPL-3.0-or-later
"""The zips of dist/, installed by Blender itself into a fresh user folder, then used."""
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
DIST = HERE.parent.parent / "dist"


def the_zip(legacy):
    found = [path for path in DIST.glob("rumple-*.zip") if ("legacy" in path.name) == legacy]
    if len(found) != 1:
        kind = "legacy" if legacy else "extension"
        raise AssertionError(f"expected one {kind} zip in {DIST} (scripts/package), found {found}")
    return found[0]


def blender_version():
    said = subprocess.run(["blender", "--version"], capture_output=True, text=True, check=True).stdout
    return tuple(map(int, re.match(r"Blender (\d+)\.(\d+)", said).groups()))


class InstalledPackage(unittest.TestCase):

    def setUp(self):
        self.home = self.enterContext(tempfile.TemporaryDirectory())

    def blender(self, *arguments):
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

    def use(self):
        said = self.blender("-b", "--python-exit-code", "1", "--python", str(HERE / "use_addon.py"), "--", self.home)
        self.assertIn("RUMPLE WORKS", said)

    def test_extension(self):
        if blender_version() < (4, 2):
            self.skipTest("extensions came with Blender 4.2")
        package = str(the_zip(legacy=False))
        self.blender("--command", "extension", "validate", package)
        self.blender("--command", "extension", "install-file", "-r", "user_default", "-e", package)
        self.use()

    def test_legacy(self):
        self.blender("-b", "--python-exit-code", "1", "--python", str(HERE / "install_legacy.py"), "--",
                     str(the_zip(legacy=True)))
        self.use()
