# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: the coarse base mesh, the shown mesh that replaces it, a frame of the shown mesh, and the pose.

Written by scripts/declarations.py from native/include/rumple/surface.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .base import *

FINE_SOURCE = {"SUBDIVISION": 0, "REGULAR": 1, "EDGE_LENGTH": 2, "OBJECT": 3}
ATTACHMENT = {"LINEAR": 0, "PN": 1, "LIMIT": 2}
REFERENCE = {"REST": 0, "FIRST_FRAME": 1, "STATIC_REST": 2}
SurfacePointer = pointer_to("rumple_surface")
HealedPointer = pointer_to("rumple_healed")
CoarsePointer = pointer_to("rumple_coarse")
ShownMeshPointer = pointer_to("rumple_shown_mesh")
FramePointer = pointer_to("rumple_frame")


class SurfacePlan(Struct):
    """struct rumple_surface_plan"""

    __slots__ = ()
    positions_rest: int | None  # (n, 3), object space, finite
    positions_rest_count: int
    polygon_start: int | None  # (polygons + 1), ascending from 0 to the number of corners
    polygon_start_count: int
    corner_vertex: int | None  # (corners), 0..n - 1
    corner_vertex_count: int
    triangle_corner: int | None  # (t, 3): corners of the same polygon; c corners give c - 2 triangles
    triangle_corner_count: int
    weld_seams: bool  # join border vertices at the same place
    crease_edge: int | None  # (k, 2): vertices, 0..n - 1; or none
    crease_edge_count: int
    crease_sharpness: int | None  # (k): number of subdivisions an edge stays sharp, >= 0; >= 10: always
    crease_sharpness_count: int
    _fields_ = (("positions_rest", c_void_p), ("positions_rest_count", c_size_t), ("polygon_start", c_void_p),
        ("polygon_start_count", c_size_t), ("corner_vertex", c_void_p), ("corner_vertex_count", c_size_t),
        ("triangle_corner", c_void_p), ("triangle_corner_count", c_size_t), ("weld_seams", c_bool),
        ("crease_edge", c_void_p), ("crease_edge_count", c_size_t), ("crease_sharpness", c_void_p),
        ("crease_sharpness_count", c_size_t),)


class HealedView(Struct):
    """struct rumple_healed_view"""

    __slots__ = ()
    vertex_count: int  # n
    polygon_count: int  # p
    corner_count: int  # c
    triangle_count: int  # t
    turned_count: int
    cut_count: int
    doubled_count: int
    repeated_count: int
    polygon_start: int | None  # (p + 1)
    corner_vertex: int | None  # (c)
    triangle_corner: int | None  # (t, 3)
    vertex_source: int | None  # (n): vertex of the mesh
    corner_source: int | None  # (c): corner of the mesh
    polygon_source: int | None  # (p): polygon of the mesh
    turned: int | None  # (turned_count): polygons of the mesh whose winding was reversed
    cut: int | None  # (cut_count, 2): edges of the mesh at which polygons were cut off
    doubled: int | None  # (doubled_count, 2): a polygon that was left out, and the polygon below it
    repeated: int | None  # (repeated_count): polygons that use a vertex twice
    _fields_ = (("vertex_count", c_int32), ("polygon_count", c_int32), ("corner_count", c_int32),
        ("triangle_count", c_int32), ("turned_count", c_int32), ("cut_count", c_int32), ("doubled_count", c_int32),
        ("repeated_count", c_int32), ("polygon_start", c_void_p), ("corner_vertex", c_void_p),
        ("triangle_corner", c_void_p), ("vertex_source", c_void_p), ("corner_source", c_void_p),
        ("polygon_source", c_void_p), ("turned", c_void_p), ("cut", c_void_p), ("doubled", c_void_p),
        ("repeated", c_void_p),)


class SurfaceView(Struct):
    """struct rumple_surface_view"""

    __slots__ = ()
    vertex_count: int  # n
    welded_vertex_count: int  # w
    triangle_count: int  # t
    warning_count: int
    _fields_ = (("vertex_count", c_int32), ("welded_vertex_count", c_int32), ("triangle_count", c_int32),
        ("warning_count", c_int32),)


class CoarseView(Struct):
    """struct rumple_coarse_view"""

    __slots__ = ()
    vertex_count: int  # m
    mean_edge: float  # mean length of its edges, object units
    base_vertex: int | None  # (m): for every vertex the nearest vertex of the base mesh
    _fields_ = (("vertex_count", c_int32), ("mean_edge", c_float), ("base_vertex", c_void_p),)


