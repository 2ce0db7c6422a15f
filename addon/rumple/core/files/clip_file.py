# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes baked clips: points in PC2, which Blender's own Mesh Cache reads, and after them the manifest.

A sample contains the positions of the output mesh, then the attributes, packed as blocks of extra points. A block has
one point for each vertex or corner. A node tree unpacks them (blender/nodes/wrinkle_tree.py). After the last sample,
where readers of PC2 do not look, are the manifest, its length and checksum, and a mark. All is in one file because a
rename replaces one file in one step. So there is always a complete clip: the old or the new one. No bpy here.
"""
from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..mesh.frame_result import Attribute, FrameResult
from . import clip_folder, clip_manifest
from .clip_manifest import ClipFault, Manifest, stored_pose

_HEADER = struct.Struct("<12siiffi")  # signature, version, points, start, step, samples
HEADER_BYTES = _HEADER.size
_END = struct.Struct("<QI12s")  # bytes of the manifest, their CRC-32, mark
_MARK = b"RUMPLE CLIP\0"
_MOST_MANIFEST = 1 << 30  # bytes


@dataclass(frozen=True)
class Block:
    """A block of points and its attributes: one vector, or up to three floats."""

    domain: str
    attributes: tuple[Attribute, ...]


def blocks(attributes: tuple[Attribute, ...]) -> list[Block]:
    """The blocks after the positions, in order."""
    packed = [Block(a.domain, (a,)) for a in attributes if a.vector]
    for domain in ("POINT", "CORNER"):
        floats = [a for a in attributes if a.domain == domain and not a.vector]
        packed += [Block(domain, tuple(floats[i:i + 3])) for i in range(0, len(floats), 3)]
    return packed


def point_count(vertices: int, corners: int, attributes: tuple[Attribute, ...]) -> int:
    """How many points a sample has for a mesh with this number of vertices and corners."""
    return vertices + sum(vertices if block.domain == "POINT" else corners for block in blocks(attributes))


def points_of(result: FrameResult, attributes: tuple[Attribute, ...], before: np.ndarray | None = None) -> np.ndarray:
    """The points of a sample, (points, 3) float32. before: the points of the previous sample, so that angles stay
    continuous."""
    packed, done = blocks(attributes), len(result.positions)
    sizes = [len(result.attributes[block.attributes[0].name]) for block in packed]
    points = np.empty((done + sum(sizes), 3), np.float32)
    points[:done] = result.positions
    for block, size in zip(packed, sizes):
        there = points[done:done + size]
        if block.attributes[0].vector:
            there[:] = result.attributes[block.attributes[0].name]
        else:
            there[:, len(block.attributes):] = 0.0
            for column, attribute in enumerate(block.attributes):
                there[:, column] = result.attributes[attribute.name]
        done += size
    if before is not None:
        go_on(points, len(result.positions), attributes, before)
    return points


def go_on(points: np.ndarray, vertices: int, attributes: tuple[Attribute, ...], before: np.ndarray) -> None:
    """Make the angles in a sample's points continuous with the previous sample."""
    packed = blocks(attributes)
    of_corners = sum(block.domain == "CORNER" for block in packed)
    corners = (len(points) - vertices * (1 + len(packed) - of_corners)) // max(of_corners, 1)
    done = vertices
    for block in packed:
        there = slice(done, done + (vertices if block.domain == "POINT" else corners))
        for column, attribute in enumerate(block.attributes):
            if attribute.angle:
                which: Any = slice(None) if attribute.vector else column
                points[there, which] = _unwrapped(points[there, which], before[there, which])
        done = there.stop


def _unwrapped(angles: np.ndarray, before: np.ndarray) -> np.ndarray:
    """The same angles, within half a turn of the previous ones, because the cache interpolates them."""
    turns = np.round((before - angles) / (2.0 * np.pi))
    return angles + np.float32(2.0 * np.pi) * turns.astype(np.float32)


# ---------------------------------------------------------------- writing
def header(manifest: Manifest) -> bytes:
    """The first HEADER_BYTES of a clip."""
    return _HEADER.pack(b"POINTCACHE2\0", 1, manifest.points, float(manifest.start), 1.0 / manifest.samples,
                        manifest.sample_count)


def size_of(manifest: Manifest) -> int:
    """Bytes of header and samples."""
    return _HEADER.size + manifest.sample_count * manifest.points * 12


def checksum(manifest: Manifest) -> int:
    """One checksum over all checksums of a clip; never 0."""
    return zlib.crc32(np.array(manifest.checksums, "<u4").tobytes()) or 1


