# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that can be interrupted at any time and resumed later. No bpy here.

Each worker has two files beside the clip. One has the samples so far, in the format of the clip. The other is a
journal: its first line identifies the bake, then each sample has a line with its checksum and its pose. Where a frame
depends on the one before it, a third file has the solver's state after one of the samples (checkpoint.py). A worker
that resumes looks at all such files of the clip, and copies the largest number of samples with correct checksums. The
clip itself appears by one rename.
"""
from __future__ import annotations

import json
import os
import zlib
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import BinaryIO, Iterator, TextIO

import numpy as np

from ..mesh.frame_result import Attribute, FrameResult
from . import clip_file, clip_folder, clip_manifest
from .checkpoint import Checkpoint
from .clip_file import ClipWriter
from .clip_manifest import ClipFault, Manifest

_SAMPLES, _JOURNAL, _STATE = ".partial", ".journal", ".state"


@dataclass
class _Kept:
    """The samples of an interrupted bake."""

    file: Path
    checksums: list[int] = field(default_factory=list)
    poses: list[list[float]] = field(default_factory=list)


def _identity(manifest: Manifest, made_by: str) -> str:
    """Text that is equal for two bakes if one may resume the other."""
    return json.dumps([made_by, {**asdict(manifest), "poses": [], "checksums": []}])


def _files(clip: Path) -> list[Path]:
    """The sample files of all interrupted bakes of a clip; sorted, so that the order does not depend on the disk."""
    start = f".{clip.name}."
    return sorted(path for path in clip.parent.iterdir()
                  if path.name.startswith(start) and path.name.endswith(_SAMPLES))


def _beside(file: Path, suffix: str) -> Path:
    """The path of another file of the same bake. file: its samples."""
    return file.with_name(file.name.removesuffix(_SAMPLES) + suffix)


def _read(file: Path, manifest: Manifest, made_by: str) -> _Kept | None:
    """None if it belongs to another bake. Reads until the first incomplete line. Raises OSError."""
    kept = _Kept(file)
    with open(_beside(file, _JOURNAL), encoding="ascii", errors="replace") as journal:
        if journal.readline() != _identity(manifest, made_by) + "\n":
            return None
        for line in journal:
            try:
                checksum, pose = json.loads(line)
                good = line.endswith("\n") and clip_manifest.is_pose(pose, manifest.coarse_vertices)
                kept.checksums.append(int(checksum))
            except (ValueError, TypeError, OverflowError):  # of an infinite number
                break
            if not good or len(kept.checksums) > manifest.sample_count:
                kept.checksums.pop()
                break
            kept.poses.append(pose)
    return kept


def remove_others(clip: Path, but: Path | None = None) -> None:
    """Remove the files of interrupted bakes of a clip. Never raises."""
    try:
        found = [file for file in _files(clip) if file != but]
    except OSError:
        return
    for file in found:
        for path in (file, _beside(file, _JOURNAL), _beside(file, _STATE)):
            try:
                path.unlink(missing_ok=True)
            except OSError:
                pass


class PartialWriter(ClipWriter):
    """A ClipWriter that can resume. The samples that exist already, `kept`, are compared as they are given again, or
    passed over.

    Only the holder of the clip's lock makes one. resume: look for kept samples. made_by: a name of the program version;
    bakes with the same name have the same bits.
    """

    def __init__(self, clip: Path, manifest: Manifest, attributes: tuple[Attribute, ...], resume: bool,
                 made_by: str) -> None:
        self.made_by, self.resume = made_by, resume
        self.done = 0  # samples that are verified or new
        self.checkpoint: Checkpoint | None = None  # the state after one of the kept samples
        self.journal: TextIO | None = None
        try:
            super().__init__(clip, manifest, attributes)
        except ClipFault:
            if hasattr(self, "temporary"):  # the copied samples filled the disk
                self.discard()
            raise

    @property
    def kept(self) -> int:
        """How many samples are in the file."""
        return len(self.manifest.checksums)

    def _temporary(self) -> Path:
        return clip_folder.temporary(self.clip, _SAMPLES)

    def _open(self) -> None:
        found = list(self._found()) if self.resume else []
        super()._open()
        assert self.file is not None
        self.journal = open(_beside(self.temporary, _JOURNAL), "w", encoding="ascii")
        self.journal.write(_identity(self.manifest, self.made_by) + "\n")
        if found:
            longest = max(found, key=lambda kept: len(kept.checksums))
            self._copy(longest)
            state = Checkpoint.read(_beside(longest.file, _STATE), _identity(self.manifest, self.made_by))
            if state is not None and state.sample < self.kept:
                self.checkpoint = state
                self.save(state)
        remove_others(self.clip, self.temporary)

    def _found(self) -> Iterator[_Kept]:
        for file in _files(self.clip):
            try:
                kept = _read(file, self.manifest, self.made_by)
            except OSError:
                continue
            if kept is not None:
                yield kept

    def _copy(self, kept: _Kept) -> None:
        """Copy the samples with correct checksums."""
        with open(kept.file, "rb") as file:
            if file.read(clip_file.HEADER_BYTES) != clip_file.header(self.manifest):
                return
            for checksum, pose in zip(kept.checksums, kept.poses):
                data = file.read(self.manifest.points * 12)
                if len(data) < self.manifest.points * 12 or zlib.crc32(data) != checksum:
                    return
                self._append(data, checksum, pose)

    def _append(self, data: bytes | memoryview, checksum: int, pose: list[float]) -> None:
        assert self.file is not None and self.journal is not None
        self.file.write(data)
        self.file.flush()
        self.manifest.checksums.append(checksum)
        self.manifest.poses.append(pose)
        self.journal.write(json.dumps([checksum, pose]) + "\n")
        self.journal.flush()

    def save(self, checkpoint: Checkpoint) -> None:
        """Write a checkpoint, which replaces the former one. Never raises: if it cannot be written, it is left out."""
        assert self.file is not None and self.journal is not None
        path = clip_folder.temporary(self.clip)
        try:
            for written in (self.file.fileno(), self.journal.fileno()):
                os.fsync(written)  # a checkpoint is useless if its samples are not on the disk
            with open(path, "wb") as state:
                state.write(checkpoint.to_bytes(_identity(self.manifest, self.made_by)))
                state.flush()
                os.fsync(state.fileno())
            clip_folder.put(path, _beside(self.temporary, _STATE))
        except (OSError, ValueError):  # ValueError: the file is closed
            clip_folder.discard(path)

    def pass_over(self, samples: int) -> None:
        """Accept the first `samples` kept samples without a comparison. The next sample follows them."""
        assert self.file is not None
        self.done = samples
        self.before = points_in(self.temporary, self.manifest, samples - 1) if samples else None

    def add(self, result: FrameResult, coarse: np.ndarray) -> None:
        """Like ClipWriter.add(). The first sample that differs from its kept one, and all later ones, are written
        anew."""
        self.before = clip_file.points_of(result, self.attributes, self.before)
        data = np.ascontiguousarray(self.before, "<f4").data
        pose, checksum = clip_manifest.stored_pose(coarse), zlib.crc32(data)
        if self.done < self.kept and (checksum, pose) != (self.manifest.checksums[self.done],
                                                          self.manifest.poses[self.done]):
            self.cut(self.done)
        if self.done == self.kept:
            self._do(self._append, data, checksum, pose)
        self.done += 1

    def cut(self, samples: int) -> None:
        """Keep only the first `samples` samples."""
        self._do(self._cut, samples)

    def _cut(self, samples: int) -> None:
        assert self.file is not None and self.journal is not None
        del self.manifest.checksums[samples:], self.manifest.poses[samples:]
        self.file.seek(clip_file.HEADER_BYTES + samples * self.manifest.points * 12)
        self.file.truncate()
        self.journal.seek(0)
        self.journal.truncate()
        self.journal.write(_identity(self.manifest, self.made_by) + "\n")
        for entry in zip(self.manifest.checksums, self.manifest.poses):
            self.journal.write(json.dumps(entry) + "\n")
        self.journal.flush()
        self.done = min(self.done, samples)

    def seal(self) -> None:
        super().seal()
        self._close_journal()

    def commit(self) -> None:
        super().commit()
        remove_others(self.clip)
        self._remove_beside()

    def keep(self) -> None:
        """Stop, and leave the files so that another worker can resume. Never raises."""
        self._close_journal()
        try:
            if self.file is not None:
                self.file.close()
        except OSError:
            pass

    def discard(self) -> None:
        super().discard()
        self._close_journal()
        self._remove_beside()

    def _close_journal(self) -> None:
        try:
            if self.journal is not None:
                self.journal.close()
        except OSError:
            pass

    def _remove_beside(self) -> None:
        for suffix in (_JOURNAL, _STATE):
            clip_folder.discard(_beside(self.temporary, suffix))


def points_in(clip: Path, manifest: Manifest, sample: int) -> np.ndarray:
    """(points, 3) float32 of a sample in a clip, or in the samples of an unfinished one. Raises ClipFault."""
    try:
        with open(clip, "rb") as file:
            _seek(file, manifest, sample)
            data = file.read(manifest.points * 12)
    except OSError as error:
        raise ClipFault(clip_folder.in_words(error, clip.parent)) from error
    if len(data) != manifest.points * 12:
        raise ClipFault("it was cut short")
    return np.frombuffer(data, "<f4").reshape(-1, 3)


def _seek(file: BinaryIO, manifest: Manifest, sample: int) -> None:
    file.seek(clip_file.HEADER_BYTES + sample * manifest.points * 12)
