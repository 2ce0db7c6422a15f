# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture of edge creases and of the painted map Rigid for the user guide, rigid_patches.jpg: a skirt with a raised
plate in its front, as it is, with a creased rim, and painted Rigid.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_rigid_patches.py
"""
from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from contact_sheet import compose  # noqa: E402
from lesson_scenes import SKIRT_ALONG, SKIRT_AROUND, build_skirt_scene  # noqa: E402
from PIL import Image  # noqa: E402
from rumple.blender import compat, scheduler  # noqa: E402

FRAME = 14  # in the turn
SIZE = 380, 460
RAISED = 0.02  # metres
TILES = ("No crease, no paint", "The rim creased", "Painted Rigid, the rim creased")


def plate(skirt: bpy.types.Object) -> list[int]:
    """The vertices of the plate, which are moved outwards."""
    front, middle = SKIRT_AROUND * 3 // 4, SKIRT_ALONG // 2 + 1
    half = max(SKIRT_AROUND // 16, 2)
    chosen = [ring * SKIRT_AROUND + (front + column) % SKIRT_AROUND
              for ring in range(middle - half, middle + half + 1) for column in range(-half, half + 1)]
    for index in chosen:
        co = skirt.data.vertices[index].co
        co.xy *= 1.0 + RAISED / np.hypot(co.x, co.y)
    skirt.data.update()
    return chosen


def crease_rim(skirt: bpy.types.Object, chosen: list[int]) -> None:
    """Edges of the plate that have a face beside it."""
    mesh, inside = skirt.data, set(chosen)
    outer = {key for polygon in mesh.polygons if not inside.issuperset(polygon.vertices) for key in polygon.edge_keys}
    values = np.array([inside.issuperset(edge.vertices) and edge.key in outer for edge in mesh.edges], np.float32)
    compat.set_edge_marks(mesh, {"crease": values})
    for edge, sharp in zip(mesh.edges, values.tolist()):
        edge.use_edge_sharp = sharp > 0.0
    if compat.HAS_AUTO_SMOOTH:
        mesh.use_auto_smooth, mesh.auto_smooth_angle = True, np.pi


def shown(name: str, folder: Path) -> Path:
    """The skirt in the turn."""
    bpy.ops.wm.read_homefile(use_empty=True)
    skirt = build_skirt_scene()
    bpy.context.view_layer.objects.active = skirt
    chosen = plate(skirt)
    if name != TILES[0]:
        crease_rim(skirt, chosen)
    assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}
    skirt.rumple.mesh.wavelength = 0.04
    if name == TILES[2]:
        assert bpy.ops.object.rumple_paint(group="rigid") == {"FINISHED"}
        skirt.vertex_groups["Rumple Rigid"].add(chosen, 1.0, "REPLACE")
    scheduler.sync_all()
    scene = bpy.context.scene
    scene.frame_set(FRAME)
    assert not skirt.rumple.message, skirt.rumple.message
    turn = bpy.data.objects[skirt.parent.name].rotation_euler.z
    view = Vector((0.6 * np.cos(turn) + 1.5 * np.sin(turn), 0.6 * np.sin(turn) - 1.5 * np.cos(turn), 0.25))
    camera = scene.camera
    camera.location, camera.data.lens = Vector((0.0, 0.0, 0.72)) + view, 75.0
    camera.rotation_euler = (-view).to_track_quat("-Z", "Y").to_euler()
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.use_denoising = 16, 1, False
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    path = folder / f"{len(list(folder.iterdir()))}.png"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return path


def main() -> None:
    rumple.register()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        compose([(name, shown(name, folder)) for name in TILES], 1, folder / "sheet.png")
        Image.open(folder / "sheet.png").save(HERE / "rigid_patches.jpg", quality=82, optimize=True)


if __name__ == "__main__":
    main()
