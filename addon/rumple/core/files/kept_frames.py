# SPDX-License-Identifier: GPL-3.0-or-later
"""Stores final frames as files, so that they need not be solved again after the blend file is reopened. Never imports
bpy.

Each object has a folder with a file for each final frame. The file name is a digest of version, model, paint, first
frame, frame rate and frame number. So a frame of another mesh is never found, and there is one file for a frame: after
a change of the animation or the settings it is replaced. The file contains a digest of its bytes, the digest of the
frame's inputs, its chain (see frame_cache.py), then the solver's state in the format of a checkpoint. It is read only
for the same inputs, and only if the files of the frames before it agree with its chain.

Every process writes the same bytes for the same frame, and moves the file into place by a rename. So two Blenders may
use one folder, and one may remove files that the other has written.
"""
from __future__ import annotations

import hashlib
import io
import math
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Hashable

from ...native import c
from ..frame.frame_cache import CachedFrame, History
from . import clip_folder
from .checkpoint import CannotGoOn, Checkpoint

if TYPE_CHECKING:
    from ..frame.engine import Wrinkles

SUFFIX = ".frame"
FORMAT = 17  # raise it when frames get other bits. In format 7, for example, sweeps had another order
_HEAD = b"rumple frame\n"
_DIGEST = 16  # bytes
_BEGIN = len(_HEAD) + 3 * _DIGEST  # bytes in front of the checkpoint: its own digest, that of the inputs, the chain
_MOST_REFUSED = 5  # failed renames in a row: a virus scanner keeps a new file open for a moment


class _NotNow(OSError):
    """A rename failed, perhaps only for a moment."""


