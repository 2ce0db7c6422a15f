# SPDX-License-Identifier: GPL-3.0-or-later
"""What one setting changes, for the guide: looks.webp, small because packages contain it. A walking figure after one
click for each garment, and with one setting of both garments changed. It needs ../shared/data.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_looks.py
"""
from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from make_cloth import FIGURE, compose, middles, open_scene, play, rumple, scheduler  # noqa: E402
from PIL import Image  # noqa: E402

CHANGES: tuple[tuple[str, dict[str, float]], ...] = (
    ("One click", {}), ("Slack 1.06", {"slack": 1.06}), ("Slack 0.96", {"slack": 0.96}),
    ("Bending Length 40 mm", {"bending_length": 0.04}), ("Wavelength 60 mm", {"wavelength": 0.06}),
    ("Detail 0", {"detail": 0.0}), ("Folds 2", {"folds": 2.0}),
    ("Room 1 cm, Slide 0", {"room": 0.01, "slide_room": 0.0}))


def main() -> None:
    rumple.register()
    at, tiles = middles(FIGURE), []
    with tempfile.TemporaryDirectory() as folder:
        for label, changed in CHANGES:
            open_scene(FIGURE, {})
            for name in FIGURE.garments:
                for setting, value in changed.items():
                    setattr(bpy.data.objects[name].rumple.mesh, setting, value)
            scheduler.sync_all()
            tiles += play(FIGURE, at, lambda _frame, label=label: label, Path(folder))
        compose(tiles, 2, Path(folder) / "sheet.png")
        sheet = Image.open(Path(folder) / "sheet.png").convert("RGB")
        sheet.thumbnail((1456, 1456))
        sheet.save(HERE / "looks.webp", quality=70, method=6)


if __name__ == "__main__":
    main()
