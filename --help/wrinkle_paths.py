# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Paths: R. Gillette, Augmentation of Coarse Meshes with Wrinkles, UBC 2015 (with C. Peters). Folds
are traced over a coarse animated mesh, across its compression, and persist from frame to frame. No rest
pose is needed. docs/wrinkle_paths.md has the mathematics.

Written by scripts/declarations.py from native/include/rumple/wrinkle_paths.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .surface import *

FOLD_DIRECTION = {"OUTWARD": 0, "INWARD": 1, "BOTH": 2}
FOLD_PROFILE = {"SPLINE": 0, "QUARTIC": 1, "CIRCULAR_ARCS": 2, "SINE": 3}
WrinklePathsPointer = pointer_to("rumple_wrinkle_paths")
WrinklePathsPaintPointer = pointer_to("rumple_wrinkle_paths_paint")
WrinklePathsPosePointer = pointer_to("rumple_wrinkle_paths_pose")
WrinklePathsStatePointer = pointer_to("rumple_wrinkle_paths_state")
CurvesPointer = pointer_to("rumple_curves")
DrawingPointer = pointer_to("rumple_drawing")


class WrinklePathsView(Struct):
    """struct rumple_wrinkle_paths_view"""

    __slots__ = ()
    triangle_count: int  # t
    triangle_vertex: int | None  # (t, 3): welded vertices of the base's triangles
    _fields_ = (("triangle_count", c_int32), ("triangle_vertex", c_void_p),)


class WrinklePathsSettings(Struct):
    """struct rumple_wrinkle_paths_settings"""

    __slots__ = ()
    rest: ReferenceSettings  # the shape that compression is measured against, chapter 4
    smoothing: float  # temporal smoothing of the triangles' shapes, s, >= 0
    threshold: float  # tau: folds start where the compression is larger, > 1
    reach: float  # folds continue down to this share of tau's compression, 0..1
    width: float  # L_min: width of the tightest fold, object units, > 0
    spacing: float  # distance of seeds from folds / width, > 0
    alignment: float  # alpha of equation 5.2: low: folds stay in place, high: folds turn, >= 0
    bend_radius: float  # object units, >= 0: lines with a smaller radius get no folds; 0: all may
    hem_rings: int  # rings over which compression and height fade towards open borders, >= 0
    growth_limit: float  # largest change of a fold's length, share per 1/30 s, >= 0
    fade: float  # time in which a fold appears or disappears, s, >= 0
    persistent: bool  # false: every frame is traced independently
    seed: int  # seed of the places where folds may start
    profile: int  # rumple_fold_profile
    direction: int  # rumple_fold_direction
    height: float  # factor on the height that preserves the arc length, >= 0
    threads: int  # 0: chosen by size; never changes the result
    _fields_ = (("rest", ReferenceSettings), ("smoothing", c_float), ("threshold", c_float), ("reach", c_float),
        ("width", c_float), ("spacing", c_float), ("alignment", c_float), ("bend_radius", c_float),
        ("hem_rings", c_int32), ("growth_limit", c_float), ("fade", c_float), ("persistent", c_bool),
        ("seed", c_uint32), ("profile", c_int32), ("direction", c_int32), ("height", c_float), ("threads", c_int32),)


class WrinklePathsPainted(Struct):
    """struct rumple_wrinkle_paths_painted"""

    __slots__ = ()
    mask: int | None  # (n), 0..1: where folds may start, and how long they become; none: 1 everywhere
    mask_count: int
    width: int | None  # (n), 0.1..1: factor on the width; or none
    width_count: int
    along: int | None  # (n, 3): direction of the folds, see rumple_wrinkle_mesh_painted; or none
    along_count: int
    _fields_ = (("mask", c_void_p), ("mask_count", c_size_t), ("width", c_void_p), ("width_count", c_size_t),
        ("along", c_void_p), ("along_count", c_size_t),)


