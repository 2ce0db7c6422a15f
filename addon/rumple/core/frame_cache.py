# SPDX-License-Identifier: GPL-3.0-or-later
"""Solved frames kept in memory, so that the picture of a frame does not depend on how one got there.

A frame is *final* when it was solved from a final frame before it (or is the first frame, or needs no
frame before it). A frame solved after a jump is provisional: it is replayed as it is until the frame
before it becomes final, then it is solved once more and stays.
"""
from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, Hashable

import numpy as np

MOST_TIMELINES = 4  # kept of one object


@dataclass
class CachedFrame:
    """One solved frame: the solver's state, what it was solved for, and whether it is final."""

    state: Any
    inputs: bytes  # digest of the settings and the deformed base positions (and matrix, if the solve reads it)
    chosen: bytes  # digest of the settings alone
    final: bool
    report: Any


class FrameCache:
    """Entries by frame number (subframes included), within a limit of memory.

    Scenes with another first frame or frame rate have entries of their own, see follow(). limit_bytes: of all together;
    when exceeded, those of other scenes are dropped, then entries farthest from the newest, provisional ones first.
    """

    def __init__(self, limit_bytes: int = 512 * 2**20) -> None:
        self.limit_bytes = limit_bytes
        self._entries: dict[float, CachedFrame] = {}
        self._timeline: Hashable = None
        self._timelines: dict[Hashable, dict[float, CachedFrame]] = {None: self._entries}  # the last used last
        self._bytes = 0

    def follow(self, timeline: Hashable) -> None:
        """Go on with the entries of a timeline: what tells frames of one number apart."""
        if timeline == self._timeline:
            return
        self._entries = self._timelines.pop(timeline, {})
        self._timelines[timeline] = self._entries
        self._timeline = timeline
        for other in list(self._timelines)[:-MOST_TIMELINES]:
            self._drop(other)

    def _drop(self, timeline: Hashable) -> None:
        self._bytes -= sum(cached.state.nbytes for cached in self._timelines.pop(timeline).values())

    def get(self, frame: float) -> CachedFrame | None:
        """The entry of a frame, or None."""
        return self._entries.get(frame)

    def put(self, frame: float, cached: CachedFrame) -> None:
        """Store a frame. When it replaces another solution, whole frames after it are final no more."""
        old = self._entries.get(frame)
        if old is not None:
            self._bytes -= old.state.nbytes
            for later, other in self._entries.items():
                if later > frame:
                    other.final = False
        self._entries[frame] = cached
        self._bytes += cached.state.nbytes
        self._evict(frame)

    def clear(self) -> None:
        """Forget every frame, those of other timelines too."""
        self._entries = {}
        self._timelines = {self._timeline: self._entries}
        self._bytes = 0

    @property
    def bytes(self) -> int:
        """Memory that the stored states take."""
        return self._bytes

    def frames(self) -> list[tuple[float, bool]]:
        """(frame, final) of every stored frame of this timeline, ascending."""
        return [(frame, self._entries[frame].final) for frame in sorted(self._entries)]

    def _evict(self, newest: float) -> None:
        for other in list(self._timelines)[:-1]:
            if self._bytes > self.limit_bytes:
                self._drop(other)
        if self._bytes <= self.limit_bytes:
            return
        order = sorted(self._entries, key=lambda f: (self._entries[f].final, -abs(f - newest)))
        for frame in order:
            if self._bytes <= self.limit_bytes or frame == newest:
                continue
            self._bytes -= self._entries.pop(frame).state.nbytes


def digest_of(chosen: bytes, positions: np.ndarray, *more: np.ndarray | None) -> bytes:
    """What tells one frame's input from another. chosen: digest of the settings."""
    digest = hashlib.blake2b(chosen, digest_size=16)
    digest.update(positions.data)
    for number, values in enumerate(more):
        if values is not None:
            digest.update(bytes([number]))
            digest.update(np.ascontiguousarray(values).data)
    return digest.digest()
