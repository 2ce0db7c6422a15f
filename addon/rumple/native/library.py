# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds librumple and opens it, or says in words why that cannot be.

It lies in lib/ of this package's parent (what was installed) or in the folder of $RUMPLE_NATIVE (what was built).
One file serves every Python: it knows none.
"""
from __future__ import annotations

import ctypes
import os
import platform
from pathlib import Path
from typing import Any

from . import c
from .struct import CHECKED

BUNDLED = Path(__file__).parent.parent / "lib"
FILES = {"Windows": "rumple.dll", "Darwin": "librumple.dylib"}


class NativeMissing(RuntimeError):
    """There is no usable native library. The text is meant for the artist."""


def library_file() -> Path:
    """Where the library is. Raises NativeMissing."""
    name = FILES.get(platform.system(), "librumple.so")
    chosen = os.environ.get("RUMPLE_NATIVE")
    for folder in ([Path(chosen)] if chosen else []) + [BUNDLED]:
        if (folder / name).is_file():
            return (folder / name).resolve()  # a bare name would be searched for in the system
    raise NativeMissing(f"Rumple's library {name} for {platform.system()} {platform.machine()} is not in this "
                        "installation. Install the Rumple package made for this system.")


class Library:
    """The functions of the library, each by its name in the header. It is opened when the first one is called."""

    path: Path | None = None

    def open(self) -> None:
        """Opens it and compares it with what this layer was written for. Raises NativeMissing."""
        if self.path is not None:
            return
        path = library_file()
        try:
            loaded = ctypes.CDLL(str(path))
        except OSError as error:  # something that the system lacks (libgomp) or has too old (GLIBC): it is named
            raise NativeMissing(f"Rumple's library is there but cannot be loaded on {platform.system()} "
                                f"{platform.machine()}: {error}") from error
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
        """Raises what a status says: ValueError, MemoryError or RuntimeError, with the library's own words."""
        if status:
            text = self.rumple_error().decode(errors="replace")
            raise {1: ValueError, 2: MemoryError}.get(status, RuntimeError)(text)
        return status


def _compare(path: Path, functions: dict[str, Any]) -> None:
    """Raises NativeMissing where the library has other structs than this layer."""
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