class FinePlan(Struct):
    """struct rumple_fine_plan"""

    __slots__ = ()
    source: int  # rumple_fine_source
    level: int  # >= 0
    segments: int  # >= 1
    longest_edge: float  # object units, > 0
    most_vertices: int  # a fine mesh with more vertices is refused
    attachment: int  # rumple_attachment: the surface that fine vertices are attached to
    _fields_ = (("source", c_int32), ("level", c_int32), ("segments", c_int32), ("longest_edge", c_float),
        ("most_vertices", c_int32), ("attachment", c_int32),)


class ShownMeshView(Struct):
    """struct rumple_shown_mesh_view"""

    __slots__ = ()
    vertex_count: int  # d
    polygon_count: int  # q
    corner_count: int  # k
    edge_count: int  # e
    solved_count: int  # m
    polygon_start: int | None  # (q + 1): the first corner of every polygon, then k
    corner_vertex: int | None  # (k)
    polygon_source: int | None  # (q): polygon of the source
    edges: int | None  # (e, 2): the shown edges that lie on edges of the source
    edge_sources: int | None  # (e, 2): these edges of the source
    positions_rest: int | None  # (d, 3), object space
    triangle_vertex: int | None  # (d, 3): the base triangle that every shown vertex is embedded in
    barycentric: int | None  # (d, 2): weights of its second and third vertex
    solved_start: int | None  # (d + 1): the first entry of every shown vertex, then m
    solved_vertex: int | None  # (m): the solved vertices that its position is made from
    solved_weight: int | None  # (m): their weights
    _fields_ = (("vertex_count", c_int32), ("polygon_count", c_int32), ("corner_count", c_int32),
        ("edge_count", c_int32), ("solved_count", c_int32), ("polygon_start", c_void_p), ("corner_vertex", c_void_p),
        ("polygon_source", c_void_p), ("edges", c_void_p), ("edge_sources", c_void_p), ("positions_rest", c_void_p),
        ("triangle_vertex", c_void_p), ("barycentric", c_void_p), ("solved_start", c_void_p),
        ("solved_vertex", c_void_p), ("solved_weight", c_void_p),)


class Pose(Struct):
    """struct rumple_pose"""

    __slots__ = ()
    positions: int | None  # (n, 3): the deformed base, object space, finite
    positions_count: int
    time: float  # s: frame number / frame rate; read by Wrinkle Paths, and with an adaptive rest shape
    labels: int | None  # (t), or none
    labels_count: int
    next_positions: int | None  # (n, 3): the next frame, which labelling looks ahead to; or none
    next_positions_count: int
    next_time: float  # s, > time, if there is a next frame
    world_from_object: Array  # (3, 3); read by the Wrinkle Mesh with RUMPLE_OFFSETS_WORLD
    _fields_ = (("positions", c_void_p), ("positions_count", c_size_t), ("time", c_double), ("labels", c_void_p),
        ("labels_count", c_size_t), ("next_positions", c_void_p), ("next_positions_count", c_size_t),
        ("next_time", c_double), ("world_from_object", c_float * 9),)


class FrameView(Struct):
    """struct rumple_frame_view"""

    __slots__ = ()
    vertex_count: int  # d
    positions: int | None  # (d, 3), object space
    local_offset: int | None  # (d, 3): from the linear embedding, in the deformed triangle's frame
    offset: int | None  # (d, 3): from the unwrinkled surface, object space
    stretch_min: int | None  # (d): the smaller principal stretch of the base, 1 at rest
    stretch_max: int | None  # (d): the larger one
    stretch_direction: int | None  # (d, 3): direction of strongest compression, unit, object space
    _fields_ = (("vertex_count", c_int32), ("positions", c_void_p), ("local_offset", c_void_p), ("offset", c_void_p),
        ("stretch_min", c_void_p), ("stretch_max", c_void_p), ("stretch_direction", c_void_p),)


class ReferenceSettings(Struct):
    """struct rumple_reference_settings"""

    __slots__ = ()
    reference: int  # rumple_reference
    window: float  # labels compare with the pose this long ago, s, 0..10; 0: the previous frame
    relaxation: float  # share per 1/30 s by which compressed reference triangles shrink, 0..1
    growth: float  # largest length of a reference triangle / length in the rest pose, >= 1
    growth_time: float  # time in which a reference triangle adopts a longer shape, s, 0..10
    _fields_ = (("reference", c_int32), ("window", c_float), ("relaxation", c_float), ("growth", c_float),
        ("growth_time", c_float),)


