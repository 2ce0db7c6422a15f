# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks what a worker lacks for the open file, and describes it."""
from __future__ import annotations

import glob
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Iterator

import bpy

from ...core.files import clip_folder
from ...native import NativeMissing, kernels
from ...native.library import lib
from ..bake import clip
from ..frame import clip_status
from ..nodes import wrinkle_tree
from ..objects import bodies, modifier
from . import plan, source


@dataclass
class Finding:
    """One problem. kind: one word for programs. lacks: the worker cannot do its work."""

    kind: str
    text: str
    lacks: bool = True


def findings(garments: list[bpy.types.Object], to_bake: bool) -> list[Finding]:
    """All findings, the most serious first. to_bake: outdated or missing clips are only notes."""
    found = [*_programs(), *_files(), *_garments(garments, to_bake), *_disk(garments)]
    return sorted(found, key=lambda finding: not finding.lacks)


def _programs() -> Iterator[Finding]:
    try:
        lib.open()
    except NativeMissing as error:
        yield Finding("library", str(error))
    made = tuple(bpy.data.version)
    if made[:2] > bpy.app.version[:2]:
        yield Finding("blender", f"the file was saved by Blender {made[0]}.{made[1]}, and this is "
                      f"{bpy.app.version_string}: use {made[0]}.{made[1]} or later")
    elif made[:2] < bpy.app.version[:2]:
        yield Finding("blender", f"the file was saved by Blender {made[0]}.{made[1]}, this is "
                      f"{bpy.app.version_string}: a pose may differ in its last bits", lacks=False)
    for group in bpy.data.node_groups:
        if wrinkle_tree.is_ours(group) and group[wrinkle_tree.VERSION_KEY] > wrinkle_tree.VERSION:
            yield Finding("addon", f"the file was made by a later Rumple than {kernels.__version__}, which is here: "
                          "install that one")
            break
    text = scripts_not_run()
    if text:
        yield Finding("scripts", text)


def scripts_not_run() -> str:
    """A message if scripts of the open file were not run; otherwise empty."""
    if not bpy.app.autoexec_fail:
        return ""
    return (f"Python of the file was not run ({bpy.app.autoexec_fail_message}), so its rig may stand elsewhere: give "
            "--enable-autoexec")


def _files() -> Iterator[Finding]:
    missing = {bpy.path.abspath(library.filepath) for library in bpy.data.libraries
               if not Path(bpy.path.abspath(library.filepath)).is_file()}
    for path in sorted(missing):
        yield Finding("linked", f"the linked file {path} is missing: everything from it is too")
    clips = set(map(clip_status.clip_path, (obj for obj, _ in modifier.wrinkled_objects())))
    # as paths, because Blender may spell them differently
    caches, said = set(source.caches()), {Path(text) for text in missing}
    named = {*map(str, caches), *bpy.utils.blend_paths(absolute=True, packed=False, local=False)}
    for text in sorted({str(Path(text)): text for text in sorted(named)}.values()):
        if Path(text) in said | clips or _is_there(text):
            continue
        poses, image = Path(text) in caches, Path(text).suffix.lower() in bpy.path.extensions_image
        yield Finding("image" if image else "cache" if poses else "file", f"the file {text} is missing", lacks=poses)


def _is_there(text: str) -> bool:
    """Whether a file exists. For tiles and sequences: any file of them."""
    if Path(text).exists():
        return True
    pattern = re.sub(r"<[A-Z]+>|#+", "*", glob.escape(text))
    return pattern != glob.escape(text) and any(glob.iglob(pattern))


def _garments(garments: list[bpy.types.Object], to_bake: bool) -> Iterator[Finding]:
    for obj in garments:
        nodes_mod = modifier.find(obj)
        refused = bodies.refusal(obj)
        if refused:
            yield Finding("garment", refused)
        if not nodes_mod.show_viewport:
            yield Finding("garment", f"{obj.name}: its modifier {nodes_mod.name} is off in the viewport: no bake can "
                          "be made")
        if not obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).is_evaluated:
            yield Finding("garment", f"{obj.name}: it is hidden: show it, or it cannot be baked nor published",
                          lacks=to_bake)
        output = modifier.output_object(nodes_mod)
        if modifier.is_baked(nodes_mod) and output is not None:
            text = clip_status.check(obj, output)
            if text:
                yield Finding("clip", text, lacks=not to_bake)  # a bake repairs it
        late = clip_status.late_in_renders(obj) if not modifier.is_baked(nodes_mod) else ""
        if late:
            yield Finding("garment", late, lacks=False)


def _disk(garments: list[bpy.types.Object]) -> Iterator[Finding]:
    """Free space for the clips that are still to be baked, for each folder."""
    needed: dict[Path, int] = {}
    for obj in garments:
        path = clip.new_clip_path(obj)
        if not path.is_file():
            needed[path.parent] = needed.get(path.parent, 0) + plan.bytes_of(obj)
    for folder, count in needed.items():
        there = folder
        while not there.exists() and there != there.parent:
            there = there.parent
        if not there.is_dir():
            yield Finding("folder", f"{folder} cannot be made: {there} is no folder")
            continue
        free = shutil.disk_usage(there).free
        if free < count:
            yield Finding("disk", f"the clips to come need about {clip_folder.megabytes(count)} MB, and the disk of "
                          f"{folder} has {clip_folder.megabytes(free)} MB left")
        if not clip_folder.can_write(there):
            yield Finding("folder", f"nothing can be written to {there}: change its permissions, or choose another "
                          "folder with --out")
