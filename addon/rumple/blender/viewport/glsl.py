# SPDX-License-Identifier: GPL-3.0-or-later
"""The GLSL files of the folder shaders/. They are joined in Python, because Blender's GLSL cannot include our files."""
from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

# In the installed add-on the folder is beside its modules, in the source tree at the top.
_FOLDERS = tuple(Path(os.path.abspath(__file__)).parents[up] / "shaders" for up in (2, 4))
FORMULAS = ("shared/tangents", "shared/wrinkle_field", "shared/wrinkle_field_picture")  # of the Wrinkle Field
FOLDS = ("shared/pn_triangle", "shared/wrinkle_paths")  # of the Wrinkle Paths


@lru_cache(maxsize=None)
def text(name: str) -> str:
    """One file, by its name below shaders/ without .glsl. Raises FileNotFoundError."""
    folder = next((folder for folder in _FOLDERS if folder.is_dir()), _FOLDERS[0])
    return (folder / f"{name}.glsl").read_text(encoding="utf-8")


def source(*names: str) -> str:
    """These files one after the other, the formulas ready for GLSL."""
    words = "#define FORMULA\n#define REAL float\n#define BOOL bool\n#define nearest_integer round\n"
    return words + "\n".join(text(name) for name in names)
