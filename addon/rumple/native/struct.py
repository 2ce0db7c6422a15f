# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes and fields for the structs of the C header, so that they can be used as settings in Python."""
from __future__ import annotations

import ctypes
from typing import Any, Mapping, Sequence

put = ctypes.Structure.__setattr__  # sets a field without a check, in a third of the time, if the value is known to fit
CHECKED = object()  # result type of functions that return a status, which library.py turns into exceptions


class Struct(ctypes.Structure):
    """A plain struct of the header. Unlike ctypes, it refuses unknown fields and numbers out of range."""

    __slots__ = ()

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, value)
        if type(value) is int:
            kept = getattr(self, name)
            if type(kept) is int and kept != value:
                super().__setattr__(name, 0)
                raise ValueError(f"{name}: {value} is out of range")

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={getattr(self, name)!r}" for name, *_ in self._fields_)
        return f"{type(self).__name__}({fields})"


def pointer_to(name: str) -> Any:
    """A new pointer type for an opaque struct, so that kinds of handles cannot be confused."""
    return ctypes.POINTER(type(name, (ctypes.Structure,), {}))


class Within:
    """Makes a field of an inner struct available as a field of the outer struct."""

    def __init__(self, outer: str, doc: str) -> None:
        self.outer, self.__doc__ = outer, doc

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, settings: Any, owner: type | None = None) -> Any:
        return self if settings is None else getattr(getattr(settings, self.outer), self.name)

    def __set__(self, settings: Any, value: Any) -> None:
        setattr(getattr(settings, self.outer), self.name, value)


class Choice:
    """A numeric field whose values have names in Python. outer: name of the inner struct that has the field; empty: the
    struct itself."""

    def __init__(self, numbers: Mapping[str, int], doc: str = "", outer: str = "") -> None:
        self.numbers, self.outer = numbers, outer
        self.names = {number: name for name, number in numbers.items()}
        self.__doc__ = f"{', '.join(numbers)}{': ' * bool(doc)}{doc}"

    def __set_name__(self, owner: type, name: str) -> None:
        self.name, self.base = name, owner.__base__

    def __get__(self, settings: Any, owner: type | None = None) -> Any:
        if settings is None:
            return self
        if self.outer:
            return self.names[getattr(getattr(settings, self.outer), self.name)]
        return self.names[getattr(self.base, self.name).__get__(settings)]

    def __set__(self, settings: Any, name: str) -> None:
        number = chosen(name, self.name, self.numbers)
        if self.outer:
            setattr(getattr(settings, self.outer), self.name, number)
        else:
            getattr(self.base, self.name).__set__(settings, number)


class Vector:
    """A field with three floats, as a tuple."""

    def __init__(self, doc: str) -> None:
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self.name, self.base = name, owner.__base__

    def __get__(self, settings: Any, owner: type | None = None) -> Any:
        return self if settings is None else tuple(getattr(self.base, self.name).__get__(settings))

    def __set__(self, settings: Any, value: Sequence[float]) -> None:
        if len(value) != 3:
            raise ValueError(f"{self.name}: expected three floats, got {len(value)}")
        getattr(self.base, self.name).__set__(settings, tuple(map(float, value)))


def chosen(name: str, argument: str, numbers: Mapping[str, int]) -> int:
    """The number of a choice. Raises ValueError with the name of the argument and the possible names."""
    try:
        return numbers[name]
    except (KeyError, TypeError):
        raise ValueError(f"{argument}: expected one of {', '.join(numbers)}, got {name}") from None
