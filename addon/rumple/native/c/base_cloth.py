# SPDX-License-Identifier: GPL-3.0-or-later
"""The base cloth: the coarse mesh itself becomes cloth around its animation, so that it hangs, pulls taut and
rests on bodies. Mueller and Chentanez 2010, section 4.3; docs/base_cloth.md has the energy.

Written by scripts/declarations.py from native/include/rumple/base_cloth.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .surface import *

ColliderPointer = pointer_to("rumple_collider")
BaseClothPointer = pointer_to("rumple_base_cloth")
BaseClothPaintPointer = pointer_to("rumple_base_cloth_paint")
BaseClothStatePointer = pointer_to("rumple_base_cloth_state")
ClothCoverPointer = pointer_to("rumple_cloth_cover")


class Bodies(Struct):
    """struct rumple_bodies"""

    __slots__ = ()
    collider: Any  # or NULL
    positions: int | None  # (b, 3), object space of the cloth, finite
    positions_count: int
    _fields_ = (("collider", ColliderPointer), ("positions", c_void_p), ("positions_count", c_size_t),)


class BaseClothSettings(Struct):
    """struct rumple_base_cloth_settings"""

    __slots__ = ()
    stretch: float  # stiffness of edges that are longer than at rest, > 0
    strain_limit: float  # strain beyond which stretch is ten times as stiff, >= 0
    shear: float  # stiffness of quad diagonals that are longer than at rest, >= 0
    compression: float  # k1: stiffness of edges shorter than at rest, >= 0
    compression_limit: float  # c_l: length / rest length below which k2 applies, 0..1
    folded: float  # k2: stiffness of edges shorter than c_l, >= 0
    smoothing: float  # resistance of edges against turning from their animated direction, >= 0
    tube_radius: float  # around a tube of radius R these three are scaled by (tube_radius / R)^4; > 0
    flat_share: float  # the least such scale, for directions along tubes and flat cloth, 0..1
    hem_share: float  # factor on smoothing at a hem that nothing holds, 0..1
    slack: float  # length of the cloth / length of the modelled garment, > 0
    hang: Array  # object space, length 0..1: in this direction there is no slack
    follow: float  # pull towards the animation where nothing is pinned, 1/s^2, > 0
    room: float  # largest distance of a vertex from its animated place, object units, >= 0
    slide_room: float  # the same along the surface, if larger than room; object units, >= 0
    friction: float  # coefficient of Coulomb friction on the bodies under the cloth, >= 0
    gravity: Array  # object space, object units / s^2, finite
    thickness: float  # how far cloth stays off bodies, object units, >= 0
    unknown: float  # how far cloth may move inwards where no body is found, object units, >= 0
    reach: float  # bodies farther away are ignored, object units, > 0
    depth: float  # cloth deeper inside a body is not pushed out, object units, > 0
    spread: float  # length over which clearance fades from bodies to `unknown`, object units, > 0
    steps: int  # largest number of Newton steps from a given state, >= 0
    start_steps: int  # Newton steps from the animation, >= 0
    most_cg_iterations: int  # of conjugate gradients (CG) in a Newton step, >= 0
    _fields_ = (("stretch", c_float), ("strain_limit", c_float), ("shear", c_float), ("compression", c_float),
        ("compression_limit", c_float), ("folded", c_float), ("smoothing", c_float), ("tube_radius", c_float),
        ("flat_share", c_float), ("hem_share", c_float), ("slack", c_float), ("hang", c_float * 3),
        ("follow", c_float), ("room", c_float), ("slide_room", c_float), ("friction", c_float),
        ("gravity", c_float * 3), ("thickness", c_float), ("unknown", c_float), ("reach", c_float),
        ("depth", c_float), ("spread", c_float), ("steps", c_int32), ("start_steps", c_int32),
        ("most_cg_iterations", c_int32),)


class BaseClothSwing(Struct):
    """struct rumple_base_cloth_swing"""

    __slots__ = ()
    seconds: float  # time since the frame before, >= 0
    longest_step: float  # longest time step, s, > 0: the same value gives the same motion at any frame rate
    newton_steps: int  # for every time step, >= 1
    damping: float  # damping of the velocity relative to the animated one, 1/s, >= 0
    locomotion: float  # share of the garment's overall motion that causes inertia, 0..1
    drag: float  # density of the air x coefficient / (2 mass per area), 1/object unit, >= 0
    wind: Array  # velocity of the air, object space, object units / s
    matrix: Array  # (3, 3): from the object space of the frame before to this one's ...
    shift: Array  # ... and the translation after it, object units
    air: int | None  # (n, 3): velocity of the air in addition to `wind`, object units / s
    air_count: int
    push: int | None  # (n, 3): acceleration in addition to gravity, object units / s^2
    push_count: int
    resist: int | None  # (n, 2): linear drag on the velocity, 1/s, and quadratic drag, 1/object
    resist_count: int  # unit; >= 0
    _fields_ = (("seconds", c_float), ("longest_step", c_float), ("newton_steps", c_int32), ("damping", c_float),
        ("locomotion", c_float), ("drag", c_float), ("wind", c_float * 3), ("matrix", c_float * 9),
        ("shift", c_float * 3), ("air", c_void_p), ("air_count", c_size_t), ("push", c_void_p),
        ("push_count", c_size_t), ("resist", c_void_p), ("resist_count", c_size_t),)


class BaseClothPainted(Struct):
    """struct rumple_base_cloth_painted"""

    __slots__ = ()
    follow: int | None  # 0..1; 1: pinned to the animation; none: 0 for all
    follow_count: int
    room: int | None  # 0..1000: factor on `room`, and, limited to 1, on `slide_room`; none: 1 for all
    room_count: int
    _fields_ = (("follow", c_void_p), ("follow_count", c_size_t), ("room", c_void_p), ("room_count", c_size_t),)


class BaseClothStateView(Struct):
    """struct rumple_base_cloth_state_view"""

    __slots__ = ()
    vertex_count: int  # n
    welded_vertex_count: int  # w
    body_hint_count: int  # n; 0 without bodies
    velocity_count: int  # w; 0 without inertia
    offset_count: int  # w; 0 with inertia
    clearance_count: int
    bytes: int  # memory of the values for the next frame
    positions: int | None  # (n, 3): the cloth, object space
    gap: int | None  # (n): height above the body, object units, >= 0
    body_hint: int | None  # (body_hint_count): a triangle of the collider near each vertex, or -1
    velocity: int | None  # (velocity_count, 3), object units / s
    offset: int | None  # (offset_count, 3): in the tangent frame of the animated vertex
    clearance: int | None  # (clearance_count): how far each may move inwards, object units
    _fields_ = (("vertex_count", c_int32), ("welded_vertex_count", c_int32), ("body_hint_count", c_int32),
        ("velocity_count", c_int32), ("offset_count", c_int32), ("clearance_count", c_int32), ("bytes", c_size_t),
        ("positions", c_void_p), ("gap", c_void_p), ("body_hint", c_void_p), ("velocity", c_void_p),
        ("offset", c_void_p), ("clearance", c_void_p),)


class BaseClothKept(Struct):
    """struct rumple_base_cloth_kept"""

    __slots__ = ()
    offset: int | None  # (w, 3), or none with inertia
    offset_count: int
    length: int | None  # (springs): in the solved pose, as the next two
    length_count: int
    clearance: int | None  # (w)
    clearance_count: int
    ahead_height: int | None  # (w)
    ahead_height_count: int
    body_hint: int | None  # (w) or none: a triangle of the collider near each vertex, or -1
    body_hint_count: int
    contact_hint: int | None  # (w): a triangle of the cloth near each vertex, or -1
    contact_hint_count: int
    position: int | None  # (w, 3), object units; this and all below only with inertia
    position_count: int
    velocity: int | None  # (w, 3), object units / s
    velocity_count: int
    animated: int | None  # (w, 3)
    animated_count: int
    animated_before: int | None  # (w, 3)
    animated_before_count: int
    moved: float  # largest movement of a vertex in the last full step, object units, >= 0
    seconds: float  # between the two poses, >= 0
    fastest: float  # largest speed in the frame, object units / s, >= 0
    gravity: Array  # in this frame, object space, object units / s^2; without inertia in the frame of the rest shape
    wind: Array  # in this frame, object space, object units / s
    air: int | None  # (w, 3), object units / s, or none
    air_count: int
    push: int | None  # (w, 3), object units / s^2, or none
    push_count: int
    _fields_ = (("offset", c_void_p), ("offset_count", c_size_t), ("length", c_void_p), ("length_count", c_size_t),
        ("clearance", c_void_p), ("clearance_count", c_size_t), ("ahead_height", c_void_p),
        ("ahead_height_count", c_size_t), ("body_hint", c_void_p), ("body_hint_count", c_size_t),
        ("contact_hint", c_void_p), ("contact_hint_count", c_size_t), ("position", c_void_p),
        ("position_count", c_size_t), ("velocity", c_void_p), ("velocity_count", c_size_t), ("animated", c_void_p),
        ("animated_count", c_size_t), ("animated_before", c_void_p), ("animated_before_count", c_size_t),
        ("moved", c_float), ("seconds", c_float), ("fastest", c_float), ("gravity", c_float * 3),
        ("wind", c_float * 3), ("air", c_void_p), ("air_count", c_size_t), ("push", c_void_p),
        ("push_count", c_size_t),)


class BaseClothReport(Struct):
    """struct rumple_base_cloth_report"""

    __slots__ = ()
    steps: int  # 0: the cloth was asleep, nothing was solved
    cg_iterations: int  # of all steps
    moved: float  # largest movement of a vertex in the last full step, object units
    offset_mean: float  # from the animation, object units
    offset_max: float
    taut: float  # share of the springs that are longer than at rest
    touching: float  # share of the vertices that rest on the inner surface
    body_known: float  # share of the vertices that have a body under them
    _fields_ = (("steps", c_int32), ("cg_iterations", c_int32), ("moved", c_float), ("offset_mean", c_float),
        ("offset_max", c_float), ("taut", c_float), ("touching", c_float), ("body_known", c_float),)


class ClothCoverSettings(Struct):
    """struct rumple_cloth_cover_settings"""

    __slots__ = ()
    thickness: float  # how far the smooth surface stays off bodies, object units, >= 0
    depth: float  # cloth deeper inside a body is not pushed out, object units, > 0
    _fields_ = (("thickness", c_float), ("depth", c_float),)


BASE_CLOTH_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_collider_build": (CHECKED, (c_void_p, c_size_t, c_void_p, c_size_t, c_void_p, c_size_t, c_float,
        POINTER(ColliderPointer))),
    "rumple_collider_free": (None, (ColliderPointer,)),
    "rumple_collider_vertex_count": (c_int32, (ColliderPointer,)),
    "rumple_base_cloth_build": (CHECKED, (SurfacePointer, POINTER(BaseClothPointer))),
    "rumple_base_cloth_free": (None, (BaseClothPointer,)),
    "rumple_base_cloth_settings_default": (BaseClothSettings, ()),
    "rumple_base_cloth_swing_default": (BaseClothSwing, ()),
    "rumple_base_cloth_paint_build": (CHECKED, (BaseClothPointer, POINTER(BaseClothPainted),
        POINTER(BaseClothPaintPointer))),
    "rumple_base_cloth_paint_free": (None, (BaseClothPaintPointer,)),
    "rumple_base_cloth_state_free": (None, (BaseClothStatePointer,)),
    "rumple_base_cloth_state_get_view": (CHECKED, (BaseClothStatePointer, POINTER(BaseClothStateView))),
    "rumple_base_cloth_state_get_kept": (CHECKED, (BaseClothStatePointer, POINTER(BaseClothKept))),
    "rumple_base_cloth_state_build": (CHECKED, (BaseClothPointer, POINTER(BaseClothKept),
        POINTER(BaseClothStatePointer))),
    "rumple_base_cloth_state_activated": (CHECKED, (BaseClothStatePointer, POINTER(BaseClothStatePointer))),
    "rumple_base_cloth_solve": (CHECKED, (BaseClothPointer, POINTER(BaseClothSettings), BaseClothPaintPointer,
        c_void_p, c_size_t, POINTER(Bodies), BaseClothStatePointer, POINTER(BaseClothReport),
        POINTER(BaseClothStatePointer))),
    "rumple_base_cloth_swing_solve": (CHECKED, (BaseClothPointer, POINTER(BaseClothSettings), POINTER(BaseClothSwing),
        BaseClothPaintPointer, c_void_p, c_size_t, POINTER(Bodies), BaseClothStatePointer, POINTER(BaseClothReport),
        POINTER(BaseClothStatePointer))),
    "rumple_cloth_cover_build": (CHECKED, (SurfacePointer, POINTER(ClothCoverPointer))),
    "rumple_cloth_cover_free": (None, (ClothCoverPointer,)),
    "rumple_cloth_cover_settings_default": (ClothCoverSettings, ()),
    "rumple_cloth_cover_lift": (CHECKED, (ClothCoverPointer, POINTER(ClothCoverSettings), POINTER(Bodies), c_void_p,
        c_size_t, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p, c_size_t)),
    "rumple_cloth_untangle": (CHECKED, (SurfacePointer, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p, c_size_t)),
}
