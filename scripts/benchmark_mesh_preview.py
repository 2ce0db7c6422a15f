# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Wrinkle Mesh costs on the graphics card, beside the library, from 2 thousand to a million triangles.

    RUMPLE_NATIVE=build/release/python xvfb-run -a -s "-screen 0 1280x960x24" blender --factory-startup \
        --python scripts/benchmark_mesh_preview.py -- [QUADS ALONG A SIDE OF THE SHEET ...]

First a frame of a square sheet with folds, milliseconds until the card has finished; in brackets those of the main
thread alone. Then playback of a sheet that is pressed together, in a Solid viewport, as an artist sees it: `update` is
everything but drawing (modifier, solve, shown mesh), `draw` a redraw of the window until the card has finished.
"""
from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Iterator

import bpy
import gpu
import numpy as np

HERE = Path(__file__).resolve()
sys.path[:0] = [str(HERE.parents[1] / "addon"), str(HERE.parent), os.environ["RUMPLE_NATIVE"]]
import rumple  # noqa: E402
import rumple_native as native  # noqa: E402
from benchmark_window import look, milliseconds, play, run, sheet  # noqa: E402
from rumple.blender.objects import runtimes  # noqa: E402
from rumple.blender.viewport import gpu_mesh  # noqa: E402

LEVEL = 3  # subdivisions of the sheet: a quad becomes 128 triangles
SIDES = [int(side) for side in sys.argv[sys.argv.index("--") + 1:]] if "--" in sys.argv else [4, 16, 32, 64, 90]


def pressed(rest: np.ndarray, share: float) -> np.ndarray:
    """The sheet of a metre, shorter along x by this share, and waved."""
    out = rest * np.float32([1.0 - share, 1.0, 1.0])
    out[:, 2] = 0.05 * np.sin(6.0 * rest[:, 1])
    return out


def wait_for(texture: gpu.types.GPUTexture) -> None:
    """Until the card has written it."""
    frame_buffer = gpu.types.GPUFrameBuffer(color_slots=(texture,))
    with frame_buffer.bind():
        frame_buffer.read_color(0, 0, 1, 1, 4, 0, "FLOAT")


def stages(side: int) -> dict[str, float]:
    surface, _uv = sheet(side + 1, side + 1)
    model = native.build_wrinkle_mesh(native.build_surface(*surface), level=LEVEL, display_steps=0)
    settings, paint = native.WrinkleMeshSettings(), native.WrinkleMeshPaint(model)
    state, _report = native.solve_wrinkle_mesh(model, settings, paint, pressed(surface[0], 0.1))
    constraints = native.WrinkleMeshPasses(model, settings, paint)
    kernels = gpu_mesh.Kernels()
    mesh = gpu_mesh.GpuMesh(kernels, constraints, settings)
    shown = gpu_mesh.GpuShownMesh(kernels, model.shown, mesh.vertex)
    poses = [model.weld_pose(pressed(surface[0], share))[:2] for share in (0.10, 0.12)]
    mesh.pose(*poses[0])
    mesh.take_over(state.offset, state.solved_length)
    turn = [0]

    def pose() -> None:
        turn[0] += 1
        mesh.pose(*poses[turn[0] % 2])

    def frame() -> None:
        pose()
        mesh.solve()
        shown.show(mesh.solution)

    def finish() -> None:
        wait_for(shown.normals)

    posed = pressed(surface[0], 0.12)
    found = {"triangles": 2.0 * side * side * 4**LEVEL, "passes of an iteration": float(constraints.pass_count),
             "upload, attach": milliseconds(pose, lambda: wait_for(mesh.attachments)),
             "a frame": milliseconds(frame, finish), "(main thread)": milliseconds(frame)}
    finish()
    for threads in (1, 0):
        settings.threads = threads
        name = "library, one thread" if threads else "library, all threads"

        def solve() -> None:
            after, _ = native.solve_wrinkle_mesh(model, settings, paint, posed, state)
            native.show_wrinkle_mesh(model, settings, posed, after)

        found[name] = milliseconds(solve)
    return found


def tapered_sheet(side: int) -> bpy.types.Object:
    """A sheet in the scene that a modifier presses together at one end, frame by frame, with one layer of folds."""
    for old in list(bpy.data.objects):
        bpy.data.objects.remove(old)
    (rest, _start, corners, _triangles), _uv = sheet(side + 1, side + 1)
    mesh = bpy.data.meshes.new("Sheet")
    mesh.from_pydata(rest.tolist(), [], corners.reshape(-1, 4).tolist())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    obj = bpy.data.objects.new("Sheet", mesh)
    bpy.context.scene.collection.objects.link(obj)
    taper = obj.modifiers.new("Taper", "SIMPLE_DEFORM")
    taper.deform_method, taper.deform_axis = "TAPER", "Y"
    for frame, factor in ((1, -0.2), (40, -0.6)):
        taper.factor = factor
        taper.keyframe_insert("factor", frame=frame)
    bpy.context.view_layer.objects.active = obj
    obj.rumple.mesh.layers, obj.rumple.mesh.density, obj.rumple.mesh.base_cloth = "ONE", "LEVEL", "OFF"
    obj.rumple.most_vertices = 4_000_000
    obj.rumple.mesh.level, obj.rumple.mesh.display_steps = LEVEL, 0
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], object=obj, active_object=obj,
                                   selected_objects=[obj]):
        bpy.ops.object.rumple_add(method="MESH")
    return obj


def steps() -> Iterator[float]:
    print(f"Wrinkle Mesh, ms, on {gpu.platform.renderer_get()}, Blender {bpy.app.version_string}")
    columns = [stages(side) for side in SIDES]
    for name in columns[0]:
        print("".join([f"{name:24}", *(f"{column[name]:14,.{0 if column[name] > 500 else 2}f}" for column in columns)]))
    sys.stdout.flush()
    for side in SIDES[1:]:
        obj = tapered_sheet(side)
        area = look([obj])
        for preview in (False, True):
            obj.rumple.mesh.gpu_preview = preview
            area.tag_redraw()
            yield 2.0
            while runtimes.of(obj).evaluator is None:
                yield 0.5
            for name in ("solved", "stored"):
                update, draw = play()
                print(f"{2 * side * side * 4**LEVEL:9,} triangles  {'on the card' if preview else 'fine mesh':11} "
                      f"{name} update {update:7.1f}  draw {draw:7.1f}  left to the card: "
                      f"{runtimes.of(obj).inputs.for_preview}")
                sys.stdout.flush()


rumple.register()
run(steps())
