# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of the library as Python objects: freed with the last reference, their arrays as views."""
from __future__ import annotations

import ctypes
from typing import Any, TypeVar

import numpy as np

from .arrays import lent
from .library import lib

T = TypeVar("T", bound="Handle")


class Handle:
    """What a handle is. A class of one says POINTER, its type; FREE, the function that gives it back; VIEW and LOOK,
    the struct of its view and the function that fills it, where it has one."""

    __slots__ = ("_as_parameter_", "_free", "_seen", "__weakref__")
    POINTER: Any = None
    FREE = ""
    VIEW: Any = None
    LOOK = ""
    _as_parameter_: Any  # a pointer to an opaque struct, of a type of its own for each kind of handle
    _free: Any
    _seen: Any

    @classmethod
    def made(cls: type[T], function: Any, *arguments: Any) -> T:
        """Of a function whose last argument is where the handle goes."""
        return cls._filled(cls.__new__(cls), function, *arguments)

    @classmethod
    def _filled(cls, self: T, function: Any, *arguments: Any) -> T:
        pointer = cls.POINTER()
        function(*arguments, ctypes.byref(pointer))
        return cls._own(self, pointer)

    @classmethod
    def owning(cls: type[T], pointer: Any) -> T:
        """Of a pointer that a function gave beside its own handle. It is freed with this."""
        return cls._own(cls.__new__(cls), pointer)

    @classmethod
    def _own(cls, self: T, pointer: Any) -> T:
        self._as_parameter_, self._free, self._seen = pointer, getattr(lib, cls.FREE), None
        return self

    @property
    def view(self) -> Any:
        """The struct of the view: numbers and addresses. Asked for once: what a handle holds does not change."""
        if self._seen is None:
            view = self.VIEW()
            getattr(lib, self.LOOK)(self, view)
            self._seen = view
        return self._seen

    def __reduce__(self) -> Any:
        raise TypeError(f"a {type(self).__name__} cannot be copied or stored: it would be freed twice")

    def __del__(self) -> None:
        if hasattr(self, "_free"):  # where its making was refused there is nothing to free
            self._free(self._as_parameter_)


class Array:
    """An array inside a handle: a read-only view, valid as long as anyone holds it.

    rows: the name of a number of the view; more: what is added to it. columns: numbers, or such a name; none: (rows,).
    source: where the view has it, if under another name. view: the property that is the view.
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
