# SPDX-License-Identifier: GPL-3.0-or-later
"""One contender of scripts/bench in one scene: plays it inside Blender, stores where the simulation's vertices are.

CONTENDER.npz, with --variant (bench_variants.py) CONTENDER@VARIANT.npz: positions (frames, n, 3) float32 world space,
metres; frames, their numbers; ms, processor milliseconds a frame over those of the bare rig; asked, metres, the
wavelength that was asked for (nan: none); shown, starts and corners: the surface as it is drawn in the frame that the
picture shows.
"""
from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Callable

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import bench_tension  # noqa: E402
import bench_variants  # noqa: E402
import rumple  # noqa: E402
import truth_clip  # noqa: E402
import truth_cloth  # noqa: E402
import truth_pins  # noqa: E402
from truth_run import LEVELS, needs_inner, open_scene, say  # noqa: E402
from truth_sheet import Shown, evaluated, pace, places_on, rest_surface  # noqa: E402

WAVELENGTH = 0.056  # metres, of the tension map: what the Field's first click takes on S1's shirt
Stored = dict[str, np.ndarray]


def arguments() -> argparse.Namespace:
    """What scripts/bench passes on."""
    parser = argparse.ArgumentParser(prog="scripts/bench")
    parser.add_argument("--scene", required=True)
    parser.add_argument("--garment", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--contender", choices=sorted(CONTENDERS), required=True)
    parser.add_argument("--picture", type=int, required=True)
    parser.add_argument("--variant", choices=bench_variants.NAMES)
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:])


def played(garment: bpy.types.Object, stored: Stored, picture: int, asked: float, bare_ms: float,
           at_rest: Shown) -> Stored:
    """Every frame in order, read where the simulation's vertices lie on the surface at rest."""
    corners, shares, gap = places_on(at_rest, stored["rest"])
    say(f"at rest at most {1e3 * gap:.1f} mm from the simulation's vertices")
    positions, milliseconds, shown = [], [], None
    for frame in stored["frames"].tolist():
        began = time.process_time()
        bpy.context.scene.frame_set(frame)
        milliseconds.append(1e3 * (time.process_time() - began))
        here = evaluated(garment)
        positions.append(read(here, corners, shares))
        if frame == picture or shown is None:
            shown = here
    return result(np.stack(positions), stored, float(np.median(milliseconds)) - bare_ms, asked, shown)


