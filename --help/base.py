# SPDX-License-Identifier: GPL-3.0-or-later
"""The basics of the library: export macro, status codes, error messages, versions, stopping. See rumple.h.

Written by scripts/declarations.py from native/include/rumple/base.h: change that.
"""
from __future__ import annotations

from ctypes import (POINTER, Array, c_bool, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint8,
                    c_uint32, c_void_p)
from typing import Any

from ..struct import CHECKED, Struct, pointer_to

VERSION = "0.1.0"
STATUS = {"OK": 0, "INVALID": 1, "NO_MEMORY": 2, "INTERNAL": 3, "STOPPED": 4}
StopPointer = pointer_to("rumple_stop")


BASE_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "rumple_version": (c_char_p, ()),
    "rumple_struct_size": (c_size_t, (c_char_p,)),
    "rumple_error": (c_char_p, ()),
    "rumple_stop_build": (CHECKED, (POINTER(StopPointer),)),
    "rumple_stop_free": (None, (StopPointer,)),
    "rumple_stop_watch": (None, (StopPointer,)),
    "rumple_stop_ask": (None, (StopPointer,)),
}