class ReferenceView(Struct):
    """struct rumple_reference_view"""

    __slots__ = ()
    time: float  # s
    labels: int | None  # (t): 0 compress, 1 rest, 2 stretch
    labels_count: int
    reference: int | None  # (t, 3): x1, x2, y2 of the edges (x1, 0) and (x2, y2) in the triangle's plane
    reference_count: int  # 0: the rest shape does not adapt
    past_times: int | None  # times of the poses that labels still need, oldest first, s
    past_times_count: int
    past_positions: int | None  # (poses x w, 3), object space
    past_positions_count: int
    _fields_ = (("time", c_double), ("labels", c_void_p), ("labels_count", c_size_t), ("reference", c_void_p),
        ("reference_count", c_size_t), ("past_times", c_void_p), ("past_times_count", c_size_t),
        ("past_positions", c_void_p), ("past_positions_count", c_size_t),)


SURFACE_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_surface_plan_default": (SurfacePlan, ()),
    "rumple_healed_build": (CHECKED, (POINTER(SurfacePlan), POINTER(HealedPointer))),
    "rumple_healed_free": (None, (HealedPointer,)),
    "rumple_healed_get_view": (CHECKED, (HealedPointer, POINTER(HealedView))),
    "rumple_surface_build": (CHECKED, (POINTER(SurfacePlan), POINTER(SurfacePointer))),
    "rumple_surface_free": (None, (SurfacePointer,)),
    "rumple_surface_get_view": (CHECKED, (SurfacePointer, POINTER(SurfaceView))),
    "rumple_surface_warning": (c_char_p, (SurfacePointer, c_int32)),
    "rumple_surface_count_openings": (CHECKED, (SurfacePointer, c_void_p)),
    "rumple_surface_is_uneven": (CHECKED, (SurfacePointer, c_float, c_void_p)),
    "rumple_surface_outer_side": (CHECKED, (SurfacePointer, c_void_p, c_size_t, c_void_p)),
    "rumple_surface_suggest_follow": (CHECKED, (SurfacePointer, c_void_p, c_void_p, c_size_t)),
    "rumple_surface_sewn_on": (CHECKED, (SurfacePointer, c_void_p, c_void_p, c_size_t)),
    "rumple_coarse_build": (CHECKED, (SurfacePointer, c_float, POINTER(CoarsePointer))),
    "rumple_coarse_build_of": (CHECKED, (SurfacePointer, SurfacePointer, c_float, POINTER(CoarsePointer))),
    "rumple_coarse_as_modelled": (CHECKED, (SurfacePointer, SurfacePointer, c_float, c_float,
        POINTER(CoarsePointer))),
    "rumple_coarse_free": (None, (CoarsePointer,)),
    "rumple_coarse_get_view": (CHECKED, (CoarsePointer, POINTER(CoarseView))),
    "rumple_coarse_surface": (CHECKED, (CoarsePointer, POINTER(SurfacePointer))),
    "rumple_coarse_positions": (CHECKED, (CoarsePointer, c_void_p, c_size_t, c_void_p, c_size_t)),
    "rumple_coarse_paint": (CHECKED, (CoarsePointer, c_void_p, c_size_t, c_void_p, c_size_t)),
    "rumple_shown_mesh_get_view": (CHECKED, (ShownMeshPointer, POINTER(ShownMeshView))),
    "rumple_shown_mesh_carry_points": (CHECKED, (ShownMeshPointer, c_void_p, c_size_t, c_int32, c_void_p, c_size_t)),
    "rumple_shown_mesh_carry_corners": (CHECKED, (ShownMeshPointer, c_void_p, c_size_t, c_int32, c_void_p, c_size_t)),
    "rumple_rigid_motions": (CHECKED, (c_void_p, c_size_t, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p,
        c_size_t)),
    "rumple_pose_default": (Pose, ()),
    "rumple_frame_free": (None, (FramePointer,)),
    "rumple_frame_get_view": (CHECKED, (FramePointer, POINTER(FrameView))),
    "rumple_frame_embed": (CHECKED, (FramePointer, c_void_p, c_size_t)),
}
