# SPDX-License-Identifier: GPL-3.0-or-later
"""The native library in Python: ctypes and NumPy, nothing else.

load() opens the library and returns the module `kernels`, which has everything that there is. c/ is the C header,
written by scripts/declarations.py; struct, library, arrays and handle say how Python deals with it; the other files
are the systems. What they do, in which units, is said in native/include/rumple.h.
"""
from __future__ import annotations

from types import ModuleType

from .library import NativeMissing, lib

__all__ = ["NativeMissing", "load"]


def load() -> ModuleType:
    """The module with everything. Raises NativeMissing."""
    lib.open()
    from . import kernels
    return kernels