class KeptFrames:
    """The frame files of one evaluator. It never raises: `note` says what went wrong."""

    def __init__(self, evaluator: Wrinkles, folder: Path, identity: str, limit_bytes: int) -> None:
        """folder: of this object only; it is made by the first write. identity: text that identifies the model.
        limit_bytes: of all files in the folder."""
        self.evaluator, self.folder, self.about, self.limit_bytes = evaluator, folder, identity, limit_bytes
        self.identity = repr((FORMAT, c.VERSION, type(evaluator).__name__, evaluator.unit_scale, identity))
        self.note = ""
        self._is_stopped = False  # writing is not possible
        self._refused = 0  # failed renames since the last successful one
        self._known: dict[str, History] = {}  # by name: of files that were written, were found, or are too large
        self._damaged: set[str] = set()

    # --- reading
    def read(self, frame: float, input_digest: bytes) -> CachedFrame | None:
        """The stored frame with these inputs, or None. Its digest is checked. Cost: reading one file."""
        name = self._name(self.evaluator.frame_cache.timeline, frame)
        if name in self._damaged:
            return None
        try:
            with open(self.folder / name, "rb") as file:
                begin = file.read(_BEGIN)
                stored = self._take(name, begin)
                if stored is not None and stored.input_digest != input_digest:
                    return None
                content = file.read()
        except (OSError, ValueError):
            return None  # the usual case: it is not there
        try:
            return self._restored(begin, content, input_digest)
        except CannotGoOn:
            self._known.pop(name, None)
            self._damaged.add(name)
            self.note = (f"{self.evaluator.name}: a stored frame on disk is damaged, or of something else: it is "
                         "solved anew")
            return None

    def _restored(self, begin: bytes, content: bytes, input_digest: bytes) -> CachedFrame:
        if begin[:-2 * _DIGEST] != _HEAD + _digest(begin[-2 * _DIGEST:], content):
            raise CannotGoOn("its digest is another one")
        kept = Checkpoint.read(io.BytesIO(content), self._identity())
        if kept is None or kept.input_digest != input_digest:
            raise CannotGoOn("it is of something else")
        return kept.restored(self.evaluator)

    def history(self, frame: float) -> History | None:
        """The history of the stored frame, or None. Cost: reading the first bytes of a file, once."""
        return self._history(self._name(self.evaluator.frame_cache.timeline, frame))

    def _history(self, name: str) -> History | None:
        if name not in self._known and name not in self._damaged:
            try:
                with open(self.folder / name, "rb") as file:
                    self._take(name, file.read(_BEGIN))
            except (OSError, ValueError):
                pass
        return self._known.get(name)

    def _take(self, name: str, begin: bytes) -> History | None:
        """The history in the first bytes of a file; None if they are damaged."""
        if len(begin) != _BEGIN or not begin.startswith(_HEAD):
            return None
        self._known[name] = History(begin[-2 * _DIGEST:-_DIGEST], begin[-_DIGEST:])
        return self._known[name]

    # --- writing
    def write(self, seconds: float = math.inf) -> bool:
        """Write final frames of the frame cache that are not on disk, at least one, for about this number of seconds.
        Then remove the oldest files above the limit. Returns whether more frames are left to write."""
        if self._is_stopped:
            return False
        ends, wrote, more = time.perf_counter() + seconds, False, False
        try:
            for timeline, frame, cached in self.evaluator.frame_cache.final_frames():
                name = self._name(timeline, frame)
                if self._history(name) == cached.history:
                    continue
                if wrote and time.perf_counter() > ends:
                    more = True
                    break
                wrote = self._write(name, frame, cached, math.isinf(seconds)) or wrote
                self._drop_older(self._name(timeline, math.ceil(frame) - 1.0), cached.history)
            if wrote:
                self._sweep()
        except _NotNow:
            return True
        except (OSError, ValueError) as error:
            self._is_stopped = True
            self.note = f"{self.evaluator.name}: its stored frames are not kept: {self._in_words(error)}"
            return False
        return more

    def _write(self, name: str, frame: float, cached: CachedFrame, may_wait: bool) -> bool:
        """Returns whether it was written now."""
        path = self.folder / name
        content = Checkpoint.of(int(frame), cached).to_bytes(self._identity())
        if len(content) > self.limit_bytes:
            self._known[name] = cached.history
            return False
        if not self.folder.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
        own = clip_folder.temporary(path)
        try:
            history = b"".join(cached.history)
            own.write_bytes(_HEAD + _digest(history, content) + history + content)
            self._put(own, path, may_wait)
        except OSError:
            clip_folder.discard(own)
            raise
        self._known[name] = cached.history
        self._damaged.discard(name)
        return True

    def _drop_older(self, before: str, written: History) -> None:
        """Remove the file of the frame before the written one, if that did not go on from it: then it is from before a
        change. So wherever two files do not agree, the earlier frame is the newer file."""
        known = self._history(before)
        if known is not None and not written.begins and not written.goes_on_from(known):
            clip_folder.discard(self.folder / before)
            del self._known[before]

    def _put(self, own: Path, path: Path, may_wait: bool) -> None:
        """Move a file into place. Raises _NotNow if the next write() should try again, because a window must not
        wait."""
        try:
            if may_wait:
                clip_folder.put(own, path)
            else:
                os.replace(own, path)
        except PermissionError as error:
            self._refused += 1
            if self._refused >= _MOST_REFUSED:
                raise
            raise _NotNow from error
        self._refused = 0

    def _sweep(self) -> None:
        clip_folder.sweep(self.folder)
        files = []
        for path in self.folder.glob("*" + SUFFIX):
            try:
                about = path.stat()
            except OSError:
                continue  # another Blender has removed it
            files.append((about.st_mtime_ns, path.name, about.st_size, path))
        total = sum(size for _, _, size, _ in files)
        for _, _, size, path in sorted(files):
            if total <= self.limit_bytes:
                return
            clip_folder.discard(path)
            total -= size

    def clear(self) -> None:
        """Remove the files of all models of this object."""
        for path in self.folder.glob("*" + SUFFIX):
            clip_folder.discard(path)
        self._known.clear()
        self._damaged.clear()
        self.note, self._is_stopped, self._refused = "", False, 0

    def _in_words(self, error: Exception) -> str:
        return clip_folder.in_words(error, self.folder.parent)

    def _identity(self) -> str:
        """The identity with the digest of the current paint."""
        return f"{self.identity} {self.evaluator.paint_digest.hex()}"

    def _name(self, timeline: Hashable, frame: float) -> str:
        return _digest(f"{self._identity()} {timeline!r} {frame!r}".encode()).hex() + SUFFIX


def _digest(*parts: bytes) -> bytes:
    digest = hashlib.blake2b(digest_size=_DIGEST)
    for part in parts:
        digest.update(part)
    return digest.digest()
