# SPDX-License-Identifier: GPL-3.0-or-later
"""Overlay of the data that Wrinkle Paths depend on: the coarse triangles in the colours of their labels, and on each
triangle the deformation of a circle on its reference triangle.

It shows the last solved frame and never solves. It is off in background mode and while a render runs.
"""
from __future__ import annotations

from typing import Any, Iterator

import bpy
import numpy as np
from mathutils import Matrix

from ...core.systems.wrinkle_paths import WrinklePaths
from .. import compat, scheduler
from ..objects import mesh_reader, modifier, runtimes
from .draw_handler import DrawHandler

# By label: compressed, at rest, stretched.
COLOURS = np.array(((0.10, 0.30, 1.0), (0.10, 0.65, 0.20), (1.0, 0.12, 0.10)), np.float32)
PALE = 0.6  # share of white in the ellipses
ELLIPSE_OVER_FACE = 2.0  # opacity of the ellipses / opacity of the triangles
CORNERS = 16  # number of corners of an ellipse
NEARER = 0.02  # share of the distance by which it is moved to the viewer, so that folds do not hide it

_drawn: dict[int, tuple[runtimes.Inputs, float, Any]] = {}  # session key -> (inputs, opacity, batch)


def shown_objects() -> Iterator[tuple[bpy.types.Object, runtimes.Runtime]]:
    """Objects whose overlay is on, with a solved frame."""
    for obj, nodes_mod in modifier.wrinkled_objects():
        if obj.rumple.method != "PATHS" or not obj.rumple.paths.show_overlay:
            continue
        runtime = runtimes.known(obj)
        if (runtime is not None and runtime.inputs is not None and runtime.evaluator is not None
            and nodes_mod.show_viewport
                and not modifier.is_baked(nodes_mod) and not mesh_reader.is_busy(obj)):
            yield obj, runtime


def faces(corners: np.ndarray, labels: np.ndarray, ellipses: np.ndarray,
          opacity: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(points (v, 3), colours (v, 4), triangles (f, 3)) of the triangles, and in front of them their ellipses.

    corners: (t, 3, 3); labels: (t,); ellipses: (t, 9), centre and two semi-axes. opacity: of the triangles, 0 to 1.
    """
    count = len(corners)
    centre, short, long = (ellipses[:, k:k + 3] for k in (0, 3, 6))
    angle = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False, dtype=np.float32)[:, None, None]
    rim = (centre + np.cos(angle) * short + np.sin(angle) * long).swapaxes(0, 1)  # (t, CORNERS, 3)
    points = np.concatenate([corners.reshape(-1, 3), rim.reshape(-1, 3)])
    colours = np.concatenate([_repeated(COLOURS, opacity, labels, 3),
                              _repeated(COLOURS + PALE * (1.0 - COLOURS), min(ELLIPSE_OVER_FACE * opacity, 1.0), labels,
                                        CORNERS)])
    fan = np.stack([np.zeros(CORNERS - 2), np.arange(1, CORNERS - 1), np.arange(2, CORNERS)], 1).astype(np.int32)
    fans = 3 * count + CORNERS * np.arange(count, dtype=np.int32)[:, None, None] + fan
    triangles = np.concatenate([np.arange(3 * count, dtype=np.int32).reshape(-1, 3), fans.reshape(-1, 3)])
    return points, colours, triangles


def _repeated(colours: np.ndarray, alpha: float, labels: np.ndarray, times: int) -> np.ndarray:
    """(times t, 4): the colour of every label, repeated for each of its points."""
    with_alpha = np.concatenate([colours, np.full((len(colours), 1), alpha, np.float32)], 1)
    return np.repeat(with_alpha[labels], times, axis=0).astype(np.float32)


# ---------------------------------------------------------------- drawing
def _draw_all() -> None:
    """The draw handler. It never waits for a solve."""
    space = bpy.context.space_data
    if scheduler.rendering() or space is None or space.type != "VIEW_3D" or not space.overlay.show_overlays:
        return
    if not scheduler.LOCK.acquire(blocking=False):
        return
    try:
        shown = {compat.session_key(obj): (obj, runtime) for obj, runtime in shown_objects()}
        for key in _drawn.keys() - shown.keys():
            del _drawn[key]
        for key, (obj, runtime) in shown.items():
            if obj.visible_get(viewport=space):
                _draw(obj, _batch(key, runtime, obj.rumple.paths.overlay_opacity))
    finally:
        scheduler.LOCK.release()


def _batch(key: int, runtime: runtimes.Runtime, opacity: float) -> Any:
    """The batch of the last solved frame. It is rebuilt if the frame has changed."""
    inputs = runtime.inputs
    drawn = _drawn.get(key)
    if drawn is None or drawn[0] is not inputs or drawn[1] != opacity:
        import gpu  # not at the top, because 3.4 needs a window for it
        from gpu_extras.batch import batch_for_shader
        evaluator = runtime.evaluator
        assert isinstance(evaluator, WrinklePaths)
        points, colours, triangles = faces(*evaluator.labels_and_ellipses(inputs.frame, inputs.positions), opacity)
        shader = gpu.shader.from_builtin(compat.SMOOTH_COLOR_SHADER)
        drawn = _drawn[key] = inputs, opacity, batch_for_shader(shader, "TRIS", dict(pos=points, color=colours),
                                                                indices=triangles)
    return drawn[2]


def _draw(obj: bpy.types.Object, batch: Any) -> None:
    import gpu
    view = bpy.context.region_data
    nearer = (Matrix.Scale(1.0 - NEARER, 4) if view.is_perspective
              else Matrix.Translation((0.0, 0.0, NEARER * view.view_distance)))
    wrote_depth = gpu.state.depth_mask_get()
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(False)  # otherwise triangles hide their ellipses
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.load_matrix(nearer @ gpu.matrix.get_model_view_matrix() @ obj.matrix_world)
            batch.draw(gpu.shader.from_builtin(compat.SMOOTH_COLOR_SHADER))
    finally:
        gpu.state.depth_mask_set(wrote_depth)
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


# ---------------------------------------------------------------- registration
handler = DrawHandler("the overlay of the paths", _draw_all, _drawn.clear)
register, unregister = handler.add, handler.remove
