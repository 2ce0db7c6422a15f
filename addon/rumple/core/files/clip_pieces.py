# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips that several workers bake in pieces, a range of frames each, which are then joined. No bpy here.

A piece is a file like a clip, with its own lock, journal and checkpoints. Its last frame is also the first frame of the
next piece: there both are compared. Within a piece, angles are not made continuous. Joining does this.
"""
from __future__ import annotations

import re
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..mesh.frame_result import Attribute, FrameResult
from . import clip_file, clip_folder, clip_manifest, clip_partial
from .clip_file import SampleWriter
from .clip_manifest import ClipFault, Manifest

MOST = 1000  # pieces
_NAME = re.compile(r".+\.piece-\d+-of-\d+")


@dataclass(frozen=True)
class Piece:
    """One of `count` pieces of the frames from start to end, numbered from 1."""

    number: int
    count: int
    start: int
    end: int

    @property
    def first(self) -> int:
        return self._bound(self.number - 1)

    @property
    def last(self) -> int:
        """Its last frame, which is the first frame of the next piece."""
        return self._bound(self.number)

    def _bound(self, number: int) -> int:
        return self.start + (self.end - self.start) * number // self.count

    def path(self, clip: Path) -> Path:
        return clip.with_name(f"{clip.stem}.piece-{self.number}-of-{self.count}")


def pieces_of(start: int, end: int, count: int) -> list[Piece]:
    """All pieces, in order. Raises ClipFault if there are too few frames."""
    if not 1 <= count <= min(MOST, end - start):
        raise ClipFault(f"its frames {start} to {end} cannot be cut into {count} pieces, at most "
                        f"{max(min(MOST, end - start), 0)}: give fewer")
    return [Piece(number, count, start, end) for number in range(1, count + 1)]


class PieceWriter(clip_partial.PartialWriter):
    """Writes a piece. The angles of a sample do not depend on the previous sample."""

    def add(self, result: FrameResult, coarse: np.ndarray) -> None:
        self.before = None
        super().add(result, coarse)


@dataclass(frozen=True)
class Seam:
    """The difference of two pieces in their common frame."""

    number: int  # of the second piece
    frame: int
    farthest: float  # largest distance of corresponding shown points, object units
    same: bool  # whether both are equal bit for bit, attributes too


def _sample(file: Path, manifest: Manifest, sample: int) -> np.ndarray:
    points = clip_partial.points_in(file, manifest, sample)
    if zlib.crc32(points.tobytes()) != manifest.checksums[sample]:
        raise ClipFault(f"{file.name} is damaged: bake this piece again")
    return points


def seams(pieces: list[tuple[Path, Manifest]]) -> list[Seam]:
    """All seams, in order. Raises ClipFault."""
    found = []
    for number, ((former, one), (later, two)) in enumerate(zip(pieces, pieces[1:]), 2):
        if (one.vertices, one.points) != (two.vertices, two.points):
            raise ClipFault(f"piece {number} has another number of points than piece {number - 1}: bake both again")
        before, after = _sample(former, one, one.sample_count - 1), _sample(later, two, 0)
        apart = np.linalg.norm(after[:two.vertices].astype(np.float64) - before[:two.vertices], axis=1)
        found.append(Seam(number, two.start, float(apart.max()), before.tobytes() == after.tobytes()))
    return found


def join(clip: Path, pieces: list[tuple[Path, Manifest]], attributes: tuple[Attribute, ...], source: str,
         pre_roll: int) -> Manifest:
    """Join pieces into the clip, which appears by one rename. pre_roll: frames; 0: each frame is independent. Raises
    ClipFault."""
    first, last = pieces[0][1], pieces[-1][1]
    manifest = replace(first, end=last.end, poses=[], checksums=[], source=source)
    if pre_roll:
        manifest = replace(manifest, pre_roll=pre_roll, seams=[about.start for _, about in pieces[1:]],
                           format=clip_manifest.FORMAT_OF_SEAMS)
    writer = SampleWriter(clip, manifest)
    try:
        before: np.ndarray | None = None
        for file, about in pieces:
            for sample in range(about.sample_count - (about is not last)):
                points = _sample(file, about, sample).copy()
                if before is not None:
                    clip_file.go_on(points, manifest.vertices, attributes, before)
                writer.add_points(points)
                manifest.poses.append(about.poses[sample])
                before = points
        writer.seal()
        writer.commit()
    except BaseException:
        writer.discard()
        raise
    return manifest


def remove(clip: Path) -> None:
    """Remove all pieces of a clip that nobody bakes. Never raises."""
    try:
        found = [path for path in clip.parent.iterdir()
                 if path.name.startswith(f"{clip.stem}.") and _NAME.fullmatch(path.name)]
        for path in found:
            if not path.with_name(f".{path.name}.lock").exists():
                clip_folder.discard(path)
    except OSError:
        pass
