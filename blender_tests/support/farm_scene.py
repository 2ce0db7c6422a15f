# SPDX-License-Identifier: GPL-3.0-or-later
"""A shot for the farm: a sleeve, a coat that is worn over it, and a scarf whose frames are independent. This file also
runs in a Blender of its own: blender -b --python farm_scene.py -- FILE.blend:FRAMES[:BROKEN]..."""
from __future__ import annotations

import os
import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parents[2] / "addon"),
                    os.environ["RUMPLE_NATIVE"]]
    import addon_utils
    addon_utils.enable("rumple", default_set=True)

import bpy  # noqa: E402
from support import sleeve  # noqa: E402

INNER, OUTER, FREE = "Sleeve", "Coat", "Scarf/.. a"  # the last one's name leads out of a folder


def garment(name: str, radius: float, frames: int) -> bpy.types.Object:
    obj = sleeve.another(name, radius)
    obj.rumple.bake_start, obj.rumple.bake_end = 1, frames
    return obj


def shot(frames: int = 8) -> None:
    """Three garments, in an empty file."""
    sleeve.empty_file()
    with sleeve.context():
        sleeve.arm()
    inner = garment(INNER, 1.0, frames)
    outer = garment(OUTER, 1.3, frames)
    outer.rumple.mesh.base_cloth, outer.rumple.body = "HANG", inner
    garment(FREE, 1.6, frames).rumple.mesh.stateless = True


def break_garment(name: str) -> None:
    """Its modifier is off, as artists leave it: no bake can be made."""
    next(m for m in bpy.data.objects[name].modifiers if m.type == "NODES").show_viewport = False


def save(file: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(file))


if __name__ == "__main__":
    for scene in sys.argv[sys.argv.index("--") + 1:]:
        name, count, *wrong = scene.split(":")
        shot(int(count))
        for one in wrong:
            break_garment(one)
        save(Path(name))
