# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the examples inside Blender: the demo's shirt and trousers with one click each, and the bare scenes of two
lessons. Started by scripts/examples.

The fine meshes are not in the file: they are made when it is opened. So it stays small.
"""
from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import demo_scene  # noqa: E402
import lesson_scenes  # noqa: E402
import rumple  # noqa: E402
from rumple.blender import handlers  # noqa: E402
from rumple.blender.objects import modifier, output_mesh  # noqa: E402

MOST_BYTES = 2_000_000
BODY_SPACING = 0.0095  # metres: the file stays small


def make(method: str, path: Path) -> None:
    """One file."""
    demo_scene.build_demo_scene(BODY_SPACING)
    garments = demo_scene.add_wrinkles(method)
    handlers.unregister()  # else the fine meshes are made again at once
    for nodes_mod in map(modifier.find, garments):
        modifier.set_output_object(nodes_mod, None, 0)
        modifier.set_viewport_output(nodes_mod, None)
    for hidden in [obj for obj in bpy.data.objects if output_mesh.KEY in obj]:
        modifier.delete_hidden(hidden)
    save(path)
    handlers.register()


def save(path: Path) -> None:
    """The scene as it is."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, copy=True)
    size = path.stat().st_size
    print(f"| {path.name} {size / 1e6:.2f} MB", flush=True)
    if size > MOST_BYTES:
        raise SystemExit(f"{path.name} is larger than {MOST_BYTES} bytes")


def main() -> None:
    rumple.register()
    out = Path(sys.argv[-1])
    make("MESH", out / "Shirt.blend")
    bpy.ops.wm.read_homefile(use_empty=True)
    lesson_scenes.build_skirt_scene()
    save(out / "Skirt.blend")
    bpy.ops.wm.read_homefile(use_empty=True)
    lesson_scenes.build_face_scene()
    save(out / "Face.blend")


if __name__ == "__main__":
    main()
