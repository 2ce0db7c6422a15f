# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps: L. Dutreve, A. Meyer and S. Bouakaz, Real-Time Dynamic Wrinkles of Face for Animated Skinned
Mesh, ISVC 2009. The current pose of a skeleton is compared, bone by bone, with reference poses. Each
reference pose has a normal map. The skin weights determine where each map is visible. docs/wrinkle_maps.md
has the mathematics.

Written by scripts/declarations.py from native/include/rumple/wrinkle_maps.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .base import *

MOST_POSES = 16
TRACKED = {"HEAD": 0, "TAIL": 1, "BOTH": 2, "KEY": 3}
MAPS_KIND = {"WHOLE": 0, "WRINKLES": 1}
WrinkleMapsPointer = pointer_to("rumple_wrinkle_maps")


class WrinkleMapsPose(Struct):
    """struct rumple_wrinkle_maps_pose"""

    __slots__ = ()
    name: bytes | None  # UTF-8, for messages
    bones: int | None  # (b, 6), root space, finite
    bones_count: int
    _fields_ = (("name", c_char_p), ("bones", c_void_p), ("bones_count", c_size_t),)


class WrinkleMapsPlan(Struct):
    """struct rumple_wrinkle_maps_plan"""

    __slots__ = ()
    names: int | None  # (b), UTF-8, for messages
    names_count: int
    tracked: int | None  # (b), rumple_tracked
    tracked_count: int
    group: int | None  # (b): bones of the same group share their influences; -1: in no group
    group_count: int
    neutral: int | None  # (b, 6): P_0, root space, finite
    neutral_count: int
    poses: Any  # (o), at most RUMPLE_MOST_POSES
    poses_count: int
    weight_start: int | None  # (n + 1): the first weight of every vertex, then their number
    weight_start_count: int
    weight_bone: int | None  # (weights); -1: a bone that is not listed
    weight_bone_count: int
    weight: int | None  # (weights), >= 0; bones: normalised to a sum of 1 per vertex; shape keys: 0..1
    weight_count: int
    _fields_ = (("names", c_void_p), ("names_count", c_size_t), ("tracked", c_void_p), ("tracked_count", c_size_t),
        ("group", c_void_p), ("group_count", c_size_t), ("neutral", c_void_p), ("neutral_count", c_size_t),
        ("poses", POINTER(WrinkleMapsPose)), ("poses_count", c_size_t), ("weight_start", c_void_p),
        ("weight_start_count", c_size_t), ("weight_bone", c_void_p), ("weight_bone_count", c_size_t),
        ("weight", c_void_p), ("weight_count", c_size_t),)


class WrinkleMapsView(Struct):
    """struct rumple_wrinkle_maps_view"""

    __slots__ = ()
    vertex_count: int  # n
    pose_count: int  # o
    bone_count: int  # b
    weight_count: int
    unnormalised: int  # vertices whose weights did not sum to 1
    unbound: int  # vertices without any weight: their masks are 0
    moves: int | None  # (b, o): 1 if the bone moves in the pose
    reach: int | None  # (n, o): sum of the weights of bones that move in a pose; > 1 only with shape keys
    weight_start: int | None  # (n + 1): the weights that are used: of listed bones only
    weight_bone: int | None  # (weight_count)
    weight: int | None  # (weight_count)
    _fields_ = (("vertex_count", c_int32), ("pose_count", c_int32), ("bone_count", c_int32),
        ("weight_count", c_int32), ("unnormalised", c_int32), ("unbound", c_int32), ("moves", c_void_p),
        ("reach", c_void_p), ("weight_start", c_void_p), ("weight_bone", c_void_p), ("weight", c_void_p),)


class WrinkleMapsSettings(Struct):
    """struct rumple_wrinkle_maps_settings"""

    __slots__ = ()
    gain: float  # gain of masks where bones move the skin only partly, 0.1..100
    strength: int | None  # (o), 0..1: 0 mutes a pose; or none: 1 for all
    strength_count: int
    _fields_ = (("gain", c_float), ("strength", c_void_p), ("strength_count", c_size_t),)


WRINKLE_MAPS_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_wrinkle_maps_build": (CHECKED, (POINTER(WrinkleMapsPlan), POINTER(WrinkleMapsPointer))),
    "rumple_wrinkle_maps_free": (None, (WrinkleMapsPointer,)),
    "rumple_wrinkle_maps_get_view": (CHECKED, (WrinkleMapsPointer, POINTER(WrinkleMapsView))),
    "rumple_bones_in_root_space": (CHECKED, (c_void_p, c_void_p, c_size_t, c_void_p, c_size_t)),
    "rumple_wrinkle_maps_evaluate": (CHECKED, (WrinkleMapsPointer, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p,
        c_size_t)),
    "rumple_wrinkle_maps_presence": (CHECKED, (WrinkleMapsPointer, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p,
        c_size_t)),
    "rumple_wrinkle_maps_settings_default": (WrinkleMapsSettings, ()),
    "rumple_wrinkle_maps_masks": (CHECKED, (WrinkleMapsPointer, POINTER(WrinkleMapsSettings), c_void_p, c_size_t,
        c_void_p, c_size_t, c_void_p, c_size_t)),
    "rumple_wrinkle_maps_blend": (CHECKED, (c_int32, c_void_p, c_size_t, c_void_p, c_void_p, c_size_t, c_void_p,
        c_size_t)),
}
