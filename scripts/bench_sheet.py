# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables and the picture of scripts/bench for one scene, from bench_run.py: bench.md, sheet.png."""
from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import bench_consistency  # noqa: E402
import bench_measures  # noqa: E402
import truth_clip  # noqa: E402
import truth_measures  # noqa: E402
from bench_run import CONTENDERS  # noqa: E402
from truth_run import open_scene, say  # noqa: E402
from truth_sheet import Shown, draw, evenly  # noqa: E402

NAMES = {"subdivision": "Subdivision, bare", "mesh": "Rumple, Wrinkle Mesh", "field": "Rumple, Wrinkle Field",
         "paths": "Rumple, Wrinkle Paths", "tension": "Tension map, displaced",
         "cloth_subdivided": "Cloth, then Subdivision", "cloth": "Cloth at full resolution"}
HEAD = ("", "ms a frame", "area kept", "28 to 55", "55 to 110", "110 to 220 mm", "wavelength, asked / is, mm",
        "alignment", "frame to frame, mm", "held, mm", "in the body, %", "crossings")
TILE_WIDTH = 380  # pixels
MEASURED, HELD = 12, 4  # frames; the last ones of a clip that ends in a held pose


def arguments() -> argparse.Namespace:
    """What scripts/bench passes on."""
    parser = argparse.ArgumentParser(prog="scripts/bench")
    parser.add_argument("--scene", required=True)
    parser.add_argument("--garment", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--picture", type=int, required=True)
    parser.add_argument("--held", type=int, default=0)
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:])


def bodies(garment: bpy.types.Object, frames: list[int]) -> tuple[dict[int, np.ndarray], np.ndarray]:
    """The body's vertices (m, 3) in each frame, world space, metres, and its triangles (k, 3)."""
    body = truth_clip.find_bodies(garment)[0]
    positions = {}
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        positions[frame] = truth_clip.evaluated_positions(body)
    shown = body.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return positions, truth_clip.triangles_of(*truth_clip.faces_of(shown))[0]


class Scene:
    """What all contenders of a scene are measured on."""

    def __init__(self, options: argparse.Namespace) -> None:
        with np.load(options.out / "truth.npz", allow_pickle=False) as stored:
            self.frames, self.base = stored["frames"].tolist(), stored["base"]
            self.fps = float(stored["fps"])
            self.cloth = truth_measures.build_cloth(stored["rest"], stored["triangles"], stored["patch"])
        self.held = options.held
        self.measured = evenly(np.array(self.frames[:len(self.frames) - self.held]), MEASURED)
        self.body, self.body_triangles = bodies(truth_clip.find_garment(options.garment), self.measured)

    def row(self, positions: np.ndarray) -> dict[str, float]:
        """Means over the measured frames of positions (frames, n, 3)."""
        rows = []
        for frame in self.measured:
            base, fine = (array[frame - self.frames[0]] for array in (self.base, positions))
            rows.append({**truth_measures.measures(self.cloth, base, fine),
                         "wavelength": bench_measures.mean_wavelength(self.cloth, base, fine),
                         "in_body": bench_measures.through_body(self.cloth, fine, self.body[frame],
                                                                self.body_triangles),
                         "crossings": bench_measures.crossings(self.cloth, fine)})
        out = {key: float(np.nanmean([row[key] for row in rows])) for key in rows[0]
               if np.isfinite([row[key] for row in rows]).any()}
        changes = self.changes(positions)
        moving = len(changes) - self.held
        out["change"] = float(np.mean(changes[:moving]))
        if self.held:
            out["held"] = float(np.mean(changes[-HELD:]))
        return out

    def changes(self, positions: np.ndarray) -> list[float]:
        """Metres, from each frame to the next."""
        offsets = [bench_measures.offsets_on(self.cloth, base, fine) for base, fine in zip(self.base, positions)]
        return [bench_measures.change(before, now) for before, now in zip(offsets, offsets[1:])]


def cells(name: str, row: dict[str, float], ms: float, asked: float) -> list[str]:
    """One line of the table."""
    def text(key: str, digits: int = 2, scale: float = 1.0) -> str:
        return f"{scale * row[key]:.{digits}f}" if key in row else "-"
    asked_text = f"{1e3 * asked:.0f}" if np.isfinite(asked) else "-"
    return [NAMES[name], f"{ms:.0f}" if ms >= 10 else f"{ms:.1f}", text("area_kept"), text("rms_28_to_55_mm"),
            text("rms_55_to_110_mm"), text("rms_110_to_220_mm"), f"{asked_text} / {text('wavelength', 0, 1e3)}",
            text("alignment"), text("change", 1, 1e3), text("held", 2, 1e3), text("in_body", 1, 1e2),
            text("crossings", 0)]


def main() -> None:
    options = arguments()
    open_scene(options.scene)
    scene = Scene(options)
    lines, shown = [], {}
    for name in CONTENDERS:
        with np.load(options.out / f"{name}.npz", allow_pickle=False) as stored:
            lines.append(cells(name, scene.row(stored["positions"]), float(stored["ms"]), float(stored["asked"])))
            shown[NAMES[name]] = {options.picture: Shown(stored["shown"], stored["starts"], stored["corners"])}
        say(" | ".join(lines[-1]))
    variants = bench_consistency.table(options.out, NAMES, scene.cloth, np.array(scene.frames), scene.base, scene.fps)
    (options.out / "bench.md").write_text("\n".join(
        "".join(f"| {' | '.join(line)} |\n" for line in (head, ["---"] * len(head), *body))
        for head, body in ((HEAD, lines), (bench_consistency.HEAD, variants)) if body))
    garment = truth_clip.find_garment(options.garment)
    draw(garment, shown, np.array(scene.frames), options.out, stacked=1, width=TILE_WIDTH)


if __name__ == "__main__":
    main()
