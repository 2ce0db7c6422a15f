# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what artists install. Started by scripts/package, in Debian's Python and with nothing but it.

    packaging.py FOLDER OUT    the extension zip (4.2 and later) and the legacy zip (before), both with the library and
                               what it needs from FOLDER (cmake --install)

Times inside the archives are fixed: the same input gives the same bytes.
"""
import platform
import re
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ADDON = ROOT / "addon" / "rumple"
HEADER = ROOT / "native" / "include" / "rumple" / "base.h"
FIXED_TIME = (2000, 1, 1, 0, 0, 0)


def project_version():
    """CMakeLists.txt has the version; the manifest, bl_info and the C header must say the same."""
    version = re.search(r"project\(rumple VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
    for file, said in ((ADDON / "blender_manifest.toml", f'\nversion = "{version}"\n'),
                       (ADDON / "__init__.py", f'"version": ({version.replace(".", ", ")}),'),
                       (HEADER, f'#define RUMPLE_VERSION "{version}"\n')):
        if said not in file.read_text():
            sys.exit(f"packaging: CMakeLists.txt has version {version}, {file.relative_to(ROOT)} another")
    return version


def write_zip(path, entries):
    """entries: {name in the archive: bytes}."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in sorted(entries.items()):
            info = zipfile.ZipInfo(name, FIXED_TIME)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = (0o100755 if ".so" in Path(name).name else 0o100644) << 16
            archive.writestr(info, data)
    print(path)


def files_below(folder):
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in sorted(folder.rglob("*"))
            if file.is_file() and "__pycache__" not in file.parts}


def zips(installed, out):
    version = project_version()
    addon = files_below(ADDON) | {"LICENSE": (ROOT / "LICENSE").read_bytes()}
    addon |= {f"shaders/{name}": data for name, data in files_below(ROOT / "shaders").items()}  # see viewport/glsl.py
    addon |= {f"lib/{name}": data for name, data in files_below(installed).items()}     # see native/library.py
    write_zip(out / f"rumple-{version}.zip", addon | {"blender_manifest.toml": manifest()})
    legacy = {name: data for name, data in addon.items() if name != "blender_manifest.toml"}
    write_zip(out / f"rumple-legacy-{version}.zip", {f"rumple/{name}": data for name, data in legacy.items()})


def manifest():
    """The extension's, with the system that the library is for."""
    system = {"x86_64": "linux-x64", "aarch64": "linux-arm64"}[platform.machine()]
    text = (ADDON / "blender_manifest.toml").read_text()
    return text.replace("[permissions]", f'platforms = ["{system}"]\n\n[permissions]').encode()


if __name__ == "__main__":
    zips(Path(sys.argv[1]), Path(sys.argv[2]))
