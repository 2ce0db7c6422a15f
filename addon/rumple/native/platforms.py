# SPDX-License-Identifier: GPL-3.0-or-later
"""Differences between operating systems in moving files and in finding the library. This module never opens it."""
from __future__ import annotations

import hashlib
import os
import platform
import shutil
import sys
import sysconfig
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

ON_WINDOWS = os.name == "nt"
_WAITS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)  # seconds before each further try
FILES = {"windows": "rumple.dll", "macos": "librumple.dylib", "linux": "librumple.so"}
SYSTEMS = {"win32": "windows", "darwin": "macos"}  # key: sys.platform
MADE_FOR = frozenset(("linux-x64", "windows-x64", "macos-arm64", "macos-x64"))
PROCESSORS = {"amd64": "x64", "x86_64": "x64", "aarch64": "arm64", "arm64": "arm64"}

# Parts of the system's error messages about a library, and advice for the artist. The first match counts.
REFUSALS = (
    (("GLIBC_", "GLIBCXX_"),
     "This Linux is older than the one that the package was built for: update it, or build Rumple on it."),
    (("code signature", "system policy", "quarantine", "not verified"),
     "macOS keeps files that were downloaded in quarantine. In Terminal, run: xattr -dr com.apple.quarantine "
     "\"{folder}\" and start Blender again."),
    (("invalid ELF header", "wrong ELF class", "file too short", "mach-o", "incompatible architecture",
      "WinError 193", "WinError 216"),
     "The file is damaged or made for another system. Install Rumple again, with the package for {here}."),
    (("WinError 5]", "WinError 225", "WinError 1260", "WinError 4551", "Permission denied", "not permitted"),
     "This computer does not allow it: a virus scanner or a rule of its administrator may hold it back."),
    (("WinError 126", "one of its dependencies", "cannot open shared object file", "Library not loaded"),
     "Something that it needs is not on this computer. Install Rumple again, with the package for {here}."),
)


def here(system: str | None = None, machine: str | None = None) -> str:
    """The name of this platform in packages, for example "windows-x64". Unknown systems keep their own names."""
    system, machine = system or sys.platform, machine or _machine()
    return f"{SYSTEMS.get(system, system)}-{PROCESSORS.get(machine.lower(), machine.lower())}"


def _machine() -> str:
    """The processor type that this process was built for. Not platform.machine() on Windows: it asks a service, which
    may be slow or forbidden, and it returns the computer's processor, but a Blender for x64 also runs on ARM."""
    return sysconfig.get_platform().rpartition("-")[2] if sys.platform == "win32" else platform.machine()


def file_name(of: str) -> str:
    """The name of the library's file for a platform such as "windows-x64"."""
    return FILES.get(of.partition("-")[0], FILES["linux"])


def why_refused(error: str, path: Path) -> str:
    """Advice for the artist if the system refuses to load a library. error: the system's message."""
    for signs, advice in REFUSALS:
        if any(sign.lower() in error.lower() for sign in signs):
            return advice.format(folder=path.parent, here=here())
    return f"Install Rumple again, with the package for {here()}."


def is_damaged(path: Path) -> bool:
    """Whether a library differs from the packed one. A truncated library would crash Blender when it is loaded. A
    package has a digest file beside the library (scripts/packaging.py). A built library has none."""
    digest = path.with_name(path.name + ".sha256")
    return digest.is_file() and digest.read_bytes().strip() != hashlib.sha256(path.read_bytes()).hexdigest().encode()


def is_locked_when_open() -> bool:
    """Whether the system does not allow to replace or remove a loaded library, as on Windows."""
    return sys.platform == "win32"


def tried_again(action: Callable[..., Any], *arguments: Any) -> Any:
    """The result of an action on files. Windows does not move or remove a file while anybody has it open, and virus
    scanners open new files for a moment. So on Windows the action is tried again, for three seconds. Raises the
    exception of the last try."""
    for wait in _WAITS if ON_WINDOWS else ():
        try:
            return action(*arguments)
        except PermissionError:
            time.sleep(wait)
    return action(*arguments)


def copy_to_load(path: Path, folder: Path | None = None) -> Path:
    """A copy of the library that Blender loads, so that an update can replace the installed file.

    Its name depends on its content, so different versions have different copies. Copies that no Blender has loaded are
    removed. Returns the library itself if no copy can be made. folder: for the copies, for tests.
    """
    copies = folder or Path(tempfile.gettempdir()) / "rumple-libraries"
    try:
        data = path.read_bytes()
        own = copies / hashlib.sha256(data).hexdigest()[:16]
        own.mkdir(parents=True, exist_ok=True)
        copy = own / path.name
        if not copy.is_file() or copy.read_bytes() != data:
            _write_copy(data, copy)
    except OSError:     # no space, no permission, or another Blender has a damaged copy loaded
        return path
    try:
        for other in copies.iterdir():
            if other != own:
                shutil.rmtree(other, ignore_errors=True)    # Windows keeps the loaded ones
    except OSError:     # another Blender removes copies at the same time
        pass
    return copy


def _write_copy(data: bytes, copy: Path) -> None:
    """Write a copy, by one rename. Raises OSError if the copy does not exist afterwards."""
    being_written = copy.with_name(f"{copy.name}.{os.getpid()}")
    try:
        being_written.write_bytes(data)
        tried_again(os.replace, being_written, copy)
    except OSError:
        try:
            being_written.unlink(missing_ok=True)
        except OSError:
            pass
        if not copy.is_file() or copy.read_bytes() != data:     # else another Blender made and loaded it meanwhile
            raise
