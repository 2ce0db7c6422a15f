# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of the library as Python objects. The last reference frees a handle. Its arrays are views."""
from __future__ import annotations

import ctypes
from typing import Any, TypeVar

import numpy as np

from .arrays import lent
from .library import lib

T = TypeVar("T", bound="Handle")


class Handle:
    """Base class of all handles. A subclass defines POINTER, the type of the handle; FREE, the function that frees it;
    and, if it has a view, VIEW, the struct, and LOOK, the function that fills it."""

    __slots__ = ("_as_parameter_", "_free", "_seen", "__weakref__")
    POINTER: Any = None
    FREE = ""
    VIEW: Any = None
    LOOK = ""
    _as_parameter_: Any  # a pointer to an opaque struct; each kind of handle has its own type
    _free: Any
    _seen: Any

    @classmethod
    def made(cls: type[T], function: Any, *arguments: Any) -> T:
        """A handle from a function that stores it in its last argument."""
        return cls._filled(cls.__new__(cls), function, *arguments)

    @classmethod
    def _filled(cls, self: T, function: Any, *arguments: Any) -> T:
        pointer = cls.POINTER()
        function(*arguments, ctypes.byref(pointer))
        return cls._own(self, pointer)

    @classmethod
    def owning(cls: type[T], pointer: Any) -> T:
        """A handle from a pointer that a function returned in addition to its own handle. This object frees it."""
        return cls._own(cls.__new__(cls), pointer)

    @classmethod
    def _own(cls, self: T, pointer: Any) -> T:
        self._as_parameter_, self._free, self._seen = pointer, getattr(lib, cls.FREE), None
        return self

    @property
    def view(self) -> Any:
        """The struct of the view: numbers and addresses. It is read once, because the contents of a handle never
        change."""
        if self._seen is None:
            view = self.VIEW()
            getattr(lib, self.LOOK)(self, view)
            self._seen = view
        return self._seen

    def __reduce__(self) -> Any:
        raise TypeError(f"a {type(self).__name__} cannot be copied or stored: it would be freed twice")

    def __del__(self) -> None:
        if hasattr(self, "_free"):  # not set if making the handle failed
            self._free(self._as_parameter_)


class Array:
    """An array inside a handle: a read-only view, valid as long as anyone has a reference to it.

    rows: name of the number in the view that has the rows; more: is added to it. columns: a number, or such a name; 0:
    the shape is (rows,). source: name of the array in the view, if it differs. view: name of the property with the
    view.
    """

    def __init__(self, doc: str, dtype: np.dtype, rows: str, columns: int | str = 0, *, source: str = "", more: int = 0,
                 view: str = "view") -> None:
        self.__doc__, self.dtype, self.rows, self.columns = doc, dtype, rows, columns
        self.source, self.more, self.of = source, more, view

    def __set_name__(self, owner: type, name: str) -> None:
        self.source = self.source or name

    def __get__(self, handle: Any, owner: type | None = None) -> Any:
        if handle is None:
            return self
        view, columns = getattr(handle, self.of), self.columns
        rows = getattr(view, self.rows) + self.more
        if isinstance(columns, str):
            columns = getattr(view, columns)
        return lent(handle, getattr(view, self.source), self.dtype, (rows, columns) if columns else (rows,))


class Number:
    """A number inside a handle."""

    def __init__(self, doc: str, source: str = "") -> None:
        self.__doc__, self.source = doc, source

    def __set_name__(self, owner: type, name: str) -> None:
        self.source = self.source or name

    def __get__(self, handle: Any, owner: type | None = None) -> Any:
        return self if handle is None else getattr(handle.view, self.source)
