# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts together what Sphinx makes the site of: the pages of docs/, three of the root, and the references.

    scripts/site_pages.py DIR

The pages stand in the repository as they are read on a forge. What differs in the site is where a link leads: pages lie
side by side there, docs/index.md is the start page, the C header is its reference, and any other file of the repository
comes along to be downloaded; clips are videos. A link to what is not there is an error.
"""
from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path, PurePosixPath

import site_clips
import site_header

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
BESIDE = {"README.md": "readme.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}  # in the site
# The contents, in their order; pages of docs/ that are named nowhere come last.
PARTS = {
    "Begin": ["install", "which_system", "lessons/index", "gallery", "bench"],
    "Use": ["user_guide", "habits", "farm", "engines", "platforms", "reliability", "publishing"],
    "How it works": ["base_cloth", "garments", "folds_on_cloth", "cloth_measured", "wrinkle_mesh", "wrinkle_field",
                     "wrinkle_paths", "wrinkle_maps", "gpu_preview", "speed"],
    "Reference": ["reference/c", "reference/python"],
    "The project": ["readme", "architecture", "adding_a_system", "contributing", "changelog", "pictures/SOURCES"],
}
TITLES = {"readme": "README"}  # in the list of contents, where a page's own title is also the start page's
LESSONS = ["first_wrinkles", "skirt", "painting", "face", "bake"]
PYTHON = {
    "What does the work": ("native", ("surface", "coarse_mesh", "base_cloth", "wrinkle_mesh", "wrinkle_layers",
                                      "wrinkle_field", "wrinkle_field_brush", "wrinkle_field_steps", "wrinkle_paths",
                                      "wrinkle_paths_drawing", "wrinkle_maps", "handle", "library")),
    "What an add-on needs beside it": ("core", ("settings.system_settings", "settings.fabrics", "mesh.base_mesh",
                                                "frame.engine", "frame.frame_cache", "systems.all_systems",
                                                "systems.poses", "files.clip_file", "files.usd_text")),
}
_LINK = re.compile(r"(?<!\\)\]\(([^)\s]+)\)")


def name_in_site(path: PurePosixPath) -> PurePosixPath:
    """Where a file of the repository stands in the site."""
    if str(path).startswith("native/include/"):
        return PurePosixPath("reference/c.md")
    if str(path) in BESIDE:
        return PurePosixPath(BESIDE[str(path)])
    return path.relative_to("docs") if path.parts[0] == "docs" else PurePosixPath("files") / path


def resolved(page: PurePosixPath, target: str) -> PurePosixPath:
    """The file of the repository that a page's link names. Raises SystemExit where there is none."""
    found = (ROOT / page.parent / target).resolve()
    if not found.is_file() or ROOT not in found.parents:
        raise SystemExit(f"{page}: there is no {target}")
    return PurePosixPath(found.relative_to(ROOT).as_posix())


def linked_in_site(page: PurePosixPath, out: Path, text: str) -> str:
    """The text of a page, its links as they are in the site; files that they name are copied."""
    def link(found: re.Match[str]) -> str:
        target, _, anchor = found[1].partition("#")
        if not target or re.match(r"[a-z]+:", target):
            return found[0]
        source = resolved(page, target)
        place = name_in_site(source)
        if place.suffix != ".md":
            copy(ROOT / source, out / place)
        up = "../" * (len(name_in_site(page).parts) - 1)
        return f"]({up}{place}{'#' + anchor if anchor else ''})"
    blocks = re.split(r"(^```.*?^```$)", text, flags=re.M | re.S)  # code is left alone
    return "".join(block if block.startswith("```") else _LINK.sub(link, block) for block in blocks)


def copy(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def contents(names: list[str], caption: str = "", depth: int = 1) -> str:
    """A list of pages for the side of the site, not shown on the page itself."""
    options = [":hidden:", f":maxdepth: {depth}", *([f":caption: {caption}"] if caption else [])]
    entries = [f"{TITLES[name]} <{name}>" if name in TITLES else name for name in names]
    return "\n```{toctree}\n" + "\n".join([*options, "", *entries]) + "\n```\n"


def add_pages(out: Path) -> list[str]:
    """Every page of the repository. Returns their names in the site."""
    pages = [*sorted(DOCS.rglob("*.md")), *(ROOT / name for name in BESIDE)]
    for path in pages:
        page = PurePosixPath(path.relative_to(ROOT).as_posix())
        target = out / name_in_site(page)
        target.parent.mkdir(parents=True, exist_ok=True)
        text = linked_in_site(page, out, path.read_text(encoding="utf-8"))
        target.write_text(site_clips.with_videos(text, DOCS / "pictures", out), encoding="utf-8")
    return [str(name_in_site(PurePosixPath(path.relative_to(ROOT).as_posix())).with_suffix("")) for path in pages]


def add_contents(out: Path, names: list[str]) -> None:
    """The order of the pages, at the end of the start page and of the lessons' one."""
    lessons = [f"lessons/{name}" for name in LESSONS]
    known = {name for part in PARTS.values() for name in part} | set(lessons) | {"index"}
    parts = {**PARTS, "The project": PARTS["The project"] + sorted(set(names) - known)}
    with (out / "index.md").open("a", encoding="utf-8") as page:
        page.writelines(contents(part, caption) for caption, part in parts.items())
    with (out / "lessons" / "index.md").open("a", encoding="utf-8") as page:
        page.write(contents(LESSONS))


def add_python(out: Path) -> None:
    """Pages that Sphinx fills from the docstrings."""
    folder = out / "reference"
    names = []
    lines = ["# Python", "", "What `import rumple_native` gives, and the layer over it that the add-on uses. Both need "
             "only NumPy. Arrays are C-contiguous float32 or int32; lengths are in the units of the positions. Bad "
             "input raises `ValueError`, which names the argument and the first bad element.", ""]
    for title, (package, modules) in PYTHON.items():
        lines += [f"## {title}", ""]
        for module in modules:
            name = f"python_{package}_{module}".replace(".", "_")
            (folder / f"{name}.md").write_text(
                f"# rumple.{package}.{module}\n\n```{{eval-rst}}\n.. automodule:: rumple.{package}.{module}\n```\n")
            lines.append(f"- [rumple.{package}.{module}]({name}.md)")
            names.append(name)
        lines.append("")
    (folder / "python.md").write_text("\n".join(lines) + contents(names))


def add_c(out: Path) -> None:
    """The C header as pages."""
    folder = out / "reference"
    folder.mkdir(parents=True, exist_ok=True)
    pages = site_header.pages(ROOT / "native" / "include")
    for name, text in pages.items():
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
    with (folder / "c.md").open("a", encoding="utf-8") as page:
        page.write(contents([name for name in pages if name != "c"]))


def main() -> None:
    out = Path(sys.argv[1])
    shutil.copytree(DOCS / "pictures", out / "pictures", ignore=shutil.ignore_patterns("*.py", "*.md"))
    shutil.copytree(DOCS / "site", out, dirs_exist_ok=True)
    copy(DOCS / "pictures" / "icon.png", out / "_static" / "icon.png")
    names = add_pages(out)
    add_contents(out, names)
    add_c(out)
    add_python(out)


if __name__ == "__main__":
    main()
