# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the listing, 1920 x 1080: a jump of ../shared/data, bare and as cloth; listing.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_listing.py
"""
from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import bpy
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent))
import make_systems  # noqa: E402

FIRST, FRAME = 9, 51
HALF = (960, 1080)


def main() -> None:
    make_systems.rumple.register()
    sheet = Image.new("RGB", (2 * HALF[0], HALF[1]))
    with tempfile.TemporaryDirectory() as folder:
        for i, method in enumerate((None, "MESH")):
            bpy.ops.wm.open_mainfile(filepath=str(make_systems.ROOT.parent / "shared/data/S2_squat_trousers.blend"))
            for garment in ("trousers", "sweater") if method else ():
                bpy.context.view_layer.objects.active = bpy.data.objects[garment]
                assert bpy.ops.object.rumple_add(method=method) == {"FINISHED"}
            for frame in range(FIRST, FRAME + 1):
                bpy.context.scene.frame_set(frame)
            path = Path(folder) / f"{i}.png"
            make_systems.look(path, 55.0, HALF)
            sheet.paste(Image.open(path).convert("RGB"), (i * HALF[0], 0))
    sheet.save(make_systems.HERE / "listing.jpg", quality=90)


if __name__ == "__main__":
    main()
