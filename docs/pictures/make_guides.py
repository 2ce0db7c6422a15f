# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture of guides for the user guide, guides.jpg: the skirt of the lessons without guides, with pleats along one
curve, and with knife pleats and a seam that puckers.

    RUMPLE_NATIVE=build/release/python blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_guides.py
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
from rumple.blender import scheduler  # noqa: E402
from rumple.blender.objects import runtimes  # noqa: E402

FRAME = 14  # in the turn
SIZE = 380, 460
SEAM_RING = 3  # of the skirt's rings: the seam of a yoke


def guide(skirt: bpy.types.Object, kind: str) -> None:
    """Nine folds down its front."""
    bpy.ops.object.select_all(action="DESELECT")
    skirt.select_set(True)
    bpy.context.scene.cursor.location = (0.0, -0.4, 0.72)
    assert bpy.ops.object.rumple_guide_add() == {"FINISHED"}
    curve = next(child for child in skirt.children if child.type == "CURVE")
    points = curve.data.splines[0].bezier_points
    front = SKIRT_AROUND * 3 // 4  # towards -y
    rings = np.linspace(SEAM_RING + 1, SKIRT_ALONG - 1, len(points)).round().astype(int)
    for point, ring in zip(points, rings):
        point.co = skirt.data.vertices[int(ring) * SKIRT_AROUND + front].co
    about = curve.rumple_guide
    about.kind, about.count, about.spacing, about.depth = kind, 9, 0.045, 0.016


def seam(skirt: bpy.types.Object) -> None:
    """Round the yoke."""
    for edge in skirt.data.edges:
        edge.use_seam = all(vertex // SKIRT_AROUND == SEAM_RING for vertex in edge.vertices)
    skirt.data.update_tag()
    skirt.rumple_guide.seam_depth, skirt.rumple_guide.seam_spacing = 0.005, 0.025


def shown(name: str, folder: Path) -> Path:
    """The skirt in the turn, with guides of that name."""
    bpy.ops.wm.read_homefile(use_empty=True)
    skirt = build_skirt_scene()
    bpy.context.view_layer.objects.active = skirt
    skirt.rumple.mesh.wavelength = 0.04
    assert bpy.ops.object.rumple_add(method="MESH") == {"FINISHED"}
    skirt.rumple.mesh.wavelength = 0.04
    if name.startswith("Pleats"):
        guide(skirt, "PLEATS")
    elif name.startswith("Knife"):
        guide(skirt, "KNIFE")
        seam(skirt)
    scheduler.sync_all()
    scene = bpy.context.scene
    scene.frame_set(FRAME)
    assert not skirt.rumple.message, skirt.rumple.message
    fine = runtimes.of(skirt)
    print("GUIDES", name, fine.evaluator.vertex_count, fine.evaluator.status(fine.result))
    camera = scene.camera
    turn = bpy.data.objects[skirt.parent.name].rotation_euler.z
    view = Vector((0.35 * np.cos(turn) + 1.6 * np.sin(turn), 0.35 * np.sin(turn) - 1.6 * np.cos(turn), 0.25))
    camera.location, camera.data.lens = Vector((0.0, 0.0, 0.75)) + view, 60.0
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
        tiles = [(name, shown(name, folder)) for name in (
            "No guides", "Pleats along one curve", "Knife pleats, and a seam that puckers")]
        compose(tiles, 1, folder / "sheet.png")
        Image.open(folder / "sheet.png").save(HERE / "guides.jpg", quality=82, optimize=True)


if __name__ == "__main__":
    main()
