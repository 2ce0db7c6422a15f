# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the painted wrinkles in the viewport while the brush is active: a line along the folds at every vertex."""
from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ...core.base.wording import UserError
from .. import compat
from ..viewport.draw_handler import DrawHandler
from . import canvas as brush_canvas

WEAK, STRONG = np.array((0.3, 0.75, 1.0, 1.0), np.float32), np.array((1.0, 0.85, 0.1, 1.0), np.float32)
RIM = np.array((0.0, 0.0, 0.0, 0.6), np.float32)  # around the lines, so that they are visible on any colour of cloth
WIDTH, RIM_WIDTH = 2.0, 4.0  # pixels, times the interface's scale
NEARER = 0.02  # lines are moved towards the viewer by this share of the distance, so that folds do not hide them
CURSOR = (1.0, 1.0, 1.0, 0.8)


@dataclass
class _Drawn:
    """Lines on the graphics card, and the data that they were made from."""

    easel: Any
    positions: np.ndarray
    painted: np.ndarray
    across: bool
    batches: list  # (batch, width in pixels), in the order of drawing


_tool = ""
_last: _Drawn | None = None


def register(tool: str) -> None:
    """tool: the tool that must be active."""
    global _tool
    _tool = tool
    handler.add()


def unregister() -> None:
    handler.remove()


def forget() -> None:
    global _last
    _last = None


def _draw_what_can_be() -> None:
    """Draw, or do nothing if the wrinkles or the mesh are refused. The panel says why."""
    with suppress(UserError):
        _draw(bpy.context)


def _draw(context: bpy.types.Context) -> None:
    obj, brush = context.object, context.scene.rumple_brush
    if not (brush.show_overlay and context.space_data.overlay.show_overlays and is_tool_active(context)):
        return
    depsgraph = context.view_layer.depsgraph
    if obj is None or obj.type != "MESH" or depsgraph is None or not obj.visible_get():
        return
    painted = brush_canvas.read(obj.data)
    if painted is None:
        return
    canvas = brush_canvas.canvas_of(obj)
    canvas.pose(obj, depsgraph)
    _draw_lines(_batches(canvas.easel, painted, brush.show_vectors), context)


def is_tool_active(context: bpy.types.Context) -> bool:
    """Whether the brush is the tool of the workspace."""
    tool = context.workspace.tools.from_space_view3d_mode(context.mode, create=False)
    return tool is not None and tool.idname == _tool


def _batches(easel: Any, painted: np.ndarray, across: bool) -> list:
    """The lines. They are only made again after a change."""
    global _last
    if not (_last is not None and _last.easel is easel and _last.across == across
            and _last.positions is easel.positions and np.array_equal(_last.painted, painted)):
        ends, strength = easel.lines(painted, across)
        _last = _Drawn(easel, easel.positions, painted, across, _upload(ends, strength) if len(ends) else [])
    return _last.batches


def _upload(ends: np.ndarray, strength: np.ndarray) -> list:
    import gpu  # not at the top: it needs a window in 3.4
    from gpu_extras.batch import batch_for_shader
    shader = gpu.shader.from_builtin(compat.LINE_SHADER)
    colors = np.repeat(WEAK + np.clip(strength, 0.0, 1.0)[:, None] * (STRONG - WEAK), 2, axis=0)
    return [(batch_for_shader(shader, "LINES", {"pos": ends, "color": color}), width)
            for color, width in ((np.broadcast_to(RIM, colors.shape).copy(), RIM_WIDTH), (colors, WIDTH))]


def _draw_lines(batches: list, context: bpy.types.Context) -> None:
    import gpu
    shader, view = gpu.shader.from_builtin(compat.LINE_SHADER), context.region_data
    nearer = (Matrix.Scale(1.0 - NEARER, 4) if view.is_perspective
              else Matrix.Translation((0.0, 0.0, NEARER * view.view_distance)))
    wrote_depth = gpu.state.depth_mask_get()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(False)  # otherwise the rims would hide the lines
    gpu.state.blend_set("ALPHA")
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.load_matrix(nearer @ gpu.matrix.get_model_view_matrix())
            shader.bind()
            shader.uniform_float("viewportSize", (context.region.width, context.region.height))
            for batch, width in batches:
                shader.uniform_float("lineWidth", width * context.preferences.system.ui_scale)
                batch.draw(shader)
    finally:
        gpu.state.blend_set("NONE")
        gpu.state.depth_mask_set(wrote_depth)
        gpu.state.depth_test_set("NONE")


def draw_cursor(brush: bpy.types.PropertyGroup, place: tuple[float, float]) -> None:
    """The rim of the brush around the mouse."""
    from gpu_extras.presets import draw_circle_2d
    draw_circle_2d(place, CURSOR, brush.radius, segments=48)


handler = DrawHandler("the overlay of the brush", _draw_what_can_be, forget)