class WrinklePathsStateView(Struct):
    """struct rumple_wrinkle_paths_state_view"""

    __slots__ = ()
    reference: ReferenceView
    shapes: int | None  # (t, 3): in the format of `reference`, smoothed in time
    shapes_count: int
    compression: int | None  # (t): compression that the paths use
    compression_count: int
    width: int | None  # (t): painted factor on the width; none: 1 everywhere
    width_count: int
    path_id: int | None  # (paths): in order of creation, never reused
    path_id_count: int
    path_fade: int | None  # (paths): 0 when created, 1 at full height
    path_fade_count: int
    path_start: int | None  # (paths + 1): the first point of every path, then the number of points
    path_start_count: int
    point_triangle_edge: int | None  # (points, 2)
    point_triangle_edge_count: int
    point_at: int | None  # (points, 2)
    point_at_count: int
    next_id: int
    bytes: int  # memory of the state; not read by rumple_wrinkle_paths_state_build()
    _fields_ = (("reference", ReferenceView), ("shapes", c_void_p), ("shapes_count", c_size_t),
        ("compression", c_void_p), ("compression_count", c_size_t), ("width", c_void_p), ("width_count", c_size_t),
        ("path_id", c_void_p), ("path_id_count", c_size_t), ("path_fade", c_void_p), ("path_fade_count", c_size_t),
        ("path_start", c_void_p), ("path_start_count", c_size_t), ("point_triangle_edge", c_void_p),
        ("point_triangle_edge_count", c_size_t), ("point_at", c_void_p), ("point_at_count", c_size_t),
        ("next_id", c_int32), ("bytes", c_size_t),)


class WrinklePathsReport(Struct):
    """struct rumple_wrinkle_paths_report"""

    __slots__ = ()
    paths: int
    born: int
    died: int
    merging: int  # paths that are being shortened to where they cross an older one
    compressed: int  # triangles with this label
    stretched: int
    collapsed_triangles: int  # triangles without area in this pose
    moved_mean: float  # mean movement of path points along the surface in this frame / width
    moved_most: float  # ... and its 99th percentile
    _fields_ = (("paths", c_int32), ("born", c_int32), ("died", c_int32), ("merging", c_int32),
        ("compressed", c_int32), ("stretched", c_int32), ("collapsed_triangles", c_int32), ("moved_mean", c_float),
        ("moved_most", c_float),)


class FrameFoldsView(Struct):
    """struct rumple_frame_folds_view"""

    __slots__ = ()
    vertex_count: int  # d
    height: int | None  # (d): along the smooth normal, object units
    _fields_ = (("vertex_count", c_int32), ("height", c_void_p),)


class CurvesView(Struct):
    """struct rumple_curves_view"""

    __slots__ = ()
    curve_count: int  # c
    point_count: int  # p
    riding_count: int  # p from rumple_wrinkle_paths_ride(), else 0
    start: int | None  # (c + 1): the first point of every curve, then p
    id: int | None  # (c)
    positions: int | None  # (p, 3), object space
    width: int | None  # (p): width L, object units
    height: int | None  # (p): signed, object units
    corners: int | None  # (riding_count, 3): the base triangle of every point
    weights: int | None  # (riding_count, 2): u, v
    local_offset: int | None  # (riding_count, 3): o, in the frame of the deformed triangle, object units
    _fields_ = (("curve_count", c_int32), ("point_count", c_int32), ("riding_count", c_int32), ("start", c_void_p),
        ("id", c_void_p), ("positions", c_void_p), ("width", c_void_p), ("height", c_void_p), ("corners", c_void_p),
        ("weights", c_void_p), ("local_offset", c_void_p),)


class DrawingView(Struct):
    """struct rumple_drawing_view"""

    __slots__ = ()
    vertex_count: int  # w; 0 from rumple_wrinkle_paths_list()
    base_vertex_count: int  # n; likewise
    part_count: int  # t; likewise
    triangle_count: int  # t
    range_count: int  # r
    end_count: int  # e
    curved: bool  # false: straight triangles, for a linear attachment
    flat: int | None  # (w, 3): welded vertices of the deformed base; heights are measured from here
    smooth: int | None  # (w, 3): the same on the surface that the fine mesh is attached to
    normal: int | None  # (w, 3), unit
    hem: int | None  # (w): factor on the folds
    parts: int | None  # (t, 4): numbers of parts of a triangle and of its edges from corners 0, 1, 2
    proxy_offset: int | None  # (n, 3): from every vertex of the base to `smooth`
    triangle_start: int | None  # (t + 1): the first range of every triangle
    ranges: int | None  # (r, 2): first and end of the pieces that reach the triangle
    ends: int | None  # (e, 8): piece i is from end i to end i + 1; at, width, along, height
    _fields_ = (("vertex_count", c_int32), ("base_vertex_count", c_int32), ("part_count", c_int32),
        ("triangle_count", c_int32), ("range_count", c_int32), ("end_count", c_int32), ("curved", c_bool),
        ("flat", c_void_p), ("smooth", c_void_p), ("normal", c_void_p), ("hem", c_void_p), ("parts", c_void_p),
        ("proxy_offset", c_void_p), ("triangle_start", c_void_p), ("ranges", c_void_p), ("ends", c_void_p),)


