# SPDX-License-Identifier: GPL-3.0-or-later
"""Bare, Rumple and the simulation side by side: sheet.png and numbers.json of scripts/ground_truth.

Rumple's surface is read where the simulation's vertices are: at rest, before cloth hangs, each of them finds its
place on Rumple's mesh, and keeps it. So all three are measured on the same vertices.
"""
from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
import truth_clip  # noqa: E402
import truth_measures  # noqa: E402
from contact_sheet import compose, frame_camera, studio  # noqa: E402
from truth_run import arguments, open_scene, say  # noqa: E402

SHEET_FRAMES, MEASURED_FRAMES = 5, 24
ROWS = ("bare", "Rumple", "simulation")


@dataclass
class Shown:
    """A garment's surface as it is drawn."""

    positions: np.ndarray  # (n, 3) world space, metres
    starts: np.ndarray
    corners: np.ndarray


@dataclass
class Played:
    """What Rumple did in the frames that were asked for."""

    sampled: dict[int, np.ndarray] = field(default_factory=dict)  # (n, 3) at the simulation's vertices, metres
    shown: dict[int, Shown] = field(default_factory=dict)
    bare_ms: float = 0.0  # of a whole frame without the wrinkles, processor time
    frame_ms: float = 0.0  # with them
    solve_ms: float = 0.0  # of which the add-on
    largest_gap: float = 0.0  # metres: largest distance of a simulation's vertex from Rumple's mesh at rest


def evenly(frames: np.ndarray, count: int) -> list[int]:
    """At most count of the frames, the first and the last among them."""
    return sorted({int(frames[round(k)]) for k in np.linspace(0, len(frames) - 1, min(count, len(frames)))})


def evaluated(garment: bpy.types.Object) -> Shown:
    """The garment as its modifiers leave it now."""
    shown = garment.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return Shown(truth_clip.evaluated_positions(garment), *truth_clip.faces_of(shown.data))


def rest_surface(garment: bpy.types.Object, frame: int) -> Shown:
    """The mesh that Rumple shows now, as it is before anything is solved."""
    from rumple.blender.objects import modifier, runtimes, viewport_mesh
    armature = truth_clip.skinned_by(garment).data
    armature.pose_position = "REST"
    bpy.context.scene.frame_set(frame)
    drawn = evaluated(garment)
    armature.pose_position = "POSE"
    meshes = viewport_mesh.solved_for(modifier.find(garment), runtimes.of(garment).evaluator)
    fine = next(mesh for mesh in meshes if len(mesh.positions_rest) == len(drawn.positions))
    return Shown(truth_clip.in_world(garment, fine.positions_rest), drawn.starts, drawn.corners)


