# SPDX-License-Identifier: GPL-3.0-or-later
"""Blend files that `attach` saved: each counts as the file that its clips were baked from. No bpy here.

A note beside the clips has the digest of the saved file in its name and that of the former one as its text. Whoever
else saves the file changes its bytes, so the note is of another file then.
"""
from __future__ import annotations

import re
from pathlib import Path
from typing import Iterable

from . import clip_folder


def write_note(folder: Path, saved: bytes, counts_as: bytes) -> None:
    """saved, counts_as: digests of the bytes of two files. Raises OSError."""
    with clip_folder.written(_note(folder, saved)) as note:
        note.write_text(counts_as.hex())


def counts_as(folders: Iterable[Path], content: bytes) -> bytes:
    """The digest that stands for a file of this digest: its own, where none of the folders has a note of it."""
    for folder in folders:
        try:
            with open(_note(folder, content), encoding="ascii") as note:
                text = note.read(2 * len(content) + 1)
        except (OSError, ValueError):
            continue
        if re.fullmatch(rf"[0-9a-f]{{{2 * len(content)}}}", text):
            return bytes.fromhex(text)
    return content


def _note(folder: Path, saved: bytes) -> Path:
    return folder / f".attached-{saved.hex()}"
