# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Layers: several Wrinkle Meshes on top of each other, for wide folds with finer folds on them. Each
is solved over the solved surface of the one before. See docs/wrinkle_mesh.md, Layers.

Written by scripts/declarations.py from native/include/rumple/wrinkle_layers.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .base_cloth import *
from .wrinkle_mesh import *

WrinkleLayersPointer = pointer_to("rumple_wrinkle_layers")
WrinkleLayersPaintPointer = pointer_to("rumple_wrinkle_layers_paint")
WrinkleLayersStatePointer = pointer_to("rumple_wrinkle_layers_state")
WrinkleTransferPointer = pointer_to("rumple_wrinkle_transfer")


class WrinkleLayersPlan(Struct):
    """struct rumple_wrinkle_layers_plan"""

    __slots__ = ()
    levels: int  # solved subdivisions of the base, >= 0; there are levels + 1 layers
    display_steps: int  # further subdivisions of the shown mesh, which are not solved, >= 0
    viewport_steps: int  # ... of the mesh that viewports show, >= 0; at most as many count
    most_vertices: int  # a shown mesh with more is refused
    _fields_ = (("levels", c_int32), ("display_steps", c_int32), ("viewport_steps", c_int32),
        ("most_vertices", c_int32),)


class WrinkleLayersView(Struct):
    """struct rumple_wrinkle_layers_view"""

    __slots__ = ()
    layer_count: int  # levels + 1
    solved_vertex_count: int  # of all layers
    finest_triangle_count: int
    finest_triangles: int | None  # (finest_triangle_count, 3): rows of a state's `solved`
    _fields_ = (("layer_count", c_int32), ("solved_vertex_count", c_int32), ("finest_triangle_count", c_int32),
        ("finest_triangles", c_void_p),)


class WrinkleLayersPainted(Struct):
    """struct rumple_wrinkle_layers_painted"""

    __slots__ = ()
    all: WrinkleMeshPainted
    strength: int | None  # (layers): for each (n), 0..1, r x value, or NULL; or none
    strength_count: int
    _fields_ = (("all", WrinkleMeshPainted), ("strength", c_void_p), ("strength_count", c_size_t),)


class WrinkleLayersStateView(Struct):
    """struct rumple_wrinkle_layers_state_view"""

    __slots__ = ()
    layer_count: int
    solved_count: int  # vertices of the finest layer
    solved: int | None  # (solved_count, 3): positions of the finest layer, object space
    bytes: int  # memory of the state
    _fields_ = (("layer_count", c_int32), ("solved_count", c_int32), ("solved", c_void_p), ("bytes", c_size_t),)


class WrinkleLayersInput(Struct):
    """struct rumple_wrinkle_layers_input"""

    __slots__ = ()
    positions: int | None  # (n, 3): the deformed base, or the base cloth on it, object space
    positions_count: int
    gap: int | None  # (n): how far each vertex may move inwards, object units, >= 0; none: any distance
    gap_count: int
    bodies: Bodies  # in this pose; or none
    body_hint: int | None  # (n), with bodies: from rumple_base_cloth_solve()
    body_hint_count: int
    thickness: float  # how far cloth stays off bodies, object units, >= 0
    inner: float  # how far the garment's inner side is below the cloth, object units, >= 0
    _fields_ = (("positions", c_void_p), ("positions_count", c_size_t), ("gap", c_void_p), ("gap_count", c_size_t),
        ("bodies", Bodies), ("body_hint", c_void_p), ("body_hint_count", c_size_t), ("thickness", c_float),
        ("inner", c_float),)


class WrinkleTransferPlan(Struct):
    """struct rumple_wrinkle_transfer_plan"""

    __slots__ = ()
    level: int  # subdivisions of the base mesh whose vertices are moved, >= 0
    display_steps: int  # further subdivisions of the shown mesh, >= 0
    viewport_steps: int  # ... of the mesh that viewports show, >= 0; at most as many count
    most_vertices: int  # a shown mesh with more is refused
    _fields_ = (("level", c_int32), ("display_steps", c_int32), ("viewport_steps", c_int32),
        ("most_vertices", c_int32),)


WRINKLE_LAYERS_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_wrinkle_layers_plan_default": (WrinkleLayersPlan, ()),
    "rumple_wrinkle_layers_build": (CHECKED, (SurfacePointer, POINTER(WrinkleLayersPlan),
        POINTER(WrinkleLayersPointer))),
    "rumple_wrinkle_layers_free": (None, (WrinkleLayersPointer,)),
    "rumple_wrinkle_layers_shown": (ShownMeshPointer, (WrinkleLayersPointer, c_bool)),
    "rumple_wrinkle_layers_get_view": (CHECKED, (WrinkleLayersPointer, POINTER(WrinkleLayersView))),
    "rumple_wrinkle_layers_get_layer": (CHECKED, (WrinkleLayersPointer, c_int32, POINTER(WrinkleMeshView))),
    "rumple_wrinkle_layers_paint_build": (CHECKED, (WrinkleLayersPointer, POINTER(WrinkleLayersPainted),
        POINTER(WrinkleLayersPaintPointer))),
    "rumple_wrinkle_layers_paint_free": (None, (WrinkleLayersPaintPointer,)),
    "rumple_wrinkle_layers_state_free": (None, (WrinkleLayersStatePointer,)),
    "rumple_wrinkle_layers_state_get_view": (CHECKED, (WrinkleLayersStatePointer, POINTER(WrinkleLayersStateView))),
    "rumple_wrinkle_layers_state_get_layer": (CHECKED, (WrinkleLayersStatePointer, c_int32,
        POINTER(WrinkleMeshStateView))),
    "rumple_wrinkle_layers_state_build": (CHECKED, (WrinkleLayersPointer, POINTER(WrinkleMeshStateView), c_size_t,
        c_void_p, c_size_t, POINTER(WrinkleLayersStatePointer))),
    "rumple_wrinkle_layers_state_activated": (CHECKED, (WrinkleLayersStatePointer,
        POINTER(WrinkleLayersStatePointer))),
    "rumple_wrinkle_layers_input_default": (WrinkleLayersInput, ()),
    "rumple_wrinkle_layers_solve": (CHECKED, (WrinkleLayersPointer, POINTER(WrinkleMeshSettings), c_size_t,
        WrinkleLayersPaintPointer, POINTER(WrinkleLayersInput), WrinkleLayersStatePointer, POINTER(WrinkleMeshReport),
        c_size_t, POINTER(WrinkleLayersStatePointer))),
    "rumple_wrinkle_layers_show": (CHECKED, (WrinkleLayersPointer, c_void_p, c_size_t, c_void_p, c_size_t,
        WrinkleLayersStatePointer, c_bool, POINTER(FramePointer))),
    "rumple_wrinkle_transfer_plan_default": (WrinkleTransferPlan, ()),
    "rumple_wrinkle_transfer_build": (CHECKED, (SurfacePointer, CoarsePointer, WrinkleLayersPointer,
        POINTER(WrinkleTransferPlan), POINTER(WrinkleTransferPointer))),
    "rumple_wrinkle_transfer_free": (None, (WrinkleTransferPointer,)),
    "rumple_wrinkle_transfer_shown": (ShownMeshPointer, (WrinkleTransferPointer, c_bool)),
    "rumple_wrinkle_transfer_show": (CHECKED, (WrinkleTransferPointer, c_void_p, c_size_t, WrinkleLayersStatePointer,
        c_bool, POINTER(FramePointer))),
}
