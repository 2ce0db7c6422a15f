# SPDX-License-Identifier: GPL-3.0-or-later
"""What the stages of the GPU preview cost, beside the same steps in C++ on one thread. Started by scripts/benchmark.

    RUMPLE_NATIVE=build/release/python xvfb-run -a blender --factory-startup --python scripts/benchmark_preview.py

Sheets of as many vertices, drawn over as many pixels, as two rows of the paper: the shirt of table 1 and model B of
table 2 (1.83 ms crush, 1.75 ms relax, 5.01 ms render on a GeForce 6800 GT). Then what it costs the main thread to read
what lies over the previews, from pictures of some sizes on a GPU that has nothing else to do.
"""
from __future__ import annotations

import os
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Callable, Iterator

import bpy
import gpu
import numpy as np
from mathutils import Matrix

HERE = Path(__file__).resolve()
sys.path[:0] = [str(HERE.parents[1] / "addon"), str(HERE.parent), os.environ["RUMPLE_NATIVE"]]
import rumple_native as native  # noqa: E402
from benchmark_window import milliseconds, run, sheet  # noqa: E402
from rumple.blender.viewport import gpu_arrays, preview, preview_field  # noqa: E402

ROWS = (("shirt", 35, 13, 330_000), ("B", 139, 43, 55_000))  # name, vertices along and across, pixels
SIDE = 1024
OVERLAYS = ((400, 300), (793, 593), (1920, 1080), (3840, 2160))  # pixels


def finished(target: gpu_arrays.Target) -> Callable[[], None]:
    """Waits until a target is written."""
    return lambda: target.frame_buffer.read_color(0, 0, 1, 1, 4, 0, "FLOAT")


def render(held: preview._OnGpu, pixels: int) -> tuple[Callable[[], None], Callable[[], None]]:
    """The render stage over so many pixels, with parallax and light: (draw, finish)."""
    target = gpu.types.GPUOffScreen(SIDE, SIDE, format="RGBA32F")
    obj = SimpleNamespace(matrix_world=Matrix(), dimensions=(1.0, 1.0, 1.0), material_slots=())
    lights = bpy.context.preferences.system
    shading = SimpleNamespace(light="STUDIO", color_type="SINGLE", single_color=(0.8, 0.8, 0.8),
                              show_specular_highlight=True, show_backface_culling=False,
                              use_world_space_lighting=False, selected_studio_light=lights)
    scale = 2.0 * (pixels / 0.7)**0.5 / SIDE  # the posed sheet is 0.7 by 1
    view = Matrix.Translation((-0.35, -0.5, 0.0))

    def draw() -> None:
        with target.bind():
            gpu.state.active_framebuffer_get().clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
                gpu.matrix.load_matrix(view)
                gpu.matrix.load_projection_matrix(Matrix.Diagonal((scale, scale, -0.1, 1.0)))
                preview._draw_object(obj, held, shading, gpu_arrays.no_overlays())

    def finish() -> None:
        with target.bind():
            gpu.state.active_framebuffer_get().read_color(0, 0, 1, 1, 4, 0, "FLOAT")

    return draw, finish


def measure(along: int, across: int, pixels: int) -> dict[str, float]:
    surface, uv = sheet(along, across)
    model = native.build_wrinkle_field(native.build_surface(*surface), uv=uv)
    settings, paint = native.WrinkleFieldSettings(), native.WrinkleFieldPaint()
    settings.threads = 1
    profile = native.WrinkleFieldProfile("SINE")
    posed = surface[0] * np.float32([0.7, 1.0, 1.0])
    posed[:, 2] = 0.05 * np.sin(6.0 * posed[:, 1])
    waves = native.estimate_waves_wrinkle_field(model, settings, paint, posed)
    phase = native.random_phases(model, 0)
    drawing = preview_field.Drawing(model)
    field = drawing.waves
    field.set_wave_parameters(settings, native.wave_parameters_wrinkle_field(model, settings, paint), profile)
    field.begin(phase, model.first_directions)
    pose = model.weld_pose(posed)
    field.pose(*pose)
    field.estimate_waves()
    gpu_arrays.plain_state()
    found = {
        "weld, normals (C++)": milliseconds(lambda: model.weld_pose(posed)),
        "upload": milliseconds(lambda: field.pose(*pose)),
        "crush": milliseconds(field.estimate_waves, lambda: finished(field._activities)()),
        "relax, a round": milliseconds(lambda: field.relax(1), lambda: finished(field._phases[0])()),
        "unfold": milliseconds(field.unfold, finished(field._fans)),
    }
    drawing._collect_batches(np.zeros(len(surface[3]), np.int32))
    draw, finish = render(preview._OnGpu(model, drawing), pixels)
    found["render"] = milliseconds(draw, finish)
    found["C++: crush"] = milliseconds(lambda: native.estimate_waves_wrinkle_field(model, settings, paint, posed))
    hundred = milliseconds(lambda: native.relax_wrinkle_field(model, settings, waves, 100, phase))
    found["C++: relax, a round"] = hundred / 100.0
    return found


def read_overlays(width: int, height: int) -> float:
    """Of a picture that is all overlays, as viewports keep it: read, and handed back as a texture."""
    picture = gpu.types.GPUOffScreen(width, height, format="RGBA8")
    with picture.bind():
        gpu.state.active_framebuffer_get().clear(color=(0.5, 0.5, 0.5, 0.5), depth=1.0)
        found = milliseconds(lambda: gpu_arrays.overlays((0, 0, width, height)))
    picture.free()
    return found


def steps() -> Iterator[float]:
    print(f"GPU preview, ms, on {gpu.platform.renderer_get()}, Blender {bpy.app.version_string}")
    columns = [measure(*row[1:]) for row in ROWS]
    print("".join([f"{'':22}", *(f"{f'{name}, {a * b} vertices':>24}" for name, a, b, _ in ROWS)]))
    print("".join([f"{'pixels':22}", *(f"{pixels:24,}" for *_, pixels in ROWS)]))
    for stage in columns[0]:
        print("".join([f"{stage:22}", *(f"{column[stage]:24.3f}" for column in columns)]))
    for width, height in OVERLAYS:
        print(f"{f'overlays, {width} x {height}':22}{read_overlays(width, height):24.3f}")
    yield 0.0


run(steps())
