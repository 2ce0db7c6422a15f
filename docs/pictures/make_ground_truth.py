# SPDX-License-Identifier: GPL-3.0-or-later
"""Bare, one click and simulation beside each other: ground_truth.jpg beside this file, of what scripts/ground_truth has
simulated before.

    scripts/ground_truth demo --garment trousers --frames 40-50 --lead 30+24
    scripts/ground_truth demo --garment shirt --frames 1-30 --lead 16+6
    scripts/ground_truth ../shared/data/S1_walk_shirt.blend --garment shirt --frames 60-63 --lead 30+24 # and trousers
    scripts/ground_truth ../shared/data/S2_squat_trousers.blend --garment trousers --frames 20-23 --lead 30+24
    scripts/ground_truth ../shared/data/S2_squat_trousers.blend --garment sweater --frames 20-23 --lead 30+24
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_ground_truth.py [-- FOLDER]  # of the simulations, out/ground_truth
"""
from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
import truth_clip  # noqa: E402
import truth_sheet  # noqa: E402
from truth_run import open_scene  # noqa: E402
from truth_sheet import Shown  # noqa: E402

PICTURED = (("demo", "trousers", 48), ("demo", "shirt", 22), ("S1_walk_shirt", "trousers", 63),
            ("S1_walk_shirt", "shirt", 63), ("S2_squat_trousers", "trousers", 23),
            ("S2_squat_trousers", "sweater", 23))
WIDTH = 400  # pixels of a tile


def row(name: str, garment_name: str, frame: int, folder: Path, out: Path) -> None:
    """sheet.png in out: three tiles."""
    data = ROOT.parent / "shared" / "data" / f"{name}.blend"
    if name == "demo":
        open_scene(name)
    else:
        bpy.ops.wm.open_mainfile(filepath=str(data))
    with np.load(folder / f"{name}_{garment_name}" / "truth.npz", allow_pickle=False) as file:
        frames, rest, base, simulated = (file[key] for key in ("frames", "rest", "base", "positions"))
        faces = file["starts"], file["corners"]
    garment, number = truth_clip.find_garment(garment_name), frame - int(frames[0])
    played = truth_sheet.play(garment, rest, frames[:number + 1], set(), {frame})
    title = f"{name.partition('_')[0]}'s {garment_name}"
    truth_sheet.draw(garment, {f"{title}, as animated": {frame: Shown(base[number], *faces)},
                               f"{title}, one click": played.shown,
                               f"{title}, simulation": {frame: Shown(simulated[number], *faces)}},
                     frames[:number + 1], out, stacked=1, width=WIDTH)


def main() -> None:
    from PIL import Image
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    folder = Path(words[0] if words else ROOT / "out" / "ground_truth")
    rumple.register()
    rows = []
    for name, garment, frame in PICTURED:
        with tempfile.TemporaryDirectory() as made:
            row(name, garment, frame, folder, Path(made))
            rows.append(Image.open(Path(made) / "sheet.png").convert("RGB"))
    wide, high = rows[0].size
    sheet = Image.new("RGB", (2 * wide, (len(rows) + 1) // 2 * high))
    for number, picture in enumerate(rows):
        sheet.paste(picture, (number % 2 * wide, number // 2 * high))
    small = sheet.resize((1680, round(1680 * sheet.height / sheet.width)), Image.LANCZOS)
    small.save(HERE / "ground_truth.jpg", quality=82)


if __name__ == "__main__":
    main()
