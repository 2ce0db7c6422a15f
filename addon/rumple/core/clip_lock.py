# SPDX-License-Identifier: GPL-3.0-or-later
"""Who bakes a clip, a worker or a window: a file beside it, so that two of them do not harm one another. No bpy here.

The file names host, process and, in a queue, the task ($RUMPLE_TASK: the same when a task is started again). Its holder
writes it anew while it works: its age is what a file server says, since the clocks of two machines differ (a time that
is set, as by os.utime, is the worker's on Windows). A lock is
taken over where nobody holds it any more: its process is gone (same host), its task was started again on another host
(a queue gives it up before it does that), or it was not touched for OLDEST seconds (another host). Whoever lost its
lock so stops at its next sample; until then both write files of their own.
"""
from __future__ import annotations

import json
import os
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from ..native import platforms
from . import clip_folder, windows_process
from .clip_manifest import ClipFault

OLDEST = 600.0  # seconds without a touch, for a lock of another host
_TOUCHED = 5.0  # seconds between two touches
_MOST_MISSED = 12  # touches, one after the other, that a share or a scanner may refuse


class Held(ClipFault):
    """Another worker bakes this clip."""


@dataclass(frozen=True)
class Holder:
    """Who has a lock."""

    host: str
    process: int
    started: str  # of the process, as the system counts it: numbers of processes come again
    task: str  # of the queue; empty: none

    @classmethod
    def here(cls) -> "Holder":
        process = os.getpid()
        return cls(clip_folder.HOST, process, _started(process), os.environ.get("RUMPLE_TASK", ""))

    @classmethod
    def read(cls, path: Path) -> "Holder | None":
        """None where it cannot be read."""
        try:
            return cls.of(path.read_bytes())
        except OSError:
            return None

    @classmethod
    def of(cls, text: bytes) -> "Holder | None":
        """As a lock has it. None where it is damaged: half written, say."""
        try:
            data = json.loads(text[:4096])
            return cls(str(data["host"]), int(data["process"]), str(data["started"]), str(data["task"]))
        except (ValueError, KeyError, TypeError):
            return None

    def is_gone(self) -> bool:
        """Whether it is known to work no more."""
        here = Holder.here()
        if self.host != here.host:
            return self.task != "" and self.task == here.task
        started = _started(self.process)  # empty: of another user, say, whose number is not known to have come again
        return not clip_folder.is_running(self.process) or started not in ("", self.started)

    def in_words(self) -> str:
        return f"process {self.process} on {self.host}" + (f" (task {self.task})" if self.task else "")


def _started(process: int) -> str:
    if os.name == "nt":
        return windows_process.started(process)
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[19]
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
        for attempt in range(3):  # another one may come first, and its lock be left as well
            try:
                self._make_folder()
                if self._create():
                    return
            except FileNotFoundError:  # another one, which had made the folder, has just given up
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
        """A bake that came to nothing leaves no folder, where nothing is in it."""
        for folder in self._made:
            try:
                folder.rmdir()
            except OSError:
                return

    def _create(self) -> bool:
        """Whole or not at all: a link to a file that is written already."""
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
        except OSError:  # no links on this disk
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
        """Away with a lock that nobody holds. Raises Held."""
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
        if (moved.st_ino, moved.st_mtime_ns) != (before.st_ino, before.st_mtime_ns):  # another one's, made meanwhile
            platforms.tried_again(os.rename, aside, self.path)
            return
        clip_folder.discard(aside)

    def _now(self) -> float:
        """By the clock of the disk."""
        probe = clip_folder.temporary(self.path)
        probe.touch()
        try:
            return probe.stat().st_mtime
        finally:
            clip_folder.discard(probe)

    def touch(self) -> None:
        """To be called often while it is held. Raises Held where it was taken over, and ClipFault where it could not be
        reached for some time: a share may be away for a moment."""
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
        """Raises Held where it was taken over, and ClipFault where it cannot be read."""
        self._reach(anew=False)

    def _reach(self, anew: bool) -> None:
        """As check() does. anew: write it, through the file that was read: never into that of who took it over."""
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
