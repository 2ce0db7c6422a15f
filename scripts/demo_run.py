# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo inside Blender: add the modifier, play, measure, render before and after. Started by scripts/demo."""
from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "addon"), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
from contact_sheet import compose, frame_camera, studio  # noqa: E402
from demo_report import Report  # noqa: E402
from rumple.blender.farm.command import frames_of, joined  # noqa: E402

SHEET_FRAMES = 5
MOST_FRAMES = 250
CLIP_PERCENT = 60


def say(text: str) -> None:
    """A line for the screen; scripts/demo lets only these through."""
    print(f"| {text}", flush=True)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="scripts/demo")
    parser.add_argument("--object")
    parser.add_argument("--frames", type=frames_of)
    parser.add_argument("--method", type=str.upper, choices=("MESH", "FIELD", "PATHS"), default="MESH")
    parser.add_argument("--out", type=Path, required=True)
    return parser.parse_args(joined(sys.argv[sys.argv.index("--") + 1:]))


def find_garments(name: str | None) -> list[bpy.types.Object]:
    """The named mesh object, or the demo's trousers and shirt."""
    if name is None:
        import demo_scene
        say("making the demo scene")
        demo_scene.build_demo_scene()
        return [bpy.data.objects[name] for name in demo_scene.GARMENTS]
    garment = bpy.data.objects.get(name)
    if garment is None or garment.type != "MESH":
        meshes = ", ".join(sorted(o.name for o in bpy.data.objects if o.type == "MESH")) or "none"
        say(f"there is no mesh object named {name}; this file has: {meshes}")
        raise SystemExit(1)
    return [garment]


def frame_range(chosen: tuple[int, int] | None) -> range:
    """First and last, else those of the scene."""
    scene = bpy.context.scene
    first, last = chosen or (scene.frame_start, scene.frame_end)
    if last - first >= MOST_FRAMES:
        say(f"of the frames {first}-{last} the first {MOST_FRAMES} are shown: give --frames for others")
        last = first + MOST_FRAMES - 1
    return range(first, last + 1)


def add_wrinkles(garment: bpy.types.Object, method: str) -> bpy.types.Modifier:
    bpy.context.view_layer.objects.active = garment
    garment.rumple.field.output = "GEOMETRY"  # the studio draws no materials
    if bpy.ops.object.rumple_add(method=method) != {"FINISHED"}:
        say(garment.rumple.message)
        raise SystemExit(1)
    from rumple.blender.objects import modifier
    return modifier.find(garment)


def play(garment: bpy.types.Object, frames: range) -> Report:
    """Every frame once, in order, measured."""
    from rumple.blender.objects import properties, runtimes, units
    scene = bpy.context.scene
    fine = runtimes.of(garment).evaluator
    scale = units.metres_per_unit(garment, scene)
    report = Report(dict(object=garment.name, method=garment.rumple.method, blender=bpy.app.version_string,
                         base_vertices=len(garment.data.vertices), shown_vertices=fine.vertex_count,
                         units="metres, milliseconds, shares of 1"), scale)
    say(f"{garment.name}: {len(garment.data.vertices)} vertices, {fine.vertex_count} shown")
    for number, frame in enumerate(frames):
        began = time.perf_counter()
        scene.frame_set(frame)
        spent = 1e3 * (time.perf_counter() - began)
        runtime = runtimes.of(garment)
        if runtime.message or runtime.inputs is None:
            say(f"frame {frame}: {runtime.message or 'nothing was solved'}")
            raise SystemExit(1)
        measures = fine.measure_frame(float(frame), runtime.inputs.positions, properties.settings_of(garment, scene))
        report.add(frame, runtime.result, measures, spent)
        if number % 10 == 0:
            say(f"solving frame {frame} of {frames[-1]}")
    return report


def render(path: Path, percent: int = 100) -> None:
    scene = bpy.context.scene
    scene.render.resolution_percentage = percent
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def render_first(garment: bpy.types.Object, frame: int, needs_camera: bool, out: Path) -> None:
    """One frame, before any other is solved: scripts/demo says how soon it was there."""
    if needs_camera:
        frame_camera(garment, range(frame, frame + 1))
    bpy.context.scene.frame_set(frame)
    render(out / "first_picture.png")


def render_sheet(wrinkles: list[bpy.types.Modifier], frames: range, out: Path) -> None:
    """Before and after, side by side, for a few frames."""
    step = max(1, (len(frames) - 1) // (SHEET_FRAMES - 1))
    chosen = frames[::step][:SHEET_FRAMES]
    tiles = []
    for frame in chosen:
        say(f"contact sheet: frame {frame}")
        bpy.context.scene.frame_set(frame)
        for shown, label in ((False, "before"), (True, "after")):
            for modifier in wrinkles:
                modifier.show_render = shown
            path = out / f".tile_{frame}_{label}.png"
            render(path)
            tiles.append((f"frame {frame}, {label}", path))
    compose(tiles, 2, out / "contact_sheet.png")
    for _, path in tiles:
        path.unlink()


def render_clip(frames: range, out: Path) -> None:
    folder = out / "frames"
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.png"):
        old.unlink()
    for number, frame in enumerate(frames):
        bpy.context.scene.frame_set(frame)
        render(folder / f"{frame:04d}.png", CLIP_PERCENT)
        if number % 10 == 0:
            say(f"rendering frame {frame} of {frames[-1]}")
    (out / "fps").write_text(str(bpy.context.scene.render.fps))


def main() -> None:
    options = arguments()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    rumple.register()
    garments = find_garments(options.object)
    frames = frame_range(options.frames)
    start, bpy.context.scene.frame_start = bpy.context.scene.frame_start, frames[0]
    wrinkles = [add_wrinkles(garment, options.method) for garment in garments]
    bpy.context.scene.frame_set(frames[0])
    bpy.context.scene.frame_start = start
    bpy.ops.wm.save_as_mainfile(filepath=str(out / "wrinkled.blend"))
    bpy.context.scene.frame_start = frames[0]
    studio(bpy.context.scene)
    render_first(garments[-1], frames[len(frames) // 2], options.object is not None, out)
    report = play(garments[-1], frames)
    if options.object is not None:
        frame_camera(garments[-1], frames)
    render_sheet(wrinkles, frames, out)
    render_clip(frames, out)
    report.write(out / "report.json")
    for line in report.table():
        say(line)


if __name__ == "__main__":
    main()
