#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/pair_habits.py BEFORE NOW: the trial's pictures (folder BEFORE) beside those of make_habits.py (folder
NOW), as docs/pictures/habits.jpg."""
from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image, ImageDraw

PAIRS = (("04_added", "added"), ("13_weight_painted", "painted"), ("55_stale_3s", "outside"),
         ("31_paths_overlay_curves", "overlay"))
SIZE, GAP, QUALITY = (800, 500), 8, 85


def main() -> None:
    folders = [Path(word) for word in sys.argv[1:3]]
    width, height = SIZE
    sheet = Image.new("RGB", (2 * width + GAP, len(PAIRS) * (height + GAP) - GAP), "white")
    for row, names in enumerate(PAIRS):
        for column, (folder, name) in enumerate(zip(folders, names)):
            picture = Image.open(folder / f"{name}.png").convert("RGB").resize(SIZE, Image.LANCZOS)
            ImageDraw.Draw(picture).text((60, height - 90), ("before", "now")[column], fill="white")
            sheet.paste(picture, (column * (width + GAP), row * (height + GAP)))
    sheet.save(Path(__file__).with_name("habits.jpg"), quality=QUALITY, optimize=True)


if __name__ == "__main__":
    main()
