# SPDX-License-Identifier: GPL-3.0-or-later
"""The brush of the Wrinkle Field: painting wrinkles of the rest pose, and random wrinkles (Loviscach 2006,
section 7). A painted value p is a tangent vector of the rest pose, along the compression (across the
folds), shorter than 1. p and -p mean the same. Arrays of painted values are (n, 3), for the base's
vertices.

Written by scripts/declarations.py from native/include/rumple/wrinkle_field_brush.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to
from .wrinkle_field import *

LONGEST_PAINTED = 0.99
TOUCH = {"PAINT": 0, "ERASE": 1, "SMOOTH": 2}
FALLOFF = {"SMOOTH": 0, "SHARP": 1, "LINEAR": 2, "CONSTANT": 3}
CanvasPointer = pointer_to("rumple_canvas")
TwinsPointer = pointer_to("rumple_twins")
LinesPointer = pointer_to("rumple_lines")


class Dab(Struct):
    """struct rumple_dab"""

    __slots__ = ()
    touch: int  # rumple_touch
    centre: Array  # on the surface
    normal: Array  # at the centre: only vertices whose same side faces the viewer are changed
    view: Array  # from the viewer to the centre
    direction: Array  # of the stroke, parallel to the screen; RUMPLE_TOUCH_PAINT only
    across: bool  # false: the folds run along the stroke; true: at right angles to it
    radius: float  # > 0
    strength: float  # blend factor at the centre, 0..1
    length: float  # length of the painted vectors, 0..RUMPLE_LONGEST_PAINTED
    falloff: int  # rumple_falloff
    _fields_ = (("touch", c_int32), ("centre", c_float * 3), ("normal", c_float * 3), ("view", c_float * 3),
        ("direction", c_float * 3), ("across", c_bool), ("radius", c_float), ("strength", c_float),
        ("length", c_float), ("falloff", c_int32),)


class Scatter(Struct):
    """struct rumple_scatter"""

    __slots__ = ()
    seed: int
    density: float  # share of the vertices with wrinkles, 0..1
    size: float  # distance over which direction and strength change, object units, > 0
    length: float  # length of the longest vectors, 0..RUMPLE_LONGEST_PAINTED
    _fields_ = (("seed", c_uint32), ("density", c_float), ("size", c_float), ("length", c_float),)


class LinesView(Struct):
    """struct rumple_lines_view"""

    __slots__ = ()
    line_count: int  # m
    ends: int | None  # (2 m, 3): both ends of every line, space of the canvas
    strength: int | None  # (m): |p|
    _fields_ = (("line_count", c_int32), ("ends", c_void_p), ("strength", c_void_p),)


WRINKLE_FIELD_BRUSH_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_canvas_build": (CHECKED, (WrinkleFieldPointer, c_void_p, c_size_t, POINTER(CanvasPointer))),
    "rumple_canvas_free": (None, (CanvasPointer,)),
    "rumple_twins_build": (CHECKED, (WrinkleFieldPointer, c_void_p, POINTER(TwinsPointer))),
    "rumple_twins_free": (None, (TwinsPointer,)),
    "rumple_dab_default": (Dab, ()),
    "rumple_dab_apply": (CHECKED, (CanvasPointer, POINTER(Dab), TwinsPointer, c_void_p, c_size_t)),
    "rumple_scatter_default": (Scatter, ()),
    "rumple_scatter_paint": (CHECKED, (WrinkleFieldPointer, POINTER(Scatter), c_void_p, c_size_t)),
    "rumple_lines_free": (None, (LinesPointer,)),
    "rumple_lines_get_view": (CHECKED, (LinesPointer, POINTER(LinesView))),
    "rumple_canvas_draw": (CHECKED, (CanvasPointer, c_void_p, c_size_t, c_bool, POINTER(LinesPointer))),
}
