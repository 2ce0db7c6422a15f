# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Mesh: M. Mueller and N. Chentanez, Wrinkle Meshes, SCA 2010. A fine mesh attached to a coarse
animated one, relaxed by a static position-based solver. docs/wrinkle_mesh.md has the mathematics.

Written by scripts/declarations.py from native/include/rumple/wrinkle_mesh.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .surface import *

COLLISION = {"NONE": 0, "PLANE": 1, "NEIGHBOURHOOD": 2}
OFFSET_SPACE = {"TRIANGLE": 0, "WORLD": 1}
WrinkleMeshPointer = pointer_to("rumple_wrinkle_mesh")
WrinkleMeshPaintPointer = pointer_to("rumple_wrinkle_mesh_paint")
WrinkleMeshPosePointer = pointer_to("rumple_wrinkle_mesh_pose")
WrinkleMeshStatePointer = pointer_to("rumple_wrinkle_mesh_state")
WrinkleMeshPassesPointer = pointer_to("rumple_wrinkle_mesh_passes")


class WrinkleMeshPlan(Struct):
    """struct rumple_wrinkle_mesh_plan"""

    __slots__ = ()
    fine: FinePlan
    own: Any  # RUMPLE_FINE_OBJECT: a mesh at rest, in the base's space; else NULL
    attached: int | None  # (vertices of own): 0: not attached; or none: all are attached
    attached_count: int
    farthest: float  # `own` is refused if farther than this from the base, object units; 0: never
    display_steps: int  # further subdivisions of the shown mesh, which are not solved, >= 0
    viewport_steps: int  # ... of the mesh for viewports, >= 0; limited to display_steps
    adaptive: bool  # needed for settings whose reference is not RUMPLE_REFERENCE_STATIC_REST
    _fields_ = (("fine", FinePlan), ("own", SurfacePointer), ("attached", c_void_p), ("attached_count", c_size_t),
        ("farthest", c_float), ("display_steps", c_int32), ("viewport_steps", c_int32), ("adaptive", c_bool),)


class WrinkleMeshView(Struct):
    """struct rumple_wrinkle_mesh_view"""

    __slots__ = ()
    solved_vertex_count: int  # v
    pair_count: int  # distance and bending constraints
    unattached_count: int  # vertices of the own mesh, or 0
    base_vertex_count: int  # n
    welded_count: int  # w: welded vertices of the base
    local_edge: int | None  # (v): mean rest length of the edges around a vertex, object units
    unattached_distance: int | None  # (unattached_count): to the base at rest, object units
    welded_of: int | None  # (n): the welded vertex of every vertex of the base
    _fields_ = (("solved_vertex_count", c_int32), ("pair_count", c_int32), ("unattached_count", c_int32),
        ("base_vertex_count", c_int32), ("welded_count", c_int32), ("local_edge", c_void_p),
        ("unattached_distance", c_void_p), ("welded_of", c_void_p),)


class WrinkleMeshSettings(Struct):
    """struct rumple_wrinkle_mesh_settings"""

    __slots__ = ()
    radius: float  # r: attachment radius / mean length of the edges around a vertex, >= 0
    prestretch: float  # s: rest length / measured length, > 0
    bending: float  # k_bending, 0..1
    collision: int  # rumple_collision
    inside: float  # depth of the collision plane below the surface, in radii, 0..1
    stretch_relief: float  # share of the base's stretch that the rest lengths adopt, 0..1
    buckling_threshold: float  # compression of the base that causes no folds, share of the length, 0..1
    compression_limit: float  # largest rest length / length on the base, >= 1
    hem_rings: int  # rings over which r fades to 0 at open borders, >= 0
    iterations: int  # passes from a given state, >= 0
    start_iterations: int  # passes from the canonical start, >= 0
    damping: float  # share of the former offset that is kept, 0..1
    offset_space: int  # rumple_offset_space
    tangential_pull: float  # share of a vertex's offset along the surface that a pass removes, 0..1
    normal_pull: float  # the same for the offset along the normal, 0..1
    slack: float  # layers only: length / rest length at which the base is taut, > 0
    taut_range: float  # layers only: range below slack where s falls to prestretch, >= 0; 0: none
    hang: Array  # layers only: direction in which weight pulls cloth taut; object space, length 0..1
    # layers only, read from the first one: object units, >= 0: lines with a smaller radius of curvature get no folds;
    # 0: all lines may
    bend_radius: float
    # layers only: share of compression_limit - 1 where cloth touches what is worn under it, 0..1; with room for an
    # edge of the layer it is all of it
    contact_gather: float
    apart: float  # layers only: share of the distance to other cloth that a vertex may move, 0..0.5
    slide: float  # layers only: share of its triangles' heights that it may move along them, 0..0.5
    nudge: float  # size of the random push of unbuckled vertices, in fine edges, >= 0
    seed: int  # seed of this push
    threads: int  # 0: chosen by size; never changes the result
    rest: ReferenceSettings  # the shape that compression is measured against
    _fields_ = (("radius", c_float), ("prestretch", c_float), ("bending", c_float), ("collision", c_int32),
        ("inside", c_float), ("stretch_relief", c_float), ("buckling_threshold", c_float),
        ("compression_limit", c_float), ("hem_rings", c_int32), ("iterations", c_int32),
        ("start_iterations", c_int32), ("damping", c_float), ("offset_space", c_int32), ("tangential_pull", c_float),
        ("normal_pull", c_float), ("slack", c_float), ("taut_range", c_float), ("hang", c_float * 3),
        ("bend_radius", c_float), ("contact_gather", c_float), ("apart", c_float), ("slide", c_float),
        ("nudge", c_float), ("seed", c_uint32), ("threads", c_int32), ("rest", ReferenceSettings),)


