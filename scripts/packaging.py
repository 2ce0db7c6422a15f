# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what artists install. Started by scripts/package, in Debian's Python and with nothing but it.

    packaging.py wheel FOLDER OUT    the wheel of an installed module (cmake --install), for this Python
    packaging.py zips WHEELS OUT     the extension zip (4.2 and later) and the legacy zip (before) with all wheels

Times inside the archives are fixed: the same input gives the same bytes.
"""
import base64
import hashlib
import platform
import re
import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ADDON = ROOT / "addon" / "rumple"
FIXED_TIME = (2000, 1, 1, 0, 0, 0)


def project_version():
    """CMakeLists.txt has the version; the manifest and bl_info must say the same."""
    version = re.search(r"project\(rumple VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
    for name, said in (("blender_manifest.toml", f'\nversion = "{version}"\n'),
                       ("__init__.py", f'"version": ({version.replace(".", ", ")}),')):
        if said not in (ADDON / name).read_text():
            sys.exit(f"packaging: CMakeLists.txt has version {version}, addon/rumple/{name} another")
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


def platform_tag(libraries):
    """manylinux_2_X: X is the newest GLIBC symbol version that any of these libraries asks for."""
    needs = subprocess.run(["readelf", "--wide", "--version-info", *libraries],
                           check=True, capture_output=True, text=True).stdout
    newest = max(int(minor) for minor in re.findall(r"\bGLIBC_2\.(\d+)", needs))
    return f"manylinux_2_{newest}_{platform.machine()}"


def wheel(folder, out):
    version = project_version()
    entries = files_below(folder)
    python = "cp{}{}".format(*sys.version_info)
    tag = f"{python}-{python}-{platform_tag([folder / name for name in entries])}"
    info = f"rumple_native-{version}.dist-info"
    entries[f"{info}/METADATA"] = (
        f"Metadata-Version: 2.1\nName: rumple-native\nVersion: {version}\n"
        "Summary: The native module of Rumple: wrinkles for animated garments and skin\n"
        "License: GPL-3.0-or-later\nRequires-Dist: numpy\n"
        "Requires-Python: =={}.{}.*\n".format(*sys.version_info)).encode()
    entries[f"{info}/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: rumple\nRoot-Is-Purelib: false\nTag: {tag}\n").encode()
    entries[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = "".join(f"{name},sha256={record_hash(data)},{len(data)}\n" for name, data in sorted(entries.items()))
    entries[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    write_zip(out / f"rumple_native-{version}-{tag}.whl", entries)


def record_hash(data):
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def zips(wheels, out):
    version = project_version()
    addon = files_below(ADDON) | {"LICENSE": (ROOT / "LICENSE").read_bytes()}
    addon |= {f"shaders/{name}": data for name, data in files_below(ROOT / "shaders").items()}  # see viewport/glsl.py
    write_zip(out / f"rumple-{version}.zip", addon | extension_files(wheels))
    legacy = {name: data for name, data in addon.items() if name != "blender_manifest.toml"} | legacy_files(wheels)
    write_zip(out / f"rumple-legacy-{version}.zip", {f"rumple/{name}": data for name, data in legacy.items()})


def extension_files(wheels):
    """The wheels, and the manifest that names them."""
    names = "".join(f'    "./wheels/{wheel.name}",\n' for wheel in wheels)
    lines = f'platforms = ["{blender_platform()}"]\nwheels = [\n{names}]\n\n[permissions]'
    manifest = (ADDON / "blender_manifest.toml").read_text().replace("[permissions]", lines)
    entries = {f"wheels/{wheel.name}": wheel.read_bytes() for wheel in wheels}
    return {"blender_manifest.toml": manifest.encode()} | entries


def blender_platform():
    return {"x86_64": "linux-x64", "aarch64": "linux-arm64"}[platform.machine()]


def legacy_files(wheels):
    """lib/<abi>/ for each Python, as addon/rumple/native.py looks for it."""
    files = {}
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            names = [name for name in archive.namelist() if ".dist-info/" not in name]
            module = next(name for name in names if name.startswith("rumple_native.cpython"))
            abi = module.split(".")[1]
            files |= {f"lib/{abi}/{name}": archive.read(name) for name in names}
    return files


if __name__ == "__main__":
    action, source, target = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    if action == "wheel":
        wheel(source, target)
    else:
        zips(sorted(source.glob("*.whl")), target)
