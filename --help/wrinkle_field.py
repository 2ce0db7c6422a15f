# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Field: J. Loviscach, Wrinkling Coarse Meshes on the GPU, Eurographics 2006. Every vertex of the
coarse mesh has a plane wave. Its height and direction follow from the deformation, its phase from a
relaxation. docs/wrinkle_field.md has the mathematics. See also wrinkle_field_brush.h.

Written by scripts/declarations.py from native/include/rumple/wrinkle_field.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .surface import *

PROFILE_INTERVALS = 64
FIELD_OUTPUT = {"SHADING": 0, "GEOMETRY": 1}
PROFILE = {"SINE": 0, "ACCORDION": 1, "PENCIL_PLEATS": 2, "CURVE": 3}
WrinkleFieldPointer = pointer_to("rumple_wrinkle_field")
WrinkleFieldPaintPointer = pointer_to("rumple_wrinkle_field_paint")
WrinkleFieldPosePointer = pointer_to("rumple_wrinkle_field_pose")
WrinkleFieldStatePointer = pointer_to("rumple_wrinkle_field_state")
WavesPointer = pointer_to("rumple_waves")


class WrinkleFieldPlan(Struct):
    """struct rumple_wrinkle_field_plan"""

    __slots__ = ()
    output: int  # rumple_field_output
    fine: FinePlan  # for RUMPLE_FIELD_GEOMETRY
    uv: int | None  # (corners of the base, 2): for parallax with RUMPLE_FIELD_SHADING; or none
    uv_count: int
    true_lengths: bool  # true: equation (1) uses lengths of edges; false: of their projections, as in the paper
    _fields_ = (("output", c_int32), ("fine", FinePlan), ("uv", c_void_p), ("uv_count", c_size_t),
        ("true_lengths", c_bool),)


class WrinkleFieldView(Struct):
    """struct rumple_wrinkle_field_view"""

    __slots__ = ()
    vertex_count: int  # w
    neighbour_count: int  # m
    base_vertex_count: int  # n
    triangle_count: int  # t, of the base
    uv_count: int  # 3 t, or 0 without a uv
    neighbour_start: int | None  # (w + 1): the first neighbour of every vertex
    neighbours: int | None  # (m): welded vertices
    gradients: int | None  # (m, 2): M of equation (1) is the sum of v' (x) gradient
    tangent_rest: int | None  # (w, 3): tangent t of the rest frame; zero without a normal
    bitangent_rest: int | None  # (w, 3): bitangent b of the rest frame
    welded_of: int | None  # (n): the welded vertex of every vertex of the base
    triangles: int | None  # (t, 3): welded vertices of the base's triangles
    uv: int | None  # (uv_count, 2): for each corner of every triangle in order
    uv_fan: int | None  # (uv_count): corners with the same fan number share their uv gradient
    first_directions: int | None  # (w, 2): k at the start of a clip, rest frame
    _fields_ = (("vertex_count", c_int32), ("neighbour_count", c_int32), ("base_vertex_count", c_int32),
        ("triangle_count", c_int32), ("uv_count", c_int32), ("neighbour_start", c_void_p), ("neighbours", c_void_p),
        ("gradients", c_void_p), ("tangent_rest", c_void_p), ("bitangent_rest", c_void_p), ("welded_of", c_void_p),
        ("triangles", c_void_p), ("uv", c_void_p), ("uv_fan", c_void_p), ("first_directions", c_void_p),)


class WrinkleFieldSettings(Struct):
    """struct rumple_wrinkle_field_settings"""

    __slots__ = ()
    wavelength: float  # W in rest space, object units, > 0
    strength: float  # factor on the amplitude of equation (2), >= 0
    buckling_threshold: float  # compression that causes no waves, share of the length, 0..0.99
    keep_length: bool  # geometry: limit the waves to the length of the cloth at rest
    rate: float  # epsilon / (2 pi^2) of equation (6), 0..1; stable below 1
    rounds: int  # rounds of relaxation from a given state, >= 0
    start_rounds: int  # from the canonical start, >= 0
    irregularity: float  # 0..1; 0: regular, like cloth, 1: like skin
    bend_radius: float  # object units, >= 0: lines with a smaller radius get no waves; 0: all may
    seed: int  # of the first phases and of the irregularity
    aligned_start: bool  # true: align the random first phases; false: random, as in the paper
    threads: int  # 0: chosen by size; never changes the result
    dissolve: bool  # reduce waves that do not match their neighbours
    rest: ReferenceSettings  # the shape that compression is measured against
    _fields_ = (("wavelength", c_float), ("strength", c_float), ("buckling_threshold", c_float),
        ("keep_length", c_bool), ("rate", c_float), ("rounds", c_int32), ("start_rounds", c_int32),
        ("irregularity", c_float), ("bend_radius", c_float), ("seed", c_uint32), ("aligned_start", c_bool),
        ("threads", c_int32), ("dissolve", c_bool), ("rest", ReferenceSettings),)


class WrinkleFieldProfile(Struct):
    """struct rumple_wrinkle_field_profile"""

    __slots__ = ()
    height: Array  # f, -1..1
    slope: Array  # df/dphi
    _fields_ = (("height", c_float * 65), ("slope", c_float * 65),)


