# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds librumple and opens it, or explains to the artist why this is not possible.

An installed library is in lib/ of this package's parent, in a folder for each platform. A built library is in the
folder $RUMPLE_NATIVE. The same file works with every version of Python, because it does not use Python.
"""
from __future__ import annotations

import ctypes
import os
from pathlib import Path
from typing import Any

from . import c, platforms
from .struct import CHECKED

BUNDLED = Path(__file__).parent.parent / "lib"


class NativeMissing(RuntimeError):
    """There is no usable native library. The text is meant for the artist."""


def library_file() -> Path:
    """Where the library is. Raises NativeMissing."""
    here = platforms.here()
    chosen = os.environ.get("RUMPLE_NATIVE")
    for folder in ([Path(chosen)] if chosen else []) + [BUNDLED / here]:
        if (folder / platforms.file_name(here)).is_file():
            # An absolute path, because a bare name would be searched for in the system. Not resolve(), which fails on
            # some drives of Windows.
            return Path(os.path.abspath(folder / platforms.file_name(here)))
    others = sorted(folder.name for folder in BUNDLED.glob("*-*") if folder.is_dir())
    made_for = f"it is the package for {', '.join(others)}" if others else "it has no library"
    advice = f"Install the Rumple package for {here}." if here in platforms.MADE_FOR else "There is no Rumple for it."
    raise NativeMissing(f"This installation of Rumple cannot run on {here}: {made_for}. {advice}")


class Stopped(RuntimeError):
    """Raised by a call that another thread stopped: see stopping.py."""


class Library:
    """The functions of the library, by their names in the header. The first call opens the library."""

    path: Path | None = None

    def open(self) -> None:
        """Opens the library and compares its version and structs with these bindings. Raises NativeMissing."""
        if self.path is not None:
            return
        path = library_file()
        try:
            if platforms.is_damaged(path):
                raise OSError("file too short or changed")
            loaded, path = _load(path)
        except OSError as error:
            raise NativeMissing(f"Rumple's library is there but cannot be loaded. "
                                f"{platforms.why_refused(str(error), path)} ({error})") from error
        try:
            functions = {name: getattr(loaded, name) for name in c.FUNCTIONS}
        except AttributeError as error:
            raise NativeMissing(f"Rumple's library {path} is of another version: {error}") from error
        for name, function in functions.items():
            result, function.argtypes = c.FUNCTIONS[name]
            function.restype = ctypes.c_int32 if result is CHECKED else result
            if result is CHECKED:
                function.errcheck = self._check
        _compare(path, functions)
        self.__dict__.update(functions)
        self.path = path

    def __getattr__(self, name: str) -> Any:
        if name not in c.FUNCTIONS:
            raise AttributeError(name)
        self.open()
        return self.__dict__[name]

    def _check(self, status: int, _function: Any, _arguments: Any) -> int:
        """Raises the exception for a status (ValueError, MemoryError, Stopped or RuntimeError) with the library's
        message."""
        if status:
            text = self.rumple_error().decode(errors="replace")
            raise {1: ValueError, 2: MemoryError, 4: Stopped}.get(status, RuntimeError)(text)
        return status


def _load(path: Path) -> tuple[ctypes.CDLL, Path]:
    """The library, and its file. On systems that lock loaded files, the file is a copy. Raises OSError."""
    if platforms.is_locked_when_open():
        copy = platforms.copy_to_load(path)
        try:
            return ctypes.CDLL(str(copy)), copy
        except OSError:
            pass  # a studio may allow libraries only in folders of installed programs
    return ctypes.CDLL(str(path)), path


def _compare(path: Path, functions: dict[str, Any]) -> None:
    """Raises NativeMissing if the library's version or structs differ from these bindings."""
    version = functions["rumple_version"]().decode()
    if version != c.VERSION:
        raise NativeMissing(f"Rumple's library {path} has version {version}, the add-on {c.VERSION}. "
                            "Restart Blender after an update.")
    for name, struct in c.STRUCTS.items():
        size = functions["rumple_struct_size"](name.encode())
        if size != ctypes.sizeof(struct):
            raise NativeMissing(f"Rumple's library {path} has {size} bytes for {name}, the add-on "
                                f"{ctypes.sizeof(struct)}: they are of different versions. "
                                "Restart Blender after an update.")


lib = Library()