WRINKLE_PATHS_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_wrinkle_paths_plan_default": (FinePlan, ()),
    "rumple_wrinkle_paths_build": (CHECKED, (SurfacePointer, POINTER(FinePlan), POINTER(WrinklePathsPointer))),
    "rumple_wrinkle_paths_free": (None, (WrinklePathsPointer,)),
    "rumple_wrinkle_paths_shown": (ShownMeshPointer, (WrinklePathsPointer,)),
    "rumple_wrinkle_paths_get_view": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsView))),
    "rumple_wrinkle_paths_settings_default": (WrinklePathsSettings, ()),
    "rumple_wrinkle_paths_paint_build": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsPainted),
        POINTER(WrinklePathsPaintPointer))),
    "rumple_wrinkle_paths_paint_free": (None, (WrinklePathsPaintPointer,)),
    "rumple_wrinkle_paths_pose_build": (CHECKED, (WrinklePathsPointer, POINTER(Pose),
        POINTER(WrinklePathsPosePointer))),
    "rumple_wrinkle_paths_pose_free": (None, (WrinklePathsPosePointer,)),
    "rumple_wrinkle_paths_state_free": (None, (WrinklePathsStatePointer,)),
    "rumple_wrinkle_paths_state_get_view": (CHECKED, (WrinklePathsStatePointer, POINTER(WrinklePathsStateView))),
    "rumple_wrinkle_paths_state_build": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsStateView),
        POINTER(WrinklePathsStatePointer))),
    "rumple_wrinkle_paths_state_check": (CHECKED, (WrinklePathsStatePointer,)),
    "rumple_wrinkle_paths_solve": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsSettings),
        WrinklePathsPaintPointer, WrinklePathsPosePointer, WrinklePathsStatePointer, POINTER(WrinklePathsReport),
        POINTER(WrinklePathsStatePointer))),
    "rumple_wrinkle_paths_show": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsSettings),
        WrinklePathsPosePointer, WrinklePathsStatePointer, POINTER(FramePointer))),
    "rumple_frame_get_folds": (CHECKED, (FramePointer, POINTER(FrameFoldsView))),
    "rumple_wrinkle_paths_label_clip": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsSettings), c_void_p,
        c_size_t, c_void_p, c_size_t, c_bool, c_void_p, c_size_t)),
    "rumple_curves_free": (None, (CurvesPointer,)),
    "rumple_curves_get_view": (CHECKED, (CurvesPointer, POINTER(CurvesView))),
    "rumple_wrinkle_paths_trace": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsSettings),
        WrinklePathsPosePointer, WrinklePathsStatePointer, POINTER(CurvesPointer))),
    "rumple_wrinkle_paths_ride": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsSettings),
        WrinklePathsPosePointer, c_void_p, c_size_t, WrinklePathsStatePointer, POINTER(CurvesPointer))),
    "rumple_wrinkle_paths_stretches": (CHECKED, (WrinklePathsPointer, WrinklePathsPosePointer,
        WrinklePathsStatePointer, c_void_p, c_size_t)),
    "rumple_wrinkle_paths_ellipses": (CHECKED, (WrinklePathsPointer, WrinklePathsPosePointer,
        WrinklePathsStatePointer, c_float, c_void_p, c_size_t)),
    "rumple_drawing_free": (None, (DrawingPointer,)),
    "rumple_drawing_get_view": (CHECKED, (DrawingPointer, POINTER(DrawingView))),
    "rumple_wrinkle_paths_draw": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsSettings),
        WrinklePathsPosePointer, WrinklePathsStatePointer, POINTER(DrawingPointer))),
    "rumple_wrinkle_paths_list": (CHECKED, (WrinklePathsPointer, POINTER(WrinklePathsSettings),
        WrinklePathsPosePointer, WrinklePathsStatePointer, POINTER(DrawingPointer))),
    "rumple_drawing_evaluate": (CHECKED, (DrawingPointer, POINTER(WrinklePathsSettings), c_void_p, c_void_p, c_size_t,
        c_void_p)),
}