class SampleWriter:
    """Writes samples one after the other. The file appears at its path only with commit(). All methods raise
    ClipFault."""

    def __init__(self, clip: Path, manifest: Manifest) -> None:
        clip_folder.make(clip.parent, size_of(manifest))
        self.clip, self.manifest = clip, manifest
        self.temporary = self._temporary()
        self.file: BinaryIO | None = None
        self._do(self._open)

    def _temporary(self) -> Path:
        return clip_folder.temporary(self.clip)

    def _do(self, action: Any, *arguments: Any) -> None:
        try:
            action(*arguments)
        except OSError as error:
            raise ClipFault(clip_folder.in_words(error, self.clip.parent)) from error

    def _open(self) -> None:
        self.file = open(self.temporary, "wb")
        self.file.write(header(self.manifest))

    def add_points(self, points: np.ndarray) -> None:
        """Write one sample, (points, 3)."""
        if len(points) != self.manifest.points:
            raise ValueError(f"expected {self.manifest.points} points, got {len(points)}")
        data = np.ascontiguousarray(points, "<f4").data
        self._do(self.file.write, data)  # type: ignore[union-attr]
        self.manifest.checksums.append(zlib.crc32(data))

    def seal(self) -> None:
        """Do everything that can still fail because the disk is full."""
        self._do(self._seal)

    def _seal(self) -> None:
        assert self.file is not None
        text = self.manifest.to_json().encode("ascii")
        self.file.write(text + _END.pack(len(text), zlib.crc32(text), _MARK))
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()

    def commit(self) -> None:
        """Move the sealed file into place."""
        self._do(clip_folder.put, self.temporary, self.clip)

    def take_back(self) -> None:
        """Undo commit(), so that it can be done again."""
        self._do(clip_folder.put, self.clip, self.temporary)

    def discard(self) -> None:
        """Give up, and leave the former clip in place. Never raises: closing may fail because the disk is full."""
        for action in (self.file.close if self.file is not None else None, self.temporary.unlink):
            try:
                if action is not None:
                    action()
            except OSError:
                pass


class ClipWriter(SampleWriter):
    """Writes the frame results of a garment."""

    def __init__(self, clip: Path, manifest: Manifest, attributes: tuple[Attribute, ...]) -> None:
        super().__init__(clip, manifest)
        self.attributes = attributes
        self.before: np.ndarray | None = None  # points of the previous sample

    def add(self, result: FrameResult, coarse: np.ndarray) -> None:
        """Write one sample: a frame's result, and the coarse pose that it belongs to."""
        self.before = points_of(result, self.attributes, self.before)
        self.add_points(self.before)
        self.manifest.poses.append(stored_pose(coarse))


# ---------------------------------------------------------------- reading
def manifest_path(clip: Path) -> Path:
    """Where clips of format 3 have their manifest."""
    return clip.with_suffix(".json")


def read_manifest(clip: Path) -> Manifest | None:
    """The manifest of a clip; None if there is none. Raises ClipFault, also if the clip does not fit its manifest."""
    try:
        with open(clip, "rb") as file:
            head = file.read(_HEADER.size)
            size = file.seek(0, os.SEEK_END)
            text = _trailer(file, size)
        beside = manifest_path(clip)
        if text is None and beside.is_file():
            text = beside.read_bytes() if beside.stat().st_size < _MOST_MANIFEST else b""
    except OSError as error:
        raise ClipFault(f"it cannot be read ({clip_folder.in_words(error, clip.parent)})") from error
    if len(head) < _HEADER.size or head[:12] != b"POINTCACHE2\0":
        raise ClipFault("it is no PC2 file")
    if text is None:
        _mark, _version, points, _start, _step, samples = _HEADER.unpack(head)
        if size != _HEADER.size + points * samples * 12:
            raise ClipFault("it was cut short or written over")
        return None
    manifest = clip_manifest.read(text)
    if head != header(manifest):
        raise ClipFault("its header is damaged")
    end = size_of(manifest) + (len(text) + _END.size if manifest.format >= 4 else 0)
    if size != end:
        raise ClipFault(f"it has {size} bytes and should have {end}: it was cut short or written over")
    return manifest


def _trailer(file: BinaryIO, size: int) -> bytes | None:
    """The text of the manifest after the samples; None if there is none. Raises ClipFault."""
    if size < _HEADER.size + _END.size:
        return None
    file.seek(size - _END.size)
    length, expected, mark = _END.unpack(file.read(_END.size))
    if mark != _MARK:
        return None
    if length > min(size - _HEADER.size - _END.size, _MOST_MANIFEST):
        raise ClipFault("its manifest is damaged")
    file.seek(size - _END.size - length)
    text = file.read(length)
    if zlib.crc32(text) != expected:
        raise ClipFault("its manifest is damaged")
    return text


def sample_is_whole(clip: Path, manifest: Manifest, sample: int) -> bool:
    """Whether the data of a sample has its checksum. Clips of format 3 have none: then True. Raises OSError."""
    if not manifest.checksums:
        return True
    length = manifest.points * 12
    with open(clip, "rb") as file:
        file.seek(_HEADER.size + sample * length)
        return zlib.crc32(file.read(length)) == manifest.checksums[sample]


def delete(clip: Path) -> None:
    """Remove a clip and the manifest file of format 3 beside it."""
    clip.unlink(missing_ok=True)
    manifest_path(clip).unlink(missing_ok=True)
