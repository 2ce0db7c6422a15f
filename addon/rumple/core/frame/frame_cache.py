# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame cache: keeps solved frames in memory, so that a frame's result does not depend on the order of frames.

A frame is *final* if it was solved from a final frame before it, if it is the first frame, or if it needs no frame
before it. A frame solved after a jump is *provisional*. It is replayed until it is reached over more frames than
before. Then it is solved once more. When the frame before it is final, it is solved for the last time.
"""
from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field
from typing import Any, Callable, Hashable, Iterable, NamedTuple, Protocol

from ..mesh.frame_result import FrameResult

MOST_TIMELINES = 4  # kept for one object
MOST_WAITING, MOST_WAITING_BYTES, MOST_WAITING_SECONDS = 1000, 256 * 2**20, 5.0  # of frames in a row


@dataclass(eq=False)
class CachedFrame:
    """One frame: digests of its input, whether it is final, and the solver's state.

    A waiting frame is not solved yet. It is solved when its state or its report is needed, and gives the same bits.
    """

    input_digest: bytes  # of the settings and the deformed base positions (and matrix, if the solve reads it)
    settings_digest: bytes  # of the settings alone
    final: bool
    nbytes: int  # memory of the state
    _solved: tuple[Any, Any] = (None, None)  # state, report
    solve_seconds: float = 0.0  # that its solve took, or will probably take
    _before: "CachedFrame | None" = None  # while it waits: the frame before it ...
    # ... and a function: state of the frame before -> state, report
    _solve: Callable[[Any], tuple[Any, Any]] | None = None
    chain: bytes = b""  # of a final frame: digest of the inputs of this and all frames before it
    run: int = 0  # number of frames that it was reached over, see put()
    from_disk: bool = False
    # key: whether the result is of the mesh of viewports
    pictures: dict[bool, FrameResult] = field(default_factory=dict)
    was_replayed: bool = False

    @classmethod
    def of(cls, state: Any, input_digest: bytes, settings_digest: bytes, final: bool, report: Any,
           chain: bytes = b"", solve_seconds: float = 0.0) -> "CachedFrame":
        """A solved frame."""
        return cls(input_digest, settings_digest, final, state.nbytes, (state, report), solve_seconds, chain=chain)

    @classmethod
    def waiting(cls, before: "CachedFrame", input_digest: bytes, settings_digest: bytes, final: bool,
                solve: Callable[[Any], tuple[Any, Any]], chain: bytes = b"") -> "CachedFrame":
        """A waiting frame. Its state is assumed to need as much memory, and its solve as long, as those of the frame
        before it. If too many frames in a row wait, or for too long, the first of them is solved."""
        frame = cls(input_digest, settings_digest, final, before.nbytes, solve_seconds=before.solve_seconds,
                    _before=before, _solve=solve, chain=chain)
        row = frame._row()
        if (len(row) > MOST_WAITING or len(row) * frame.nbytes > MOST_WAITING_BYTES
                or frame.seconds_until_solved > MOST_WAITING_SECONDS):
            row[-1]._solve_now()
        return frame

    @property
    def history(self) -> "History":
        return History(self.input_digest, self.chain)

    @property
    def waits(self) -> bool:
        return self._solve is not None

    @property
    def seconds_until_solved(self) -> float:
        """How long it probably takes to solve this frame and the waiting frames before it."""
        return sum(frame.solve_seconds for frame in self._row())

    @property
    def state(self) -> Any:
        return self._state_and_report()[0]

    @property
    def report(self) -> Any:
        return self._state_and_report()[1]

    def _row(self) -> list["CachedFrame"]:
        """This frame and the waiting frames before it, the earliest one last."""
        row: list[CachedFrame] = []
        frame: CachedFrame | None = self
        while frame is not None and frame.waits:
            row.append(frame)
            frame = frame._before
        return row

    def _state_and_report(self) -> tuple[Any, Any]:
        for frame in reversed(self._row()):  # a loop, because Python does not allow a thousand nested calls
            frame._solve_now()
        return self._solved

    def _solve_now(self) -> None:
        """Solve this frame. The frame before it is already solved."""
        assert self._solve is not None and self._before is not None
        self._solved = self._solve(self._before._solved[0])
        self._solve = self._before = None


class History(NamedTuple):
    """What a final frame was solved from: its own inputs, and those of all frames before it."""

    input_digest: bytes
    chain: bytes

    @property
    def begins(self) -> bool:
        """Whether it needs no frame before it."""
        return self.chain == chain_of(self.input_digest, None)

    def goes_on_from(self, before: "History") -> bool:
        return self.chain == chain_of(self.input_digest, before)


def chain_of(input_digest: bytes, before: CachedFrame | History | None) -> bytes:
    """The chain of a frame after another one, or of a frame without one before it."""
    return hashlib.blake2b(input_digest + (b"" if before is None else before.chain), digest_size=16).digest()


class OnDisk(Protocol):
    """Frames of the current timeline that are stored on disk: kept_frames.py."""

    def read(self, frame: float, input_digest: bytes) -> CachedFrame | None:
        """The stored final frame with these inputs, or None."""

    def history(self, frame: float) -> History | None:
        """The history of the stored final frame, whatever its inputs are, or None."""


class FrameCache:
    """Entries by frame number (subframes included), within a limit of memory.

    Scenes with another first frame or frame rate have entries of their own, see follow(). limit_bytes: for all entries
    together. Above it, results are dropped first, then entries of other scenes, then the entries farthest from the
    newest one, provisional entries first. The entries that the next frame may need are always kept.
    """

    def __init__(self, limit_bytes: int = 512 * 2**20) -> None:
        self.limit_bytes = limit_bytes
        self._entries: dict[float, CachedFrame] = {}
        self.timeline: Hashable = None
        self._timelines: dict[Hashable, dict[float, CachedFrame]] = {None: self._entries}  # the most recent one is last
        self._bytes = self._picture_bytes = 0
        self._refused: set[tuple[Hashable, float]] = set()  # timeline, frame
        self.on_disk: OnDisk | None = None

    def follow(self, timeline: Hashable) -> None:
        """Use the entries of a timeline. Frames with the same number differ between timelines."""
        if timeline == self.timeline:
            return
        self._entries = self._timelines.pop(timeline, {})
        self._timelines[timeline] = self._entries
        self.timeline = timeline
        for other in list(self._timelines)[:-MOST_TIMELINES]:
            self._drop(other)

    def _drop(self, timeline: Hashable) -> None:
        self._forget(self._timelines.pop(timeline).values())

    def _forget(self, dropped: Iterable[CachedFrame]) -> None:
        for cached in dropped:
            self._bytes -= cached.nbytes
            self._picture_bytes -= sum(picture.nbytes for picture in cached.pictures.values())

    def get(self, frame: float) -> CachedFrame | None:
        """The entry of a frame, or None."""
        return self._entries.get(frame)

    def seconds_until_solved(self, frame: float) -> float:
        """How long it probably takes until the state of a frame is there; 0 without an entry."""
        cached = self._entries.get(frame)
        return 0.0 if cached is None else cached.seconds_until_solved

    def before(self, frame: float) -> CachedFrame | None:
        """The whole frame from which a frame is solved: the frame before it, or the one that a subframe follows.
        Refused frames are skipped, so that solving continues from the last good frame."""
        return self._entries.get(self._number_before(frame))

    def _number_before(self, frame: float) -> float:
        before = math.ceil(frame) - 1.0
        while (self.timeline, before) in self._refused:
            before -= 1.0
        return before

    def refuse(self, frame: float) -> None:
        """Mark a frame as impossible to solve, for example because a simulation explodes. put() removes the mark."""
        self._refused.add((self.timeline, frame))

    def find(self, frame: float, input_digest: bytes, final: bool, before: CachedFrame | None) -> CachedFrame | None:
        """The entry that may be replayed, from memory or disk. It must have the same inputs. If the frame would be
        final, the frames before it must have the same inputs too. Otherwise the entry must have been reached over at
        least as many frames."""
        def fits(cached: CachedFrame | None) -> bool:
            if cached is None or cached.input_digest != input_digest:
                return False
            if final:
                return cached.final and cached.chain == chain_of(input_digest, before)
            return cached.final or before is None or before.run < cached.run

        cached = self._entries.get(frame)
        if fits(cached) or self.on_disk is None:
            return cached if fits(cached) else None
        kept = self.on_disk.read(frame, input_digest)
        if kept is None or not fits(kept) or self._is_outdated(frame, kept.history, self.on_disk):
            return None
        kept.from_disk = True
        self.put(frame, kept)
        return kept

    def _is_outdated(self, frame: float, stored: History, on_disk: OnDisk) -> bool:
        """Whether a frame before a stored one is known, in memory or on disk, and is not what the stored one went on
        from: then it was solved later, after a change. Where none is known any more, because files were removed for
        example, nothing speaks against the stored one."""
        while not stored.begins:
            frame = self._number_before(frame)
            cached = self._entries.get(frame)
            if cached is not None and cached.final:
                return not stored.goes_on_from(cached.history)
            before = on_disk.history(frame)
            if before is None or not stored.goes_on_from(before):
                return before is not None
            stored = before
        return False

    def final_frames(self) -> list[tuple[Hashable, float, CachedFrame]]:
        """The solved final frames of all timelines: timeline, frame, entry."""
        return [item for item in self._all() if item[2].final and not item[2].waits]

    def _all(self) -> list[tuple[Hashable, float, CachedFrame]]:
        """The frames of all timelines."""
        return [(timeline, *item) for timeline, entries in list(self._timelines.items())
                for item in list(entries.items())]

    def put(self, frame: float, cached: CachedFrame) -> None:
        """Store a frame. If it replaces a different solution, the frames solved from it are no longer final. (No frame
        is solved from a subframe.)"""
        self._refused.discard((self.timeline, frame))
        old = self._entries.get(frame)
        if old is not None:
            self._forget([old])
            if frame == math.floor(frame):
                for later, other in self._entries.items():
                    if later > frame:
                        other.final = False
        if cached.final and not cached.from_disk and frame == math.floor(frame):
            self._drop_read_after(frame)
        before = self.before(frame)
        cached.run = 0 if before is None else before.run + 1
        self._entries[frame] = cached
        self._bytes += cached.nbytes
        self._evict(frame)

    def _drop_read_after(self, frame: float) -> None:
        """Drop later frames that were read from disk. When they are read again, they are compared with this one."""
        for later in [later for later, other in self._entries.items() if other.from_disk and later > frame]:
            self._forget([self._entries.pop(later)])

    def picture(self, cached: CachedFrame, in_viewport: bool, make: Callable[[], Any]) -> FrameResult:
        """The result of a replayed entry. It is kept from its second replay on, if memory allows. Not from the first,
        because a frame that is played and then baked or rendered is not needed again."""
        found = cached.pictures.get(in_viewport)
        if found is None:
            found = make()
            if cached.was_replayed and self._bytes + self._picture_bytes + found.nbytes <= self.limit_bytes:
                cached.pictures[in_viewport] = found
                self._picture_bytes += found.nbytes
        cached.was_replayed = True
        return found

    def clear(self) -> None:
        """Remove all frames of all timelines."""
        self._entries = {}
        self._timelines = {self.timeline: self._entries}
        self._bytes = self._picture_bytes = 0
        self._refused.clear()

    def take(self, former: "FrameCache", restored: Callable[[CachedFrame], CachedFrame]) -> None:
        """Move the solved frames of another cache here. restored: converts a frame for the owner of this cache."""
        for timeline, entries in former._timelines.items():
            self.follow(timeline)
            for frame, cached in sorted(entries.items()):
                if not cached.waits:
                    self.put(frame, restored(cached))
        self._refused |= former._refused
        former.clear()

    @property
    def bytes(self) -> int:
        """Memory of the stored states."""
        return self._bytes

    def frames(self) -> list[tuple[float, bool]]:
        """(frame, final) of every stored frame of this timeline, ascending. It works on a copy, because a render may
        store frames at the same time."""
        entries = list(self._entries.items())
        return [(frame, cached.final) for frame, cached in sorted(entries, key=lambda entry: entry[0])]

    def _evict(self, newest: float) -> None:
        """Drop entries above the limit. The whole frames around the newest one and the one before are kept, because the
        next frame, or a subframe for motion blur, is solved from one of them."""
        if self._bytes + self._picture_bytes > self.limit_bytes:
            for *_, cached in self._all():
                cached.pictures = {}
            self._picture_bytes = 0
        for other in list(self._timelines)[:-1]:
            if self._bytes > self.limit_bytes:
                self._drop(other)
        if self._bytes <= self.limit_bytes:
            return
        needed = newest, math.floor(newest) - 1, math.floor(newest), math.ceil(newest)
        order = sorted(self._entries, key=lambda f: (self._entries[f].final, -abs(f - newest)))
        for frame in order:
            if self._bytes <= self.limit_bytes or frame in needed:
                continue
            self._forget([self._entries.pop(frame)])