class WrinkleMeshPainted(Struct):
    """struct rumple_wrinkle_mesh_painted"""

    __slots__ = ()
    radius: int | None  # r x value
    radius_count: int
    prestretch: int | None  # 1 + (s - 1) x value
    prestretch_count: int
    bending: int | None  # k x value
    bending_count: int
    inside: int | None  # inside x value
    inside_count: int
    worn: int | None  # 0: hangs free, so that its extra width does not count; 1: it counts
    worn_count: int
    along: int | None  # (n, 3): direction of the folds at rest, v and -v mean the same; its length,
    along_count: int  # 0..1, is the strength; or none
    _fields_ = (("radius", c_void_p), ("radius_count", c_size_t), ("prestretch", c_void_p),
        ("prestretch_count", c_size_t), ("bending", c_void_p), ("bending_count", c_size_t), ("inside", c_void_p),
        ("inside_count", c_size_t), ("worn", c_void_p), ("worn_count", c_size_t), ("along", c_void_p),
        ("along_count", c_size_t),)


class WrinkleMeshStateView(Struct):
    """struct rumple_wrinkle_mesh_state_view"""

    __slots__ = ()
    offset: int | None  # (v, 3): o_i, in the frame of the base triangle, or in the world
    offset_count: int
    solved_length: int | None  # (pairs): length at the attachments in the last solve / rest scale
    solved_length_count: int
    reference: ReferenceView  # of an adaptive rest shape
    bytes: int  # memory of the state; not read by rumple_wrinkle_mesh_state_build()
    _fields_ = (("offset", c_void_p), ("offset_count", c_size_t), ("solved_length", c_void_p),
        ("solved_length_count", c_size_t), ("reference", ReferenceView), ("bytes", c_size_t),)


class WrinkleMeshReport(Struct):
    """struct rumple_wrinkle_mesh_report"""

    __slots__ = ()
    iterations: int  # 0: all vertices were asleep, nothing was solved
    error_before: float  # RMS relative length error of the distance constraints at the attachments
    error_after: float  # ... and of the solved mesh
    largest_error: float  # largest relative length error of the solved mesh
    active: float  # share of the vertices that were solved, 0..1; the others were asleep
    collapsed_triangles: int  # triangles of the base without area in this pose
    kept_apart: int  # vertices that other cloth or a body in front stopped
    _fields_ = (("iterations", c_int32), ("error_before", c_float), ("error_after", c_float),
        ("largest_error", c_float), ("active", c_float), ("collapsed_triangles", c_int32), ("kept_apart", c_int32),)


class WrinkleMeshMeasures(Struct):
    """struct rumple_wrinkle_mesh_measures"""

    __slots__ = ()
    edge_error_before_rms: float  # |length - s l0| / (s l0) of the fine mesh at its attachments
    edge_error_before_max: float
    edge_error_after_rms: float  # ... and solved
    edge_error_after_max: float
    compressed_area_before: float  # area / rest area, where base triangles have less than 0.9 of their rest area
    compressed_area_after: float
    attachment_violation: float  # largest (|o| - r) / r over attached vertices with r > 0, at least 0
    largest_offset: float  # object units
    _fields_ = (("edge_error_before_rms", c_float), ("edge_error_before_max", c_float),
        ("edge_error_after_rms", c_float), ("edge_error_after_max", c_float), ("compressed_area_before", c_float),
        ("compressed_area_after", c_float), ("attachment_violation", c_float), ("largest_offset", c_float),)


