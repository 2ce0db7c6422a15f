# SPDX-License-Identifier: GPL-3.0-or-later
"""Python bindings of the native library. They need only ctypes and NumPy.

load() opens the library and returns the module `kernels`, which has all functions and classes. c/ has the declarations
of the C header, written by scripts/declarations.py. struct, library, arrays and handle connect them to Python. The
other files are the systems. The reference, with all units, is native/include/rumple.h.
"""
from __future__ import annotations

from types import ModuleType

from .library import NativeMissing, lib

__all__ = ["NativeMissing", "load"]


def load() -> ModuleType:
    """The module `kernels`. Raises NativeMissing."""
    lib.open()
    from . import kernels
    return kernels
