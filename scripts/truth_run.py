# SPDX-License-Identifier: GPL-3.0-or-later
"""The simulation of scripts/ground_truth inside Blender: sample the scene, hold, simulate, check, store truth.npz.

truth.npz, world space, metres: positions and base (frames, n, 3) float32, the simulation and the smooth bare garment
on the same vertices; rest (n, 3); triangles (t, 3); starts and corners, the faces; patch (t,), the coarse triangle
that each triangle lies in; coarse_rest (c, 3) and coarse_triangles; pins (n,); frames (frames,); fps; processor
seconds a frame; settings, as JSON.
"""
from __future__ import annotations

import argparse
import hashlib
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import truth_clip  # noqa: E402
import truth_pins  # noqa: E402
from truth_cloth import Fabric, build, simulate  # noqa: E402

LEVELS = 2
VERSION = 2  # another one makes old caches unusable
MOST_FRAMES = 250
SLIPPED = 0.04  # metres: a cuff's centre farther than this from the animated one's
PIERCED = 0.005  # share of the cloth's vertices deep in the body
COVERED = 0.9  # share of the garment with a body under it; with less the shrunk garment stands in


def say(text: str) -> None:
    """A line for the screen; scripts/ground_truth lets only these through."""
    print(f"| {text}", flush=True)


def arguments() -> argparse.Namespace:
    """What scripts/ground_truth passes on."""
    parser = argparse.ArgumentParser(prog="scripts/ground_truth")
    parser.add_argument("--scene", required=True)
    parser.add_argument("--garment", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--frames")
    parser.add_argument("--pin")
    parser.add_argument("--fabric")
    parser.add_argument("--lead", default="30+20")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:])


def open_scene(scene: str) -> None:
    """Make the scene of the demo, of a lesson (skirt) or of the gallery by its name; a .blend is open already."""
    if scene.endswith(".blend"):
        return
    import demo_scene
    import gallery_scenes
    import lesson_scenes
    {"demo": demo_scene.build_demo_scene, "skirt": lesson_scenes.build_skirt_scene, **gallery_scenes.SCENES}[scene]()


