# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of baked clips: unique file names, temporary files, and error messages. No bpy here."""
from __future__ import annotations

import errno
import hashlib
import itertools
import os
import re
import shutil
import socket
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

from ...native import platforms
from . import windows_process
from .clip_manifest import ClipFault

_LONGEST_PATH = 240  # letters of a path: Windows allows 260 to every program, and temporary names need some of them
# error numbers of Windows for a network share that is not available; Python has no errno for them
_AWAY = (55, 59, 64, 121, 1231)
LONGEST = 60  # letters of a file's or object's name that are used in the name of a clip
_OUTSIDE = "pid:[4026531836]"  # the initial PID namespace of Linux: the process is in no container
_DEVICE = re.compile(r"con|prn|aux|nul|(com|lpt)\d", re.IGNORECASE)
_PART = re.compile(r"\..+\.(?P<host>[A-Za-z0-9_]+)\.(?P<process>\d+)-\d+\.part")
_numbers = itertools.count()


def _host() -> str:
    """The name of the host. In a container its PID namespace is added, because containers may have the host's name."""
    # Not platform.node(), which is slow on Windows.
    name = re.sub(r"[^A-Za-z0-9]", "_", socket.gethostname()) or "host"
    try:
        numbers = os.readlink("/proc/self/ns/pid")
    except OSError:  # not Linux
        return name
    return name if numbers == _OUTSIDE else "_".join([name, *re.findall(r"\d+", numbers)])


HOST = _host()


def clip_name(file: str, obj: str, place: str = "") -> str:
    """The file name of an object's clip. It is unique, and its only dot is before the suffix.

    file: name of the blend file, without suffix. place: tells blend files of the same name apart.
    """
    return f"{readable(file)}-{readable(obj)}-{digest(file, obj, place)}.pc2"


def readable(name: str) -> str:
    """A name that is safe as a file name, or as a part of one. On Windows names like "aux.glb" are devices."""
    plain = re.sub(r"[^\w-]", "_", name, flags=re.ASCII)[:LONGEST]
    return f"{plain}_" if _DEVICE.fullmatch(plain) else plain


def readable_beside(name: str, others: list[str], about: str = "") -> str:
    """Like readable(), but different for each object of a file, also on disks where "A" and "a" are the same name.

    others: the names of the other objects. about: tells objects of the same name apart.
    """
    plain = readable(name)
    if plain.casefold() not in [readable(other).casefold() for other in others]:
        return plain
    return f"{plain}-{digest(name, about)}"


def digest(*parts: str) -> str:
    """Eight letters that differ for different names."""
    return hashlib.blake2b(repr(parts).encode("utf-8", "surrogatepass"), digest_size=4).hexdigest()


# ---------------------------------------------------------------- temporary files
def temporary(clip: Path, suffix: str = ".part") -> Path:
    """The path of a temporary file beside a clip. No other process uses it."""
    return clip.with_name(f".{clip.name}.{HOST}.{os.getpid()}-{next(_numbers)}{suffix}")


def sweep(folder: Path) -> None:
    """Remove the temporary files of bakes that were killed: processes of this machine that no longer run."""
    for path in folder.glob(".*.part"):
        found = _PART.fullmatch(path.name)
        if found is None or found["host"] != HOST or is_running(int(found["process"])):
            continue
        discard(path)


def discard(path: Path) -> None:
    """Remove a temporary file or folder. Never raises: another process may remove it at the same time."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
        return
    try:
        path.unlink(missing_ok=True)
    except OSError:
        pass


def put(new: Path, place: Path) -> None:
    """Move a file to its place by one rename, replacing a former one. Raises OSError."""
    platforms.tried_again(os.replace, new, place)


@contextmanager
def written(place: Path) -> Iterator[Path]:
    """A context with a temporary file to write. At its end one rename moves the file to its place. After an exception
    the file is removed. Raises OSError."""
    new = temporary(place)
    try:
        yield new
        put(new, place)
    finally:
        discard(new)


@contextmanager
def aside(place: Path) -> Iterator[None]:
    """A context in which the file or folder at a place is moved away. At the end it is removed. After an exception it
    is moved back."""
    former = temporary(place)
    try:
        put(place, former)
    except FileNotFoundError:
        pass
    try:
        yield
    except BaseException:
        if former.exists():
            put(former, place)
        raise
    discard(former)


def replace_folder(new: Path, place: Path) -> None:
    """Move a whole folder to its place, replacing a former one. Raises OSError; then the former folder is kept."""
    with aside(place):
        put(new, place)


def is_running(process: int) -> bool:
    """Whether this machine has a process with this number."""
    if os.name == "nt":  # there os.kill(process, 0) would end the process
        return windows_process.is_running(process)
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        pass  # it belongs to another user
    return True


# ---------------------------------------------------------------- faults
def make(folder: Path, needed: int) -> None:
    """Make the folder, and check that the disk has room for `needed` bytes. Raises ClipFault."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        sweep(folder)
        free = shutil.disk_usage(folder).free
    except (OSError, ValueError) as error:
        raise ClipFault(in_words(error, folder)) from error
    if free < needed:
        raise ClipFault(f"the bake needs {megabytes(needed)} MB and the disk of {folder} has {megabytes(free)} MB "
                        "left: make room, or choose another folder")


def can_write(folder: Path) -> bool:
    """Whether a file can be made there. It tries, because permissions are not reliable on every disk."""
    probe = folder / f".{HOST}.{os.getpid()}-{next(_numbers)}.part"
    try:
        probe.touch()
    except OSError:
        return False
    discard(probe)
    return True


def megabytes(count: int) -> str:
    """A number of bytes in megabytes, as text."""
    return f"{count / 2**20:.1f}" if count < 100 << 20 else f"{count >> 20}"


def in_words(error: Exception, folder: Path) -> str:
    """A message about a failed file operation, and what to do."""
    number = error.errno if isinstance(error, OSError) else None
    if platforms.ON_WINDOWS:
        text = _words_of_windows(error, number, folder)
        if text:
            return text
    if number in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return f"the disk of {folder} is full: make room, or choose another folder"
    if number in (errno.EACCES, errno.EPERM, errno.EROFS):
        return f"nothing can be written to {folder}: change its permissions, or choose another folder"
    if number in (errno.ENOENT, errno.ENODEV, errno.ESTALE, errno.ENOTCONN, errno.EIO, errno.ETIMEDOUT):
        return f"the folder {folder} is gone or cannot be made: connect its disk, or choose another folder"
    if number in (errno.EEXIST, errno.ENOTDIR):
        return f"{folder} is no folder, or leads through a file: choose another folder"
    if number in (errno.ENAMETOOLONG, errno.EINVAL) or number is None:
        return f"{str(folder)[:80]} cannot be the name of a folder: choose another folder"
    return f"{folder}: {os.strerror(number).lower()}: choose another folder"


def _words_of_windows(error: Exception, number: int | None, folder: Path) -> str:
    """The message if the error has a reason that only Windows has; otherwise empty."""
    paths = [str(folder), *(str(getattr(error, name, None) or "") for name in ("filename", "filename2"))]
    if number in (errno.ENOENT, errno.EINVAL, errno.ENAMETOOLONG) and max(map(len, paths)) > _LONGEST_PATH:
        return f"the path {folder} is too long for Windows: choose another folder, or shorter names"
    if number in (errno.EACCES, errno.EPERM):
        return (f"nothing can be written to {folder}: close the program that has a file of it open, change its "
                "permissions, or choose another folder")
    if getattr(error, "winerror", None) in _AWAY:
        return in_words(OSError(errno.ENODEV, ""), folder)
    return ""