def places_on(surface: Shown, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """For points (n, 3) the nearest triangle's vertices (n, 3), barycentrics (n, 3), and the largest distance."""
    triangles, _ = truth_clip.triangles_of(surface.starts, surface.corners)
    tree = BVHTree.FromPolygons(surface.positions.tolist(), triangles.tolist())
    found = [tree.find_nearest(point) for point in points.tolist()]
    corners = triangles[[hit[2] for hit in found]]
    a, b, c = (surface.positions[corners[:, k]].astype(np.float64) for k in range(3))
    to_plane = np.linalg.pinv(np.stack([b - a, c - a], axis=2))
    uv = np.einsum("nij,nj->ni", to_plane, np.array([tuple(hit[0]) for hit in found]) - a)
    return corners, np.column_stack([1.0 - uv.sum(1), uv]), max(hit[3] for hit in found)


def pace(frames: np.ndarray) -> float:
    """Processor milliseconds of a frame change, mean of the clip's first frames."""
    began = time.process_time()
    for frame in frames[:30].tolist():
        bpy.context.scene.frame_set(frame)
    return 1e3 * (time.process_time() - began) / len(frames[:30])


def play(garment: bpy.types.Object, rest: np.ndarray, frames: np.ndarray, wanted: set[int],
         pictured: set[int]) -> Played:
    """Add Wrinkle Mesh with one click and play every frame in order. rest (n, 3): the simulation's vertices."""
    scene = bpy.context.scene
    played = Played(bare_ms=pace(frames))
    bpy.context.view_layer.objects.active = garment
    if bpy.ops.object.rumple_add(method="MESH") != {"FINISHED"}:
        raise SystemExit(garment.rumple.message)
    from rumple.blender.objects import runtimes
    corners, shares, played.largest_gap = places_on(rest_surface(garment, int(frames[0])), rest)
    whole, solving = [], []
    for frame in frames.tolist():
        began = time.process_time()
        scene.frame_set(frame)
        whole.append(1e3 * (time.process_time() - began))
        runtime = runtimes.of(garment)
        if runtime.message or runtime.result is None:
            raise SystemExit(f"frame {frame}: {runtime.message or 'nothing was solved'}")
        solving.append(sum(runtime.result.milliseconds.values()))
        if frame in wanted | pictured:
            here = evaluated(garment)
            played.sampled[frame] = np.einsum("nk,nkj->nj", shares, here.positions[corners])
            if frame in pictured:
                played.shown[frame] = here
    played.frame_ms, played.solve_ms = float(np.mean(whole)), float(np.mean(solving))
    return played


def measure(stored: Any, played: Played, wanted: list[int]) -> dict[str, list[dict[str, float]]]:
    """Numbers of every row at the frames wanted."""
    cloth = truth_measures.build_cloth(stored["rest"], stored["triangles"], stored["patch"])
    first = int(stored["frames"][0])
    rows: dict[str, list[dict[str, float]]] = {name: [] for name in ROWS}
    base, simulated = stored["base"], stored["positions"]
    for frame in wanted:
        here = base[frame - first]
        for name, fine in zip(ROWS, (here, played.sampled[frame], simulated[frame - first])):
            rows[name].append({"frame": frame, **truth_measures.measures(cloth, here, fine)})
    return rows


def means(rows: dict[str, list[dict[str, float]]]) -> dict[str, dict[str, float]]:
    """Over the frames, those left out that have no number."""
    result = {}
    for name, frames in rows.items():
        keys = [key for key in frames[0] if key != "frame"]
        table = np.array([[row[key] for key in keys] for row in frames])
        known = np.isfinite(table)
        total = np.where(known, table, 0.0).sum(0) / np.maximum(known.sum(0), 1)
        result[name] = {k: float(v) if n else None for k, v, n in zip(keys, total, known.any(0))}
    return result


def draw(garment: bpy.types.Object, rows: dict[str, dict[int, Shown]], frames: np.ndarray, out: Path,
         stacked: int | None = None, width: int | None = None) -> None:
    """One column a frame, one row a surface, each in the garment's place before the same camera. stacked: surfaces
    in a column, all of them unless it is said. width: of a tile, pixels; narrower ones are cut at the sides."""
    scene = bpy.context.scene
    studio(scene)
    scene.render.resolution_x = width or scene.render.resolution_x
    frame_camera(garment, range(int(frames[0]), int(frames[-1]) + 1))
    garment.hide_render = True
    tiles = []
    for frame in next(iter(rows.values())):
        scene.frame_set(frame)
        for name, surfaces in rows.items():
            shown = surfaces[frame]
            mesh = bpy.data.meshes.new("Shown")
            ends = np.append(shown.starts, len(shown.corners))
            mesh.from_pydata(shown.positions.tolist(), [],
                             [shown.corners[a:b].tolist() for a, b in zip(ends[:-1], ends[1:])])
            mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
            for material in garment.data.materials:
                mesh.materials.append(material)
            stand = bpy.data.objects.new("Shown", mesh)
            scene.collection.objects.link(stand)
            path = out / f".tile_{frame}_{name}.png"
            scene.render.filepath = str(path)
            bpy.ops.render.render(write_still=True)
            bpy.data.objects.remove(stand)
            tiles.append((f"frame {frame}, {name}", path))
    compose(tiles, stacked or len(rows), out / "sheet.png")
    for _, path in tiles:
        path.unlink()


def table(numbers: dict[str, dict[str, float]]) -> list[str]:
    """Lines for the screen: one row a number, one column a surface."""
    lines = [f"{'':30}" + "".join(f"{name:>12}" for name in numbers)]
    for key in next(iter(numbers.values())):
        cells = [numbers[name][key] for name in numbers]
        lines.append(f"{key:30}" + "".join(f"{'-' if c is None else format(c, '.3f'):>12}" for c in cells))
    return lines


def main() -> None:
    options = arguments()
    rumple.register()
    open_scene(options.scene)
    stored = np.load(options.out / "truth.npz", allow_pickle=False)
    stored = {key: stored[key] for key in stored.files}
    frames, first = stored["frames"], int(stored["frames"][0])
    wanted, pictured = evenly(frames, MEASURED_FRAMES), evenly(frames, SHEET_FRAMES)
    garment = truth_clip.find_garment(options.garment)
    played = play(garment, stored["rest"], frames, set(wanted), set(pictured))
    rows = measure(stored, played, wanted)
    numbers = means(rows)
    for name, value in zip(ROWS, (played.bare_ms, played.frame_ms, 1e3 * float(stored["seconds"]))):
        numbers[name]["frame_ms"] = value
    for line in table(numbers):
        say(line)
    say(f"of Rumple's frame {played.solve_ms:.1f} ms are the add-on's; its mesh at rest is at most "
        f"{1e3 * played.largest_gap:.2f} mm from the simulation's")
    faces = stored["starts"], stored["corners"]
    draw(garment, dict(zip(ROWS, (
        {frame: Shown(stored["base"][frame - first], *faces) for frame in pictured}, played.shown,
        {frame: Shown(stored["positions"][frame - first], *faces) for frame in pictured}))), frames, options.out)
    report = dict(about=dict(scene=options.scene, garment=garment.name, vertices=len(stored["rest"]),
                             rumple_solve_ms=played.solve_ms, settings=json.loads(str(stored["settings"]))),
                  means=numbers, frames=rows)
    (options.out / "numbers.json").write_text(json.dumps(report, indent=1).replace("NaN", "null") + "\n")


if __name__ == "__main__":
    main()
