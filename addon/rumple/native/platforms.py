# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between systems when files are moved, and when the library is found. Nothing here opens it."""
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
SYSTEMS = {"win32": "windows", "darwin": "macos"}  # as sys.platform has them
MADE_FOR = frozenset(("linux-x64", "windows-x64", "macos-arm64", "macos-x64"))
PROCESSORS = {"amd64": "x64", "x86_64": "x64", "aarch64": "arm64", "arm64": "arm64"}

# What the systems say when they refuse a library, and what the artist can do. The first that is found counts.
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
    """This system as packages name it: "windows-x64". Unknown ones keep their own names."""
    system, machine = system or sys.platform, machine or _machine()
    return f"{SYSTEMS.get(system, system)}-{PROCESSORS.get(machine.lower(), machine.lower())}"


def _machine() -> str:
    """What this process is made for. On Windows platform.machine() asks a service, which may be slow or forbidden, and
    tells the computer's processor: on ARM a Blender for x64 runs, too."""
    return sysconfig.get_platform().rpartition("-")[2] if sys.platform == "win32" else platform.machine()


def file_name(of: str) -> str:
    """The library's file of a platform, "windows-x64"."""
    return FILES.get(of.partition("-")[0], FILES["linux"])


def why_refused(error: str, path: Path) -> str:
    """What the artist can do about a library that the system refuses to load. error: the system's words."""
    for signs, advice in REFUSALS:
        if any(sign.lower() in error.lower() for sign in signs):
            return advice.format(folder=path.parent, here=here())
    return f"Install Rumple again, with the package for {here()}."


def is_damaged(path: Path) -> bool:
    """Whether a library is not the one that was packed: a system that maps a truncated file ends Blender. The
    package has its digest beside it (scripts/packaging.py); what was built has none."""
    digest = path.with_name(path.name + ".sha256")
    return digest.is_file() and digest.read_bytes().strip() != hashlib.sha256(path.read_bytes()).hexdigest().encode()


def is_locked_when_open() -> bool:
    """Windows lets nobody replace or remove a library that is loaded."""
    return sys.platform == "win32"


def tried_again(action: Callable[..., Any], *arguments: Any) -> Any:
    """What an action on files returns. Windows refuses to move and remove a file while anybody has it open, as virus
    scanners do for a moment: there it is tried again, for three seconds. Raises what the last try raises."""
    for wait in _WAITS if ON_WINDOWS else ():
        try:
            return action(*arguments)
        except PermissionError:
            time.sleep(wait)
    return action(*arguments)


def copy_to_load(path: Path, folder: Path | None = None) -> Path:
    """A copy of the library for Blender to hold, so that an update can replace the installed one.

    It is named after its content, so two versions do not meet. Copies that no Blender holds any more are removed.
    Returns the library itself where no copy can be made. folder: where copies go, for tests.
    """
    copies = folder or Path(tempfile.gettempdir()) / "rumple-libraries"
    try:
        data = path.read_bytes()
        own = copies / hashlib.sha256(data).hexdigest()[:16]
        own.mkdir(parents=True, exist_ok=True)
        copy = own / path.name
        if not copy.is_file() or copy.read_bytes() != data:
            _write_copy(data, copy)
    except OSError:     # no place, no right to write there, or somebody holds a damaged copy
        return path
    try:
        for other in copies.iterdir():
            if other != own:
                shutil.rmtree(other, ignore_errors=True)    # what a Blender holds stays: Windows refuses
    except OSError:     # another Blender tidies up as well
        pass
    return copy


def _write_copy(data: bytes, copy: Path) -> None:
    """By one rename. Raises OSError where there is no such copy then."""
    being_written = copy.with_name(f"{copy.name}.{os.getpid()}")
    try:
        being_written.write_bytes(data)
        tried_again(os.replace, being_written, copy)
    except OSError:
        try:
            being_written.unlink(missing_ok=True)
        except OSError:
            pass
        if not copy.is_file() or copy.read_bytes() != data:     # another Blender has made and loaded it meanwhile
            raise
