# SPDX-License-Identifier: GPL-3.0-or-later
"""Sphinx's settings for scripts/site. Nothing of the site is loaded from elsewhere."""
from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

ADDON = Path(os.environ["SPHINX_ADDON"])
sys.path.insert(0, str(ADDON))

project = "Rumple"
copyright = "Rumple authors, GPL-3.0-or-later"
version = release = re.search(r'(?m)^version = "(.+)"', (ADDON / "rumple/blender_manifest.toml").read_text())[1]
extensions = ["myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["files"]
highlight_language = "none"
suppress_warnings = ["misc.highlighting_failure"]  # JSON with dots for what is left out

myst_heading_anchors = 4  # as a forge names them

html_theme, html_theme_path = "theme", ["."]  # its own: Debian's Furo has no dark colours, and a script that breaks off
html_title = f"Rumple {version}"
html_static_path = ["_static"]
html_permalinks_icon = "#"
html_copy_source = html_show_sourcelink = html_use_index = html_domain_indices = False

autodoc_default_options = {"members": True, "exclude-members": "POINTER, VIEW, FREE, LOOK"}
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"


def plain(_app: Any, _what: str, _name: str, _of: Any, _options: Any, lines: list[str]) -> None:
    """Docstrings are plain text: what would be a mark of reStructuredText is a letter."""
    lines[:] = [re.sub(r"([\\*`|_])", r"\\\1", line) if not line.startswith("    ") else line for line in lines]


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", plain)