def read(surface: Shown, corners: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """(n, 3) float32: the points of places_on."""
    return np.einsum("nk,nkj->nj", shares, surface.positions[corners]).astype(np.float32)


def result(positions: np.ndarray, stored: Stored, ms: float, asked: float, shown: Shown) -> Stored:
    return dict(positions=positions, frames=stored["frames"], ms=np.array(ms), asked=np.array(asked),
                shown=shown.positions, starts=shown.starts, corners=shown.corners)


def smooth_at_rest(garment: bpy.types.Object, frame: int) -> Shown:
    """What modifiers show of the garment while its skeleton is at rest; a frame, as the skeleton may be moved as a
    whole."""
    armature = truth_clip.skinned_by(garment).data
    armature.pose_position = "REST"
    bpy.context.scene.frame_set(frame)
    surface = evaluated(garment)
    armature.pose_position = "POSE"
    return surface


def of_rumple(method: str, setting: str, waves: float) -> Callable[[str, Stored, int], Stored]:
    """One click of a system; the Field as geometry, since its shading moves nothing. setting: says how wide folds
    are; from one to the next it is `waves` times that."""
    def play(name: str, stored: Stored, picture: int) -> Stored:
        garment, bare_ms = truth_clip.find_garment(name), pace(stored["frames"])
        bpy.context.view_layer.objects.active = garment
        if bpy.ops.object.rumple_add(method=method) != {"FINISHED"}:
            raise SystemExit(garment.rumple.message)
        if method == "FIELD":
            garment.rumple.field.output = "GEOMETRY"
        asked = waves * getattr(getattr(garment.rumple, method.lower()), setting)
        at_rest = rest_surface(garment, int(stored["frames"][0]))
        return played(garment, stored, picture, asked, bare_ms, at_rest)
    return play


def subdivision(name: str, stored: Stored, picture: int) -> Stored:
    """The bare garment, smooth."""
    garment, bare_ms = truth_clip.find_garment(name), pace(stored["frames"])
    garment.modifiers.new("Fine", "SUBSURF").levels = LEVELS
    return played(garment, stored, picture, float("nan"), bare_ms,
                  smooth_at_rest(garment, int(stored["frames"][0])))


def tension(name: str, stored: Stored, picture: int) -> Stored:
    garment, bare_ms = truth_clip.find_garment(name), pace(stored["frames"])
    bench_tension.add(garment, WAVELENGTH)
    return played(garment, stored, picture, WAVELENGTH, bare_ms,
                  smooth_at_rest(garment, int(stored["frames"][0])))


def cloth_subdivided(name: str, stored: Stored, picture: int) -> Stored:
    """Blender's Cloth on the coarse garment, Subdivision behind it; held, lead in and fabric as the simulation's."""
    frames = stored["frames"]
    lead = json.loads(str(stored["settings"]))["lead"]
    clip = truth_clip.sample(truth_clip.find_garment(name), range(int(frames[0]), int(frames[-1]) + 1), 0, *lead)
    triangles, _ = truth_clip.triangles_of(clip.garment.starts, clip.garment.corners)
    borders = truth_pins.describe(clip.garment.rest, triangles, clip.bodies[0].rest)
    truth_pins.choose(borders, None)
    hold = truth_pins.hold(clip.garment.rest, triangles, borders)
    with tempfile.TemporaryDirectory() as folder:
        cloth = truth_cloth.build(clip, hold, truth_cloth.Fabric(), needs_inner(clip), Path(folder))
        coarse, seconds = truth_cloth.simulate(cloth, clip, say)
        coarse = coarse + truth_clip.travelled(clip.speed, len(frames))
        still = clip.garment.rest[None]
        surface = truth_clip.Surface(np.concatenate([still, coarse]), still[0], clip.garment.starts,
                                     clip.garment.corners)
        shown = truth_cloth.moving_object("Shown", surface, Path(folder))
        shown.modifiers.new("Fine", "SUBSURF").levels = LEVELS
        drawn = []
        for number in range(len(frames) + 1):
            bpy.context.scene.frame_set(number + 1)
            drawn.append(evaluated(shown))
    corners, shares, _ = places_on(drawn.pop(0), stored["rest"])
    return result(np.stack([read(surface, corners, shares) for surface in drawn]), stored, 1e3 * seconds, float("nan"),
                  drawn[int(np.argmax(frames == picture))])


def simulation(name: str, stored: Stored, picture: int) -> Stored:
    """Blender's Cloth at full resolution: scripts/ground_truth has simulated it."""
    here = stored["positions"][picture - int(stored["frames"][0])]
    return result(stored["positions"], stored, 1e3 * float(stored["seconds"]), float("nan"),
                  Shown(here, stored["starts"], stored["corners"]))


CONTENDERS: dict[str, Callable[[str, Stored, int], Stored]] = {
    "subdivision": subdivision,
    "mesh": of_rumple("MESH", "wavelength", 1.0),
    "field": of_rumple("FIELD", "wavelength", 1.0),
    "paths": of_rumple("PATHS", "width", 2.0),
    "tension": tension,
    "cloth_subdivided": cloth_subdivided,
    "cloth": simulation,
}


def main() -> None:
    options = arguments()
    rumple.register()
    open_scene(options.scene)
    with np.load(options.out / "truth.npz", allow_pickle=False) as file:
        stored = {key: file[key] for key in file.files}
    file_name = options.contender
    if options.variant:
        file_name += f"@{options.variant}"
        garment = truth_clip.find_garment(options.garment)
        stored["frames"] = bench_variants.change(options.variant, garment, stored["frames"])
    made = CONTENDERS[options.contender](options.garment, stored, options.picture)
    say(f"{file_name}: {float(made['ms']):.1f} ms a frame over the bare rig")
    np.savez(options.out / f"{file_name}.npz", **made)


if __name__ == "__main__":
    main()
