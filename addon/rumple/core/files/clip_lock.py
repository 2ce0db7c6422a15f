# SPDX-License-Identifier: GPL-3.0-or-later
"""The lock of a clip: a file beside it that says who bakes it, so that two workers do not disturb each other.

The file names the host, the process and, in a queue, the task ($RUMPLE_TASK, which is the same when a task is started
again). The holder writes the file again and again while it works. The age of the lock is measured by the clock of the
file server, because the clocks of two machines differ. (os.utime would set the worker's time on Windows.)

A lock is taken over in three cases. Its process is gone (same host). Its task was started again on another host: a
queue gives a task up before it does that. It was not touched for OLDEST seconds (another host). A worker that lost its
lock stops at its next sample. Until then both workers write files of their own. Never imports bpy.
"""
from __future__ import annotations

import json
import os
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from ...native import platforms
from . import clip_folder, windows_process
from .clip_manifest import ClipFault

OLDEST = 600.0  # seconds without a touch, for a lock of another host
_TOUCHED = 5.0  # seconds between two touches
_MOST_MISSED = 12  # touches in a row that may fail, as a network share or a virus scanner may block them


class Held(ClipFault):
    """Raised if another worker bakes this clip."""


@dataclass(frozen=True)
class Holder:
    """Who has a lock."""

    host: str
    process: int
    started: str  # start time of the process, in the system's units, because process numbers are reused
    task: str  # of the queue; empty: none

    @classmethod
    def here(cls) -> "Holder":
        process = os.getpid()
        return cls(clip_folder.HOST, process, _started(process), os.environ.get("RUMPLE_TASK", ""))

    @classmethod
    def read(cls, path: Path) -> "Holder | None":
        """None if it cannot be read."""
        try:
            return cls.of(path.read_bytes())
        except OSError:
            return None

    @classmethod
    def of(cls, text: bytes) -> "Holder | None":
        """From the text of a lock. None if it is damaged, for example half written."""
        try:
            data = json.loads(text[:4096])
            return cls(str(data["host"]), int(data["process"]), str(data["started"]), str(data["task"]))
        except (ValueError, KeyError, TypeError):
            return None

    def is_gone(self) -> bool:
        """Whether it certainly no longer works."""
        here = Holder.here()
        if self.host != here.host:
            return self.task != "" and self.task == here.task
        started = _started(self.process)  # empty: not readable, for example another user's process
        return not clip_folder.is_running(self.process) or started not in ("", self.started)

    def in_words(self) -> str:
        return f"process {self.process} on {self.host}" + (f" (task {self.task})" if self.task else "")


def _started(process: int) -> str:
    if os.name == "nt":
        return windows_process.started(process)
    try:
        # Linux cuts the name in it after 15 bytes, also in the middle of a character.
        return Path(f"/proc/{process}/stat").read_bytes().rsplit(b")", 1)[1].split()[19].decode("ascii")
    except (OSError, IndexError):
        return ""


