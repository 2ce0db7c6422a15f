# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes what artists install. Started by scripts/package, in Debian's Python and with nothing but it.

    packaging.py FOLDER OUT    FOLDER has a folder for each platform with its library. For each an extension zip
                               (Blender 4.2 and later), one extension zip with all, one legacy zip (before 4.2) with all

Times inside the archives are fixed: the same input gives the same bytes.
"""
from __future__ import annotations

import hashlib
import re
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ADDON = ROOT / "addon" / "rumple"
HEADER = ROOT / "native" / "include" / "rumple" / "base.h"
PACKED_EXAMPLES = ("Face", "Shirt", "Skirt")  # of the lessons; the others are a zip of their own, as large as a package
FIXED_TIME = (2000, 1, 1, 0, 0, 0)


def project_version() -> str:
    """The C header has the version; the manifest and bl_info must say the same."""
    version = re.search(r'#define RUMPLE_VERSION "([\d.]+)"', HEADER.read_text())[1]
    for file, said in ((ADDON / "blender_manifest.toml", f'\nversion = "{version}"\n'),
                       (ADDON / "__init__.py", f'"version": ({version.replace(".", ", ")}),')):
        if said not in file.read_text():
            sys.exit(f"packaging: {HEADER.name} has version {version}, {file.relative_to(ROOT)} another")
    return version


def write_zip(path: Path, entries: Mapping[str, str | bytes]) -> None:
    """entries: {name in the archive: bytes}."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in sorted(entries.items()):
            info = zipfile.ZipInfo(name, FIXED_TIME)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = (0o100755 if name.split("/")[-3:-2] == ["lib"] else 0o100644) << 16
            archive.writestr(info, data)
    print(f"{path} {path.stat().st_size / 1e6:.1f} MB")


def files_below(folder: Path) -> dict[str, bytes]:
    """All but what Python and Blender leave beside what they read and save."""
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in sorted(folder.rglob("*"))
            if file.is_file() and "__pycache__" not in file.parts and not re.fullmatch(r"\.blend\d+", file.suffix)}


def guide_files(site: Path) -> dict[str, bytes]:
    """The guide's page of a site with its pictures and styles, without menu, search and links to the other pages: those
    stay out, for they are twice as large. Nothing where there is no site."""
    page = site / "user_guide.html"
    if not page.is_file():
        return {}
    text = page.read_text(encoding="utf-8")
    for tag in ("script", "form", 'nav class="site"'):
        text = re.sub(f"<{tag}.*?</{tag.split()[0]}>", "", text, flags=re.S)
    text = re.sub(r'<a\b[^>]* href="(?!https?:|#)[^"]*\.html[^"]*"[^>]*>(.*?)</a>', r"\1", text, flags=re.S)
    styles = {f"_static/{file.name}" for file in site.glob("_static/*.css")}
    named = styles.union(re.findall(r'(?:src|href)="([^"#?:]+)', text))
    return {page.name: text.encode()} | {name: (site / name).read_bytes() for name in sorted(named)}


def zips(installed: Path, out: Path) -> None:
    version = project_version()
    addon = files_below(ADDON) | {"LICENSE": (ROOT / "LICENSE").read_bytes()}
    others = {name: addon.pop(name) for name in list(addon)
              if name.startswith("examples/") and Path(name).stem not in PACKED_EXAMPLES}
    if others:
        write_zip(out / f"examples-{version}.zip", others | {"examples/LICENSE": addon["LICENSE"]})
    addon |= {f"shaders/{name}": data for name, data in files_below(ROOT / "shaders").items()}  # see viewport/glsl.py
    guide = guide_files(ROOT / "build" / "guide")  # see core/settings/guide.py
    addon |= {f"guide/{name}": data for name, data in guide.items()}
    libraries = {f"lib/{name}": data for name, data in files_below(installed).items()}  # see native/library.py
    libraries |= {f"{name}.sha256": hashlib.sha256(data).hexdigest().encode() for name, data in libraries.items()}
    platforms = sorted({name.split("/")[1] for name in libraries})
    for platform in platforms:
        own = {name: data for name, data in libraries.items() if name.startswith(f"lib/{platform}/")}
        write_zip(out / f"rumple-{version}-{platform}.zip",
                  addon | own | {"blender_manifest.toml": manifest([platform])})
    write_zip(out / f"rumple-{version}.zip", addon | libraries | {"blender_manifest.toml": manifest(platforms)})
    legacy = {name: data for name, data in (addon | libraries).items() if name != "blender_manifest.toml"}
    write_zip(out / f"rumple-legacy-{version}.zip", {f"rumple/{name}": data for name, data in legacy.items()})


def manifest(platforms: list[str]) -> bytes:
    """The extension's, with the platforms that its libraries are for."""
    names = ", ".join(f'"{name}"' for name in platforms)
    text = (ADDON / "blender_manifest.toml").read_text()
    return text.replace("[permissions]", f"platforms = [{names}]\n\n[permissions]").encode()


if __name__ == "__main__":
    zips(Path(sys.argv[1]), Path(sys.argv[2]))
