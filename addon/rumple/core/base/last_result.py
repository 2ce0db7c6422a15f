# SPDX-License-Identifier: GPL-3.0-or-later
"""The last result of a function, for settings that are the same from frame to frame. Never imports bpy."""
from __future__ import annotations

import copy
from typing import Any, Callable, Generic, TypeVar

import numpy as np

T = TypeVar("T")


class LastResult(Generic[T]):
    """Calls a function only if its arguments differ from those of the last call. Nobody may change the result."""

    def __init__(self, function: Callable[..., T]) -> None:
        self._function = function
        self._last: tuple[tuple[Any, ...], T] | None = None  # copies of the arguments, because a caller may change them

    def __call__(self, *arguments: Any) -> T:
        if self._last is None or not all(map(_is_same, arguments, self._last[0])):
            self._last = tuple(map(copy.copy, arguments)), self._function(*arguments)
        return self._last[1]


def _is_same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    return type(one) is type(other) and bool(one == other)