class Lock:
    """Held from its making to release(). Making it raises Held, or ClipFault where nothing can be written."""

    def __init__(self, clip: Path, oldest: float = OLDEST) -> None:
        self.path, self.clip, self.holder = clip.with_name(f".{clip.name}.lock"), clip, Holder.here()
        self._touched, self._missed = 0.0, 0
        self._made: list[Path] = []  # folders, the innermost first
        try:
            self._take(oldest)
        except (OSError, ValueError) as error:
            self._remove_made()
            raise ClipFault(clip_folder.in_words(error, clip.parent)) from error

    def _take(self, oldest: float) -> None:
        for attempt in range(3):  # another worker may be faster, and leave its lock as well
            try:
                self._make_folder()
                if self._create():
                    return
            except FileNotFoundError:  # another worker had made the folder, and has just removed it
                if attempt == 2:
                    raise
                continue
            self._take_over(oldest)
        raise Held(f"others take and leave its lock {self.path.name}: try again")

    def _make_folder(self) -> None:
        missing = [folder for folder in (self.clip.parent, *self.clip.parent.parents) if not folder.exists()]
        self._made += [folder for folder in missing if folder not in self._made]
        self.clip.parent.mkdir(parents=True, exist_ok=True)

    def _remove_made(self) -> None:
        """Remove the folders that were made here if they are empty, as after a bake that failed."""
        for folder in self._made:
            try:
                folder.rmdir()
            except OSError:
                return

    def _create(self) -> bool:
        """Make the lock file in one step, never half written: as a hard link to a file that is already written."""
        own = clip_folder.temporary(self.path)
        try:
            own.write_text(json.dumps(asdict(self.holder)))
        except OSError:
            clip_folder.discard(own)
            raise
        try:
            os.link(own, self.path)
        except FileExistsError:
            return False
        except OSError:  # this disk has no hard links
            return self._create_plainly()
        finally:
            clip_folder.discard(own)
        self._touched = time.monotonic()
        return True

    def _create_plainly(self) -> bool:
        try:
            with open(self.path, "x") as file:
                file.write(json.dumps(asdict(self.holder)))
        except FileExistsError:
            return False
        self._touched = time.monotonic()
        return True

    def _take_over(self, oldest: float) -> None:
        """Remove a lock that nobody holds. Raises Held if somebody holds it."""
        holder = Holder.read(self.path)
        try:
            before = self.path.stat()
            age = self._now() - before.st_mtime
        except FileNotFoundError:
            return  # released meanwhile
        if age < oldest and not (holder is not None and holder.is_gone()):
            who = holder.in_words() if holder is not None else "somebody"
            age = max(age, 0.0)
            raise Held(f"{self.clip.name} is being baked by {who}, last heard of {age:.0f} s ago: wait for it")
        aside = clip_folder.temporary(self.path)
        try:
            platforms.tried_again(os.rename, self.path, aside)
        except FileNotFoundError:
            return
        moved = aside.stat()
        if (moved.st_ino, moved.st_mtime_ns) != (before.st_ino, before.st_mtime_ns):  # another worker made it meanwhile
            platforms.tried_again(os.rename, aside, self.path)
            return
        clip_folder.discard(aside)

    def _now(self) -> float:
        """The time by the clock of the disk."""
        probe = clip_folder.temporary(self.path)
        probe.touch()
        try:
            return probe.stat().st_mtime
        finally:
            clip_folder.discard(probe)

    def touch(self) -> None:
        """Call this often while the lock is held. Raises Held if it was taken over, and ClipFault if it could not be
        reached for some time. A network share may be away for a moment."""
        if time.monotonic() - self._touched < _TOUCHED:
            return
        self._touched = time.monotonic()
        try:
            self._reach(anew=True)
        except Held:
            raise
        except ClipFault:
            self._missed += 1
            if self._missed > _MOST_MISSED:
                raise
        else:
            self._missed = 0

    def check(self) -> None:
        """Raises Held if the lock was taken over, and ClipFault if it cannot be read."""
        self._reach(anew=False)

    def _reach(self, anew: bool) -> None:
        """Like check(). anew: also write it, through the file handle that was read. So it never writes into the lock of
        a worker that took over."""
        try:
            with self.path.open("r+b" if anew else "rb") as file:
                text = file.read()
                holder = Holder.of(text)
                if holder == self.holder and anew:
                    file.seek(0)
                    file.write(text)
        except OSError as error:
            if not isinstance(error, FileNotFoundError) or not self.path.parent.is_dir():
                raise ClipFault(clip_folder.in_words(error, self.clip.parent)) from error
            holder = None
        if holder != self.holder:
            who = holder.in_words() if holder is not None else "somebody"
            raise Held(f"{self.clip.name} was taken over by {who}: wait for it")

    def release(self) -> None:
        """Never raises."""
        try:
            if Holder.of(platforms.tried_again(self.path.read_bytes)) != self.holder:
                return
            platforms.tried_again(self.path.unlink)
        except OSError:
            pass  # taken over, or left to the end of this process
        self._remove_made()