class WrinkleFieldPainted(Struct):
    """struct rumple_wrinkle_field_painted"""

    __slots__ = ()
    mask: int | None  # (n): factor on the amplitude, 0..1
    mask_count: int
    wavelength: int | None  # (n), 0.001..1000: factor on W; or none
    wavelength_count: int
    rest_wrinkle: int | None  # (n, 3): p of section 7, along the compression, rest space, shorter than 1
    rest_wrinkle_count: int
    along: int | None  # (n, 3): direction of the waves' crests, see rumple_wrinkle_mesh_painted
    along_count: int
    _fields_ = (("mask", c_void_p), ("mask_count", c_size_t), ("wavelength", c_void_p),
        ("wavelength_count", c_size_t), ("rest_wrinkle", c_void_p), ("rest_wrinkle_count", c_size_t),
        ("along", c_void_p), ("along_count", c_size_t),)


class WrinkleFieldStateView(Struct):
    """struct rumple_wrinkle_field_state_view"""

    __slots__ = ()
    phase: int | None  # (w): phi, radians
    phase_count: int
    direction: int | None  # (w, 2): k in the rest frame, with the sign that phi belongs to
    direction_count: int
    solved_offset: int | None  # (m): phase offsets in the last relaxation, radians
    solved_offset_count: int
    reference: ReferenceView  # of an adaptive rest shape
    bytes: int  # memory of the state; not read by rumple_wrinkle_field_state_build()
    _fields_ = (("phase", c_void_p), ("phase_count", c_size_t), ("direction", c_void_p),
        ("direction_count", c_size_t), ("solved_offset", c_void_p), ("solved_offset_count", c_size_t),
        ("reference", ReferenceView), ("bytes", c_size_t),)


class WrinkleFieldReport(Struct):
    """struct rumple_wrinkle_field_report"""

    __slots__ = ()
    rounds: int  # of relaxation
    misfit_before: float  # RMS phase error over edges, turns, 0..0.5
    misfit_after: float
    largest_change: float  # largest change of a phase since the given state, radians
    wrinkled: int  # vertices with a wave
    collapsed: int  # vertices without a wave because their neighbourhood collapsed
    _fields_ = (("rounds", c_int32), ("misfit_before", c_float), ("misfit_after", c_float),
        ("largest_change", c_float), ("wrinkled", c_int32), ("collapsed", c_int32),)


class FrameWavesView(Struct):
    """struct rumple_frame_waves_view"""

    __slots__ = ()
    vertex_count: int  # d
    corner_count: int  # 3 t with RUMPLE_FIELD_SHADING, else 0
    uv_count: int  # corner_count with a uv, else 0
    amplitude: int | None  # (d): h, object units
    direction: int | None  # (d, 3): k, unit, rest space
    phase: int | None  # (d): phi, radians
    corner_phase: int | None  # (corner_count, 3): radians, without whole turns per triangle
    corner_weight: int | None  # (corner_count, 3): (h, 0, 0) at the first corner, object units
    corner_wave_vector_0: int | None  # (corner_count, 3): 2 pi / W k' of the first corner
    corner_wave_vector_1: int | None  # ... the second
    corner_wave_vector_2: int | None  # ... the third
    corner_u_gradient: int | None  # (uv_count, 3): du/dx' of equation (11), continuous over edges
    corner_v_gradient: int | None  # (uv_count, 3)
    _fields_ = (("vertex_count", c_int32), ("corner_count", c_int32), ("uv_count", c_int32), ("amplitude", c_void_p),
        ("direction", c_void_p), ("phase", c_void_p), ("corner_phase", c_void_p), ("corner_weight", c_void_p),
        ("corner_wave_vector_0", c_void_p), ("corner_wave_vector_1", c_void_p), ("corner_wave_vector_2", c_void_p),
        ("corner_u_gradient", c_void_p), ("corner_v_gradient", c_void_p),)


class WavesView(Struct):
    """struct rumple_waves_view"""

    __slots__ = ()
    vertex_count: int  # w
    positions: int | None  # (w, 3): deformed, object space
    normals: int | None  # (w, 3): unit, or zero
    wave_vector: int | None  # (w, 3): 2 pi / W k', radians per object unit
    height: int | None  # (w): h, object units
    fullness: int | None  # (w): h / (W / 4), before strength
    compression: int | None  # (w): r
    gather: int | None  # (w): rest length / length along the wave
    direction: int | None  # (w, 2): k, rest frame
    _fields_ = (("vertex_count", c_int32), ("positions", c_void_p), ("normals", c_void_p), ("wave_vector", c_void_p),
        ("height", c_void_p), ("fullness", c_void_p), ("compression", c_void_p), ("gather", c_void_p),
        ("direction", c_void_p),)


class WrinkleFieldWaveParameters(Struct):
    """struct rumple_wrinkle_field_wave_parameters"""

    __slots__ = ()
    wavelength: int | None  # (w): W, object units
    mask: int | None  # (w): factor on the amplitude
    rest_wrinkle: int | None  # (w, 2): q, rest frame
    turn: int | None  # (w, 2): (cos, sin) of the rotation away from k
    count: int  # w
    _fields_ = (("wavelength", c_void_p), ("mask", c_void_p), ("rest_wrinkle", c_void_p), ("turn", c_void_p),
        ("count", c_size_t),)


