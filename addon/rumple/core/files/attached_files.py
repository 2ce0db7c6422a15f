# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes about blend files that `attach` saved: such a file counts as the file that its clips were baked from.

A note lies beside the clips. Its name contains the digest of the saved file, its text is the digest of the original
file. If anyone saves the file again, its bytes change, and the note no longer applies to it. Never imports bpy.
"""
from __future__ import annotations

import re
from pathlib import Path
from typing import Iterable

from . import clip_folder


def write_note(folder: Path, saved: bytes, counts_as: bytes) -> None:
    """Write the note. saved, counts_as: digests of the bytes of the two files. Raises OSError."""
    with clip_folder.written(_note(folder, saved)) as note:
        note.write_text(counts_as.hex())


def counts_as(folders: Iterable[Path], content: bytes) -> bytes:
    """The digest that the file counts as. It is its own digest where no folder has a note about it."""
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