def fingerprint(garment: bpy.types.Object, frames: range) -> str:
    """Of what is simulated: faces, and where garment and body are in some frames."""
    found = hashlib.sha256(truth_clip.faces_of(garment.data)[1].tobytes())
    for frame in (frames[0], frames[len(frames) // 2], frames[-1]):
        bpy.context.scene.frame_set(frame)
        for thing in (garment, *truth_clip.find_bodies(garment)):
            found.update(np.round(1e6 * truth_clip.evaluated_positions(thing)).astype(np.int64).tobytes())
    return found.hexdigest()[:16]


def frame_range(text: str | None) -> range:
    """A-B, or the scene's own frames."""
    scene = bpy.context.scene
    first, last = (int(part) for part in text.split("-")) if text else (scene.frame_start, scene.frame_end)
    return range(first, min(last, first + MOST_FRAMES - 1) + 1)


def fabric_of(text: str | None) -> Fabric:
    """The usual fabric with KEY=VALUE,... changed."""
    fabric = Fabric()
    for part in filter(None, (text or "").split(",")):
        key, value = part.split("=")
        if not hasattr(fabric, key):
            raise SystemExit(f"--fabric knows {', '.join(fabric.as_dict())}, not {key}")
        setattr(fabric, key, type(getattr(fabric, key))(float(value)))
    return fabric


def coarse_triangle(clip: truth_clip.Clip, triangles: np.ndarray, face: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (k, 3) of the coarse garment, and which of them each fine triangle (t,) lies in: of its polygon's the
    one whose middle is nearest at rest."""
    coarse, polygon = truth_clip.triangles_of(clip.coarse.starts, clip.coarse.corners)
    middle = clip.coarse.rest[coarse].mean(1)
    here = clip.garment.rest[triangles].mean(1)
    mine = clip.patch[face]
    first = np.searchsorted(polygon, np.arange(len(clip.coarse.starts)))
    count = np.bincount(polygon, minlength=len(clip.coarse.starts))
    best = first[mine]
    nearest = np.linalg.norm(here - middle[best], axis=1)
    for step in range(1, int(count.max())):
        other = np.minimum(first[mine] + step, len(coarse) - 1)
        away = np.where(step < count[mine], np.linalg.norm(here - middle[other], axis=1), np.inf)
        best, nearest = np.where(away < nearest, other, best), np.minimum(away, nearest)
    return coarse, best.astype(np.int32)


def needs_inner(clip: truth_clip.Clip) -> bool:
    """Whether parts of the body are missing under the garment."""
    covered = truth_clip.covered(clip)
    say(f"a body lies under {100 * covered:.0f} % of the garment" +
        ("" if covered >= COVERED else ": the garment itself, shrunk, stands in for the rest"))
    return covered < COVERED


def check_arms(borders: list[truth_pins.Border], positions: np.ndarray, base: np.ndarray, frames: range) -> float:
    """Says where a cuff has left its arm; the farthest distance in metres of any cuff's centre."""
    worst = 0.0
    for border in (b for b in borders if b.kind in ("cuff", "short sleeve", "leg")):
        away = np.linalg.norm((positions - base)[:, border.vertices].mean(1), axis=1)
        worst = max(worst, float(away.max()))
        if away.max() > SLIPPED:
            say(f"WARNING: the {border.kind} at x = {border.centre[0]:.2f} m is {1e3 * away.max():.0f} mm from its "
                f"place at frame {frames[int(away.argmax())]}: look whether the limb is still in it")
    say(f"cuffs stay within {1e3 * worst:.0f} mm of their places")
    return worst


def check_body(shares: np.ndarray, frames: range) -> None:
    """Says where the body has come through the cloth. shares (frames,) of the cloth's vertices, beyond the bare
    garment's own: skinned garments cut into the body at armpits and shoulders."""
    bad = np.flatnonzero(shares > PIERCED)
    if len(bad):
        say(f"WARNING: the body is through the cloth from frame {frames[int(bad[0])]} on, most at frame "
            f"{frames[int(shares.argmax())]} ({100 * shares.max():.1f} % of the vertices): do not trust those frames")
    else:
        say(f"at most {100 * shares.max():.1f} % of the vertices lie in the body beyond those of the bare garment")


def stored_settings(path: Path) -> dict[str, Any] | None:
    """Of an earlier run."""
    if not path.is_file():
        return None
    with np.load(path, allow_pickle=False) as stored:
        return json.loads(str(stored["settings"]))


def run(options: argparse.Namespace, settings: dict[str, Any], frames: range, fabric: Fabric, path: Path) -> None:
    """Sample, simulate, store."""
    clip = truth_clip.sample(truth_clip.find_garment(options.garment), frames, LEVELS,
                             *settings["lead"])
    garment, lead = clip.garment, clip.lead
    triangles, face = truth_clip.triangles_of(garment.starts, garment.corners)
    borders = truth_pins.describe(garment.rest, triangles, clip.bodies[0].rest)
    truth_pins.choose(borders, options.pin)
    for border in borders:
        say(border.line())
    hold = truth_pins.hold(garment.rest, triangles, borders)
    say(f"{len(garment.rest)} vertices, {len(frames)} frames after {lead} of lead")
    with tempfile.TemporaryDirectory() as folder:
        cloth = build(clip, hold, fabric, needs_inner(clip), Path(folder))
        positions, seconds = simulate(cloth, clip, say)
    check_arms(borders, positions, garment.positions[lead:], frames)
    bare = truth_clip.through(clip, garment.positions[lead:])
    check_body(np.maximum(truth_clip.through(clip, positions) - bare, 0.0), frames)
    moved = truth_clip.travelled(clip.speed, len(frames))
    coarse, patch = coarse_triangle(clip, triangles, face)
    np.savez(path, positions=positions + moved, base=garment.positions[lead:] + moved, rest=garment.rest,
             triangles=triangles, starts=garment.starts, corners=garment.corners, patch=patch,
             coarse_rest=clip.coarse.rest, coarse_triangles=coarse, pins=hold.pins, frames=np.array(frames),
             fps=clip.fps, seconds=seconds, settings=json.dumps(settings))
    say(f"{seconds:.2f} processor seconds a frame")


def main() -> None:
    options = arguments()
    path = options.out / "truth.npz"
    fabric = fabric_of(options.fabric)
    open_scene(options.scene)
    frames = frame_range(options.frames)
    made_from = fingerprint(truth_clip.find_garment(options.garment), frames)
    settings = dict(version=VERSION, made_from=made_from, garment=options.garment, frames=[frames[0], frames[-1]],
                    levels=LEVELS, lead=[int(part) for part in options.lead.split("+")], pin=options.pin,
                    blender=bpy.app.version_string, fabric=fabric.as_dict())
    if stored_settings(path) == settings:
        say("simulated before, with the same settings")
    else:
        run(options, settings, frames, fabric, path)
    (options.out / "done").touch()


if __name__ == "__main__":
    main()
