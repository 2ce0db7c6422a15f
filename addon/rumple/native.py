# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the native module `rumple_native`, or says in words why there is none.

Three ways to have it: installed as a wheel (Blender's extensions do that), in lib/<abi>/ of this package
(the legacy zip, one folder for each Python), or on sys.path from a build folder.
"""
from __future__ import annotations

import functools
import importlib
import importlib.util
import platform
import sys
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from types import ModuleType

LIBRARY = Path(__file__).parent / "lib"


class NativeMissing(RuntimeError):
    """There is no usable native module. The text is meant for the artist."""


@functools.lru_cache(maxsize=None)
def load() -> ModuleType:
    """The module. Throws NativeMissing."""
    try:
        return importlib.import_module("rumple_native")
    except ModuleNotFoundError as error:
        if error.name != "rumple_native":
            raise NativeMissing(f"Rumple's native module needs the Python module {error.name}, "
                                "which this Blender does not have.") from error
    except ImportError as error:
        raise _unloadable(error) from error
    return _load_file(_bundled_file())


def _bundled_file() -> Path:
    for suffix in EXTENSION_SUFFIXES:
        file = LIBRARY / suffix.split(".")[1] / f"rumple_native{suffix}"
        if file.is_file():
            return file
    have = ", ".join(sorted(folder.name for folder in LIBRARY.glob("*/"))) or "none"
    raise NativeMissing(f"Rumple's native module for {_this_python()} is not in this installation "
                        f"(bundled: {have}). Install the Rumple package made for this Blender and system.")


def _load_file(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location("rumple_native", file)
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError as error:
        raise _unloadable(error) from error
    sys.modules["rumple_native"] = module
    return module


def _unloadable(error: ImportError) -> NativeMissing:
    """A library that the system lacks (libgomp, libstdc++) or has too old (GLIBC, GLIBCXX): the loader names it."""
    return NativeMissing(f"Rumple's native module is there but cannot be loaded by {_this_python()}: {error}")


def _this_python() -> str:
    version = ".".join(map(str, sys.version_info[:2]))
    return f"Python {version} on {platform.system()} {platform.machine()}"