class WrinkleMeshPassesView(Struct):
    """struct rumple_wrinkle_mesh_passes_view"""

    __slots__ = ()
    vertex_count: int  # v
    triangle_count: int  # t: triangles of the base
    pair_count: int  # p, in the order of a state's solved_length
    distance_count: int  # the first of them keep distances, the others resist bending
    pass_count: int  # passes of an iteration
    limit_count: int  # m; 0: attached to triangles
    curved: bool  # attached to PN triangles
    triangles: int | None  # (t, 3): welded vertices of the base's triangles
    vertex: int | None  # (v): the solved vertex
    base_vertices: int | None  # (v, 3): welded vertices of the base's triangle that it is attached to
    weights: int | None  # (v, 2): of the second and the third of them
    limit_start: int | None  # (v + 1): row of every vertex, or (1) without limit surface
    limit_vertex: int | None  # (m): welded vertices
    limit_weight: int | None  # (m)
    radius: int | None  # (v): attachment radius
    depth: int | None  # (v): how far below its attachment it may be
    push: int | None  # (v): largest random push of an unbuckled vertex
    noise: int | None  # (v): -1..1: share and direction of this push
    pairs: int | None  # (p, 2): vertices, in the order of `vertex`
    of_pass: int | None  # (p): its pass, 0..pass_count - 1
    rest: int | None  # (p): length at rest
    stretched: int | None  # (p): s times it
    stiffness: int | None  # (p): 0..1; of distances 1
    _fields_ = (("vertex_count", c_int32), ("triangle_count", c_int32), ("pair_count", c_int32),
        ("distance_count", c_int32), ("pass_count", c_int32), ("limit_count", c_int32), ("curved", c_bool),
        ("triangles", c_void_p), ("vertex", c_void_p), ("base_vertices", c_void_p), ("weights", c_void_p),
        ("limit_start", c_void_p), ("limit_vertex", c_void_p), ("limit_weight", c_void_p), ("radius", c_void_p),
        ("depth", c_void_p), ("push", c_void_p), ("noise", c_void_p), ("pairs", c_void_p), ("of_pass", c_void_p),
        ("rest", c_void_p), ("stretched", c_void_p), ("stiffness", c_void_p),)


WRINKLE_MESH_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_wrinkle_mesh_plan_default": (WrinkleMeshPlan, ()),
    "rumple_wrinkle_mesh_build": (CHECKED, (SurfacePointer, POINTER(WrinkleMeshPlan), POINTER(WrinkleMeshPointer))),
    "rumple_wrinkle_mesh_free": (None, (WrinkleMeshPointer,)),
    "rumple_wrinkle_mesh_shown": (ShownMeshPointer, (WrinkleMeshPointer, c_bool)),
    "rumple_wrinkle_mesh_get_view": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshView))),
    "rumple_wrinkle_mesh_settings_default": (WrinkleMeshSettings, ()),
    "rumple_wrinkle_mesh_paint_build": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshPainted),
        POINTER(WrinkleMeshPaintPointer))),
    "rumple_wrinkle_mesh_paint_free": (None, (WrinkleMeshPaintPointer,)),
    "rumple_wrinkle_mesh_pose_build": (CHECKED, (WrinkleMeshPointer, POINTER(Pose), POINTER(WrinkleMeshPosePointer))),
    "rumple_wrinkle_mesh_pose_free": (None, (WrinkleMeshPosePointer,)),
    "rumple_wrinkle_mesh_state_free": (None, (WrinkleMeshStatePointer,)),
    "rumple_wrinkle_mesh_state_get_view": (CHECKED, (WrinkleMeshStatePointer, POINTER(WrinkleMeshStateView))),
    "rumple_wrinkle_mesh_state_build": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshStateView),
        POINTER(WrinkleMeshStatePointer))),
    "rumple_wrinkle_mesh_state_activated": (CHECKED, (WrinkleMeshStatePointer, POINTER(WrinkleMeshStatePointer))),
    "rumple_wrinkle_mesh_solve": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshSettings), WrinkleMeshPaintPointer,
        WrinkleMeshPosePointer, WrinkleMeshStatePointer, POINTER(WrinkleMeshReport),
        POINTER(WrinkleMeshStatePointer))),
    "rumple_wrinkle_mesh_show": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshSettings), WrinkleMeshPosePointer,
        WrinkleMeshStatePointer, c_bool, POINTER(FramePointer))),
    "rumple_wrinkle_mesh_measure": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshSettings),
        WrinkleMeshPaintPointer, WrinkleMeshPosePointer, WrinkleMeshStatePointer, POINTER(WrinkleMeshMeasures),
        c_void_p, c_size_t)),
    "rumple_wrinkle_mesh_label_clip": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshSettings), c_void_p, c_size_t,
        c_void_p, c_size_t, c_bool, c_void_p, c_size_t)),
    "rumple_wrinkle_mesh_passes_build": (CHECKED, (WrinkleMeshPointer, POINTER(WrinkleMeshSettings),
        WrinkleMeshPaintPointer, POINTER(WrinkleMeshPassesPointer))),
    "rumple_wrinkle_mesh_passes_free": (None, (WrinkleMeshPassesPointer,)),
    "rumple_wrinkle_mesh_passes_get_view": (CHECKED, (WrinkleMeshPassesPointer, POINTER(WrinkleMeshPassesView))),
    "rumple_wrinkle_mesh_weld_pose": (CHECKED, (WrinkleMeshPointer, c_void_p, c_size_t, c_void_p, c_void_p, c_void_p,
        c_size_t)),
}
