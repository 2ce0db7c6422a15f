# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of baked clips: names that no two clips share, temporary files, and its faults in words. No bpy here."""
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

from ..native import platforms
from . import windows_process
from .clip_manifest import ClipFault

_LONGEST_PATH = 240  # letters that every program may use on Windows: 260, without those of temporary names
_AWAY = (55, 59, 64, 121, 1231)  # what Windows says of a share that is away, and Python has no other number for
LONGEST = 60  # letters of a file's or an object's name in the name of a clip
_OUTSIDE = "pid:[4026531836]"  # the first PID namespace of Linux, which is that of no container
_DEVICE = re.compile(r"con|prn|aux|nul|(com|lpt)\d", re.IGNORECASE)
_PART = re.compile(r"\..+\.(?P<host>[A-Za-z0-9_]+)\.(?P<process>\d+)-\d+\.part")
_numbers = itertools.count()


def _host() -> str:
    """The name of the host and, in a container, its PID namespace: containers may share the name of their host."""
    # Not platform.node(): Windows is slow to tell it.
    name = re.sub(r"[^A-Za-z0-9]", "_", socket.gethostname()) or "host"
    try:
        numbers = os.readlink("/proc/self/ns/pid")
    except OSError:  # no Linux
        return name
    return name if numbers == _OUTSIDE else "_".join([name, *re.findall(r"\d+", numbers)])


HOST = _host()


def clip_name(file: str, obj: str, place: str = "") -> str:
    """The file name of the clip of an object in a blend file: without dots but the last, and for no two the same.

    file: name of the blend file, without suffix. place: what else tells files of that name apart.
    """
    return f"{readable(file)}-{readable(obj)}-{digest(file, obj, place)}.pc2"


def readable(name: str) -> str:
    """A part of a file name, or all of it: Windows takes "aux.glb" for a device."""
    plain = re.sub(r"[^\w-]", "_", name, flags=re.ASCII)[:LONGEST]
    return f"{plain}_" if _DEVICE.fullmatch(plain) else plain


def readable_beside(name: str, others: list[str], about: str = "") -> str:
    """As readable(), but for no two objects of a file the same, also on disks that do not tell "A" from "a".

    others: the names of the other objects. about: what tells objects of one name apart.
    """
    plain = readable(name)
    if plain.casefold() not in [readable(other).casefold() for other in others]:
        return plain
    return f"{plain}-{digest(name, about)}"


def digest(*parts: str) -> str:
    """Eight letters that tell names apart."""
    return hashlib.blake2b(repr(parts).encode("utf-8", "surrogatepass"), digest_size=4).hexdigest()


# ---------------------------------------------------------------- temporary files
def temporary(clip: Path, suffix: str = ".part") -> Path:
    """A file beside a clip that nobody else writes."""
    return clip.with_name(f".{clip.name}.{HOST}.{os.getpid()}-{next(_numbers)}{suffix}")


def sweep(folder: Path) -> None:
    """Remove what bakes that were killed left behind: of processes of this machine that are gone."""
    for path in folder.glob(".*.part"):
        found = _PART.fullmatch(path.name)
        if found is None or found["host"] != HOST or is_running(int(found["process"])):
            continue
        discard(path)


def discard(path: Path) -> None:
    """Remove a temporary file or folder. Never raises: another one may have swept it, or may do so."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
        return
    try:
        path.unlink(missing_ok=True)
    except OSError:
        pass


def put(new: Path, place: Path) -> None:
    """Put a file in place of another one, or of none, by one rename. Raises OSError."""
    platforms.tried_again(os.replace, new, place)


@contextmanager
def written(place: Path) -> Iterator[Path]:
    """A file to be written, which is put at a place by one rename behind the block, and removed where something was
    raised. Raises OSError."""
    new = temporary(place)
    try:
        yield new
        put(new, place)
    finally:
        discard(new)


@contextmanager
def aside(place: Path) -> Iterator[None]:
    """What stands at a place is out of the way meanwhile. Then it is removed, or is there again where something was
    raised."""
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
    """Put a whole folder in place of another one, or of none. Raises OSError; then the former one is there."""
    with aside(place):
        put(new, place)


def is_running(process: int) -> bool:
    """Whether this machine has a process of that number."""
    if os.name == "nt":  # os.kill(process, 0) would end it there
        return windows_process.is_running(process)
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        pass  # of another user
    return True


# ---------------------------------------------------------------- faults
def make(folder: Path, needed: int) -> None:
    """The folder, with room for so many bytes. Raises ClipFault."""
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
    """Tried: permissions do not say it of every disk."""
    probe = folder / f".{HOST}.{os.getpid()}-{next(_numbers)}.part"
    try:
        probe.touch()
    except OSError:
        return False
    discard(probe)
    return True


def megabytes(count: int) -> str:
    """For a sentence."""
    return f"{count / 2**20:.1f}" if count < 100 << 20 else f"{count >> 20}"


def in_words(error: Exception, folder: Path) -> str:
    """What a folder refused, and what to do."""
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
    """Where its reasons are others; else empty."""
    paths = [str(folder), *(str(getattr(error, name, None) or "") for name in ("filename", "filename2"))]
    if number in (errno.ENOENT, errno.EINVAL, errno.ENAMETOOLONG) and max(map(len, paths)) > _LONGEST_PATH:
        return f"the path {folder} is too long for Windows: choose another folder, or shorter names"
    if number in (errno.EACCES, errno.EPERM):
        return (f"nothing can be written to {folder}: close the program that has a file of it open, change its "
                "permissions, or choose another folder")
    if getattr(error, "winerror", None) in _AWAY:
        return in_words(OSError(errno.ENODEV, ""), folder)
    return ""