WRINKLE_FIELD_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_wrinkle_field_plan_default": (WrinkleFieldPlan, ()),
    "rumple_wrinkle_field_build": (CHECKED, (SurfacePointer, POINTER(WrinkleFieldPlan),
        POINTER(WrinkleFieldPointer))),
    "rumple_wrinkle_field_free": (None, (WrinkleFieldPointer,)),
    "rumple_wrinkle_field_shown": (ShownMeshPointer, (WrinkleFieldPointer,)),
    "rumple_wrinkle_field_get_view": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldView))),
    "rumple_wrinkle_field_settings_default": (WrinkleFieldSettings, ()),
    "rumple_wrinkle_field_profile_build": (CHECKED, (c_int32, c_void_p, c_size_t, POINTER(WrinkleFieldProfile))),
    "rumple_wrinkle_field_paint_build": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldPainted),
        POINTER(WrinkleFieldPaintPointer))),
    "rumple_wrinkle_field_paint_free": (None, (WrinkleFieldPaintPointer,)),
    "rumple_wrinkle_field_pose_build": (CHECKED, (WrinkleFieldPointer, POINTER(Pose),
        POINTER(WrinkleFieldPosePointer))),
    "rumple_wrinkle_field_pose_free": (None, (WrinkleFieldPosePointer,)),
    "rumple_wrinkle_field_state_free": (None, (WrinkleFieldStatePointer,)),
    "rumple_wrinkle_field_state_get_view": (CHECKED, (WrinkleFieldStatePointer, POINTER(WrinkleFieldStateView))),
    "rumple_wrinkle_field_state_build": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldStateView),
        POINTER(WrinkleFieldStatePointer))),
    "rumple_wrinkle_field_state_activated": (CHECKED, (WrinkleFieldStatePointer, POINTER(WrinkleFieldStatePointer))),
    "rumple_waves_free": (None, (WavesPointer,)),
    "rumple_wrinkle_field_solve": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldSettings),
        WrinkleFieldPaintPointer, WrinkleFieldPosePointer, WrinkleFieldStatePointer, POINTER(WrinkleFieldReport),
        POINTER(WavesPointer), POINTER(WrinkleFieldStatePointer))),
    "rumple_wrinkle_field_show": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldSettings),
        POINTER(WrinkleFieldProfile), WrinkleFieldPaintPointer, WrinkleFieldPosePointer, c_void_p, c_size_t,
        WavesPointer, WrinkleFieldStatePointer, POINTER(FramePointer))),
    "rumple_frame_get_waves": (CHECKED, (FramePointer, POINTER(FrameWavesView))),
    "rumple_wrinkle_field_label_clip": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldSettings), c_void_p,
        c_size_t, c_void_p, c_size_t, c_bool, c_void_p, c_size_t)),
    "rumple_waves_get_view": (CHECKED, (WavesPointer, POINTER(WavesView))),
    "rumple_wrinkle_field_estimate_waves": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldSettings),
        WrinkleFieldPaintPointer, c_void_p, c_size_t, WrinkleFieldStatePointer, POINTER(WavesPointer))),
    "rumple_wrinkle_field_shown_waves": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldSettings),
        POINTER(WrinkleFieldProfile), WrinkleFieldPaintPointer, c_void_p, c_size_t, WrinkleFieldStatePointer,
        POINTER(WavesPointer))),
    "rumple_wrinkle_field_get_wave_parameters": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldSettings),
        WrinkleFieldPaintPointer, POINTER(WrinkleFieldWaveParameters))),
    "rumple_wrinkle_field_weld_pose": (CHECKED, (WrinkleFieldPointer, c_void_p, c_size_t, c_void_p, c_void_p,
        c_size_t)),
    "rumple_wrinkle_field_stretches": (CHECKED, (WrinkleFieldPointer, WrinkleFieldStatePointer, c_void_p, c_size_t,
        c_void_p, c_size_t, c_void_p)),
    "rumple_wrinkle_field_random_phases": (CHECKED, (WrinkleFieldPointer, c_uint32, c_void_p, c_size_t)),
    "rumple_wrinkle_field_relax": (CHECKED, (WrinkleFieldPointer, POINTER(WrinkleFieldSettings), WavesPointer,
        c_int32, c_bool, c_void_p, c_size_t)),
    "rumple_wrinkle_field_misfit": (CHECKED, (WrinkleFieldPointer, WavesPointer, c_void_p, c_size_t, c_void_p)),
    "rumple_wrinkle_field_evaluate": (CHECKED, (WrinkleFieldPointer, WavesPointer, POINTER(WrinkleFieldProfile),
        c_void_p, c_size_t, c_void_p, c_void_p, c_size_t, c_void_p, c_void_p)),
    "rumple_probe_formula": (CHECKED, (c_int32, c_void_p, c_size_t, c_void_p)),
}
