# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes NumPy arrays to the library and back. An array with the right type and layout is never copied."""
from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from .struct import put

FLOAT, DOUBLE = np.dtype(np.float32), np.dtype(np.float64)
INT, BYTE = np.dtype(np.int32), np.dtype(np.uint8)
Shapes = dict[str, tuple[np.dtype, int]]  # by name: type of the array, and its columns or 0


def checked(array: Any, name: str, dtype: np.dtype, columns: int = 0) -> np.ndarray:
    """The array itself, if it is C-contiguous, of this dtype and of shape (n,) or (n, columns). Raises ValueError with
    the name of the argument, what was expected and what was given."""
    if (isinstance(array, np.ndarray) and array.dtype == dtype and array.flags.c_contiguous and array.flags.aligned
            and (array.ndim == 1 if columns == 0 else array.ndim == 2 and array.shape[1] == columns)):
        return array
    wanted = "(n,)" if columns == 0 else f"(n, {columns})"
    came = f"{array.dtype} {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
    if isinstance(array, np.ndarray) and not array.flags.c_contiguous:
        came += ", not contiguous"
    elif isinstance(array, np.ndarray) and not array.flags.aligned:
        came += ", not aligned"
    raise ValueError(f"{name}: expected a C-contiguous {dtype} array of shape {wanted}, got {came}")


def address(array: np.ndarray) -> int:
    """The address of its data. The array must live as long as the address is used."""
    return array.ctypes.data


def given(array: Any, name: str, dtype: np.dtype, columns: int = 0) -> tuple[int, int]:
    """Address and number of rows of an argument, which is checked. Keep a reference to the array during the call."""
    array = checked(array, name, dtype, columns)
    return array.ctypes.data, len(array)


def optional(array: Any, name: str, dtype: np.dtype, columns: int = 0) -> tuple[int | None, int]:
    """Like given(), for an argument that may be None."""
    return (None, 0) if array is None else given(array, name, dtype, columns)


def fill(struct: Any, name: str, array: Any, dtype: np.dtype, columns: int = 0) -> None:
    """Puts an array into the fields `name` and `name`_count of a struct. For None they stay empty."""
    if array is not None:
        place, count = given(array, name, dtype, columns)
        put(struct, name, place)
        put(struct, f"{name}_count", count)


def new(dtype: np.dtype, *shape: int) -> np.ndarray:
    """An array for the library to write."""
    return np.empty(shape, dtype)


# Types for memory of the library that keep a reference to its owner, one for each power of two bytes. NumPy needs a
# buffer at least as large as the array, and reads only the array. A type for each size would cost more than the array.
_MEMORY: list[Any] = [type("Memory", (ctypes.c_char * (1 << bits),), {"__slots__": ("owner",)}) for bits in range(48)]


def lent(owner: Any, place: int | None, dtype: np.dtype, shape: tuple[int, ...]) -> np.ndarray:
    """A read-only view of an array inside a handle. It keeps the handle alive."""
    count = shape[0] * (shape[1] if len(shape) > 1 else 1)
    if not place or not count:
        array = np.empty(shape, dtype)
    else:
        memory = _MEMORY[(count * dtype.itemsize - 1).bit_length()].from_address(place)
        memory.owner = owner
        array = np.ndarray(shape, dtype, memory)
    array.setflags(write=False)
    return array


def lent_all(owner: Any, view: Any, shapes: Shapes) -> dict[str, np.ndarray]:
    """lent() for several arrays of a view, by name. Their numbers of rows are in the fields `name`_count."""
    found = {}
    for name, (dtype, columns) in shapes.items():
        rows = getattr(view, f"{name}_count")
        found[name] = lent(owner, getattr(view, name), dtype, (rows, columns) if columns else (rows,))
    return found
