# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes of Windows: whether one runs, and since when. No bpy here."""
from __future__ import annotations

import ctypes
from contextlib import contextmanager
from typing import Any, Iterator

_ACCESS = 0x100000 | 0x1000  # SYNCHRONIZE | PROCESS_QUERY_LIMITED_INFORMATION
_ENDED = 0  # WAIT_OBJECT_0
_ACCESS_DENIED = 5


def is_running(process: int) -> bool:
    """Whether a process runs. An ended process can still be opened while anybody has a handle of it. A process of
    another user cannot be opened."""
    with _opened(process) as (kernel, handle):
        if not handle:
            return ctypes.get_last_error() == _ACCESS_DENIED  # type: ignore[attr-defined]
        return kernel.WaitForSingleObject(handle, 0) != _ENDED


def started(process: int) -> str:
    """The start time of a process, in the system's units; empty if it is not available."""
    times = [ctypes.c_uint64() for _ in range(4)]  # FILETIME: start, end, time in the kernel, time outside of it
    with _opened(process) as (kernel, handle):
        found = handle and kernel.GetProcessTimes(handle, *map(ctypes.byref, times))
    return str(times[0].value) if found else ""


@contextmanager
def _opened(process: int) -> Iterator[tuple[Any, int | None]]:
    """The system's functions, and a handle. None: there is no such process, or access is denied."""
    kernel = ctypes.WinDLL("kernel32", use_last_error=True)  # type: ignore[attr-defined]
    kernel.OpenProcess.argtypes = ctypes.c_uint32, ctypes.c_int32, ctypes.c_uint32
    kernel.OpenProcess.restype = ctypes.c_void_p  # else the upper half of a handle is lost
    kernel.WaitForSingleObject.argtypes = ctypes.c_void_p, ctypes.c_uint32
    kernel.WaitForSingleObject.restype = ctypes.c_uint32
    kernel.GetProcessTimes.argtypes = (ctypes.c_void_p,) * 5
    kernel.CloseHandle.argtypes = (ctypes.c_void_p,)
    handle = kernel.OpenProcess(_ACCESS, False, process)
    try:
        yield kernel, handle
    finally:
        if handle:
            kernel.CloseHandle(handle)
