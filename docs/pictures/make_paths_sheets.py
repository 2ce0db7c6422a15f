# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact sheets of the Wrinkle Paths on ../shared/data, over the full length of the clips: s1_paths.jpg to
s3_paths.jpg beside this file.

    scripts/build
    RUMPLE_NATIVE=build/release/python xvfb-run -a blender -b --factory-startup --python-exit-code 1 \
        --python docs/pictures/make_paths_sheets.py

Rows: bare; in live order; with the labels of the whole clip; with the rest pose withheld, from nothing but the
positions of every frame; with noise of a millimetre on every vertex in every frame. Every frame of every clip is
solved and checked: paths on the surface, nothing that is not finite.
"""
from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(ROOT / "addon"), str(ROOT / "scripts"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
import rumple_native as native  # noqa: E402
from contact_sheet import compose, studio  # noqa: E402
from rumple.blender.objects import mesh_reader  # noqa: E402
from rumple.core.frame.engine import BaseMesh  # noqa: E402
from rumple.core.settings.system_settings import PathsSettings  # noqa: E402
from rumple.core.systems.wrinkle_paths import WrinklePaths, suggested_width  # noqa: E402

FRONT, BACK = Vector((-0.5, -1.0, 0.15)).normalized(), Vector((0.5, 1.0, 0.2)).normalized()
SCENES = {  # file, garments, frames and where they are seen from
    "s1": ("S1_walk_shirt", ("shirt", "trousers"), ((20, BACK), (50, FRONT), (80, BACK), (110, BACK), (150, FRONT))),
    "s2": ("S2_squat_trousers", ("sweater", "trousers"),
           ((1, FRONT), (25, BACK), (36, FRONT), (59, BACK), (127, FRONT))),
    "s3": ("S3_skirt_sim", ("tee", "skirt"), ((1, FRONT), (40, FRONT), (75, BACK), (118, FRONT), (160, FRONT))),
}
ROWS = ("bare", "live", "whole clip", "rest pose withheld", "noise of 1 mm")
NOISE = 1e-3  # metres
LENS = 85.0


class Garment:
    """A garment's base, and its posed positions in every frame."""

    def __init__(self, name: str, frames: range) -> None:
        self.object = bpy.data.objects[name]
        self.base = mesh_reader.base_mesh(self.object, "REST_POSE", "")
        self.poses = []
        for frame in frames:
            bpy.context.scene.frame_set(frame)
            mesh = self.object.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
            self.poses.append(mesh_reader.compat.positions(mesh))
        self.object.hide_render = True
        self.shown: bpy.types.Object | None = None

    def folded(self, row: str, wanted: list[int], rate: float) -> dict[int, tuple[BaseMesh, np.ndarray]]:
        """The shown mesh of the wanted frames (counted from 0): its model and its positions."""
        base, poses = self.base, self.poses
        settings = PathsSettings(width=suggested_width(base, 1.0))
        options = native.WrinklePathsSettings()
        options.width = settings.width
        if row == "rest pose withheld":
            base, options.reference = replace(base, positions=poses[0]), "FIRST_FRAME"
        if row == "noise of 1 mm":
            noise = np.random.default_rng(1).normal(0.0, NOISE, (len(poses), *poses[0].shape))
            poses = list(np.ascontiguousarray(poses + noise, np.float32))
        fine = WrinklePaths.build(base, settings)
        paint, state, out = native.WrinklePathsPaint(fine.model), None, {}
        labels = [None] * len(poses)
        if row == "whole clip":
            labels = native.label_clip(fine.model, options, np.arange(len(poses)) / rate, np.concatenate(poses))
        for frame, pose in enumerate(poses):
            state, _ = native.solve_wrinkle_paths(fine.model, options, paint, pose, frame / rate, state, labels[frame])
            assert native.wrinkle_path_fault(state) == "", (self.object.name, row, frame)
            if frame in wanted:
                options.height = 0.0 if row == "bare" else 1.0
                out[frame] = fine, native.show_wrinkle_paths(fine.model, options, pose, state).positions
                assert np.isfinite(out[frame][1]).all(), (self.object.name, row, frame)
        return out

    def show(self, fine: WrinklePaths, positions: np.ndarray) -> None:
        """Put a shown mesh in the garment's place."""
        if self.shown:
            bpy.data.objects.remove(self.shown)
        mesh = bpy.data.meshes.new("Shown")
        mesh.from_pydata(positions.tolist(), [], fine.corner_vertex.reshape(-1, 4).tolist())
        mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
        mesh.materials.append(self.object.data.materials[0])
        self.shown = bpy.data.objects.new("Shown", mesh)
        bpy.context.scene.collection.objects.link(self.shown)


def look_at(points: np.ndarray, direction: Vector) -> None:
    """The scene's camera sees all points."""
    camera = bpy.context.scene.camera
    low, high = points.min(0), points.max(0)
    middle, radius = Vector((low + high) / 2), float(np.linalg.norm(high - low)) / 2
    camera.location = middle + direction * (1.75 * radius * LENS / 36.0)
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()


def sheet(key: str, folder: Path) -> None:
    """The contact sheet of one scene."""
    file, names, views = SCENES[key]
    bpy.ops.wm.open_mainfile(filepath=str(ROOT.parent / "shared" / "data" / f"{file}.blend"))
    scene = bpy.context.scene
    garments = [Garment(name, range(scene.frame_start, scene.frame_end + 1)) for name in names]
    studio(scene)
    shading = scene.display.shading
    shading.show_shadows, shading.show_cavity, shading.cavity_type = False, True, "BOTH"
    shading.cavity_ridge_factor = shading.cavity_valley_factor = 1.5
    if "outdoor.sl" in {light.name for light in bpy.context.preferences.studio_lights}:
        shading.studio_light = "outdoor.sl"
    scene.render.resolution_x, scene.render.resolution_y = 300, 400
    scene.camera = bpy.data.objects.new("View", bpy.data.cameras.new("View"))
    scene.collection.objects.link(scene.camera)
    scene.camera.data.lens = LENS
    wanted = [frame - scene.frame_start for frame, _ in views]
    tiles: dict[tuple[int, str], Path] = {}
    for row in ROWS:
        folded = [garment.folded(row, wanted, scene.render.fps) for garment in garments]
        for frame, (number, direction) in zip(wanted, views):
            scene.frame_set(number)
            for garment, shown in zip(garments, folded):
                garment.show(*shown[frame])
            look_at(np.concatenate([garment.poses[frame] for garment in garments]), direction)
            tiles[frame, row] = folder / f"{key} {row} {number}.png"
            scene.render.filepath = str(tiles[frame, row])
            bpy.ops.render.render(write_still=True)
    compose([(f"{number}, {row}", tiles[frame, row]) for frame, (number, _) in zip(wanted, views) for row in ROWS],
            len(ROWS), folder / f"{key}.png")
    from PIL import Image
    Image.open(folder / f"{key}.png").save(HERE / f"{key}_paths.jpg", quality=85, optimize=True)


rumple.register()
with tempfile.TemporaryDirectory() as place:
    for scene_key in SCENES:
        sheet(scene_key, Path(place))
