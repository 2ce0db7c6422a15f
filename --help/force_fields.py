# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's force fields, evaluated at points of the world as in its effect.c. They are input of
rumple_base_cloth_swing, for cloth with inertia. docs/base_cloth.md has the formulas.

Written by scripts/declarations.py from native/include/rumple/force_fields.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .base import *

FORCE_FIELD_KIND = {"WIND": 0, "FORCE": 1, "VORTEX": 2, "HARMONIC": 3, "DRAG": 4, "TURBULENCE": 5}
FORCE_FIELD_SHAPE = {"POINT": 0, "LINE": 1, "PLANE": 2}
FORCE_FIELD_FALLOFF = {"SPHERE": 0, "TUBE": 1, "CONE": 2}
FORCE_FIELD_SIDE = {"BOTH": 0, "ABOVE": 1, "BELOW": 2}


class ForceField(Struct):
    """struct rumple_force_field"""

    __slots__ = ()
    kind: int  # rumple_force_field_kind
    shape: int  # rumple_force_field_shape
    falloff: int  # rumple_force_field_falloff
    side: int  # rumple_force_field_side: of the plane across the axis; it acts on this side
    location: Array
    axis: Array  # Z axis of the object, any length; 0: no direction
    strength: float  # wind: velocity; drag: coefficient of quadratic drag; others: force
    damping: float  # harmonic: damping ratio; drag: coefficient of linear drag; >= 0
    size: float  # turbulence: size of the noise; harmonic: rest length; >= 0
    flow: float  # damping of the velocity; not used by wind, harmonic, drag
    noise: float  # random variation of the strength between points and frames, >= 0
    seed: int  # seed of this noise
    power: float  # of the falloff (1 + distance - least)^-power, 0..1000
    least: float  # up to this distance there is no falloff, >= 0
    most: float  # if `ends`: beyond this distance the field is 0, >= 0
    ends: bool  # whether `most` is used
    radial_power: float  # the same; tube: by distance from the axis, cone: by the angle to the axis,
    radial_least: float  # ... degrees; sphere: without effect
    radial_most: float
    radial_ends: bool
    inverse_square: bool  # force: strength is divided by the squared distance
    in_world: bool  # turbulence: the noise does not move with the location
    _fields_ = (("kind", c_int32), ("shape", c_int32), ("falloff", c_int32), ("side", c_int32),
        ("location", c_float * 3), ("axis", c_float * 3), ("strength", c_float), ("damping", c_float),
        ("size", c_float), ("flow", c_float), ("noise", c_float), ("seed", c_int32), ("power", c_float),
        ("least", c_float), ("most", c_float), ("ends", c_bool), ("radial_power", c_float), ("radial_least", c_float),
        ("radial_most", c_float), ("radial_ends", c_bool), ("inverse_square", c_bool), ("in_world", c_bool),)


FORCE_FIELDS_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_force_field_default": (ForceField, ()),
    "rumple_force_fields_evaluate": (CHECKED, (POINTER(ForceField), c_size_t, c_int32, c_void_p, c_size_t, c_void_p,
        c_size_t, c_void_p, c_size_t, c_void_p, c_size_t)),
}
