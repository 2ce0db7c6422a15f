# SPDX-License-Identifier: GPL-3.0-or-later
"""A baked clip on disk: points in PC2, which Blender's own Mesh Cache reads, and a manifest beside it.

Each sample: the positions of the output mesh, then attributes packed as extra points, block after block, a point for
each vertex or corner. A node tree unpacks them (blender/nodes/wrinkle_tree.py).
Both are written whole or not at all: into a temporary file in the same folder, then moved into place.
No bpy here.
"""
from __future__ import annotations

import json
import os
import struct
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Iterable

import numpy as np

from .engine import Attribute, FrameResult

FORMAT = 3
POSE_POINTS = 16  # coarse points kept for each sample, to notice that the animation changed
POSE_TOLERANCE = 1e-3  # of the coarse mesh's extent: other Blenders and machines differ by far less


@dataclass
class Manifest:
    """What a clip was baked from."""

    object: str
    vertices: int  # of the shown mesh
    points: int  # of the clip, see point_count()
    coarse_vertices: int
    start: int
    end: int
    samples: int  # for each frame
    inputs: str  # fingerprint of settings, paint and meshes
    poses: list[list[float]] = field(default_factory=list)  # for each sample, POSE_POINTS coarse points
    format: int = FORMAT

    @property
    def sample_count(self) -> int:
        return (self.end - self.start) * self.samples + 1

    def sample_frame(self, sample: int) -> tuple[int, float]:
        """Frame and subframe of a sample."""
        frame, part = divmod(sample, self.samples)
        return self.start + frame, part / self.samples

    def sample_of(self, frame: float) -> int | None:
        """The sample that stands exactly at a frame; None between samples and outside the clip."""
        place = (frame - self.start) * self.samples
        sample = round(place)
        return sample if abs(place - sample) < 1e-3 and 0 <= sample < self.sample_count else None

    def pose_differs(self, sample: int, positions: np.ndarray) -> bool:
        """Whether the coarse mesh stands elsewhere than when the sample was baked."""
        baked, now = np.array(self.poses[sample], np.float32), pose_points(positions)
        extent = float(np.ptp(positions, axis=0).max()) if len(positions) else 0.0
        return baked.shape != now.shape or not np.allclose(baked, now, rtol=0.0, atol=POSE_TOLERANCE * extent)


@dataclass(frozen=True)
class Block:
    """Attributes that share a block of points: one vector, or up to three floats."""

    domain: str
    attributes: tuple[Attribute, ...]


def blocks(attributes: tuple[Attribute, ...]) -> list[Block]:
    """The blocks behind the positions, in order."""
    packed = [Block(a.domain, (a,)) for a in attributes if a.vector]
    for domain in ("POINT", "CORNER"):
        floats = [a for a in attributes if a.domain == domain and not a.vector]
        packed += [Block(domain, tuple(floats[i:i + 3])) for i in range(0, len(floats), 3)]
    return packed


def point_count(vertices: int, corners: int, attributes: tuple[Attribute, ...]) -> int:
    """Points of a sample of a mesh with so many vertices and corners."""
    return vertices + sum(vertices if block.domain == "POINT" else corners for block in blocks(attributes))


def points_of(result: FrameResult, attributes: tuple[Attribute, ...], before: np.ndarray | None = None) -> np.ndarray:
    """The points of a sample, (points, 3) float32. before: those of the sample before it, for angles to go on from."""
    parts, done = [result.positions], len(result.positions)
    for block in blocks(attributes):
        values = [result.attributes[a.name] for a in block.attributes]
        if not block.attributes[0].vector:
            values = [np.stack(values + [np.zeros_like(values[0])] * (3 - len(values)), 1)]
        part = np.array(values[0], np.float32)
        for column, attribute in enumerate(block.attributes):
            if attribute.angle and before is not None:
                which: Any = slice(None) if attribute.vector else column
                part[:, which] = _unwrapped(part[:, which], before[done:done + len(part), which])
        parts.append(part)
        done += len(part)
    return np.concatenate(parts)


def _unwrapped(angles: np.ndarray, before: np.ndarray) -> np.ndarray:
    """The same angles within half a turn of those before: the cache interpolates them."""
    turns = np.round((before - angles) / (2.0 * np.pi))
    return angles + np.float32(2.0 * np.pi) * turns.astype(np.float32)


def pose_points(positions: np.ndarray) -> np.ndarray:
    """A few points spread over the mesh, flat."""
    which = np.linspace(0, len(positions) - 1, min(POSE_POINTS, len(positions))).astype(np.int64)
    return positions[which].ravel()


def manifest_path(clip: Path) -> Path:
    return clip.with_suffix(".json")


def read_manifest(clip: Path) -> Manifest | None:
    """The manifest of a clip; None where there is none that can be read."""
    try:
        return Manifest(**json.loads(manifest_path(clip).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def is_whole(clip: Path, manifest: Manifest) -> bool:
    """Whether the clip has the size that the manifest promises."""
    try:
        return clip.stat().st_size == _HEADER.size + manifest.sample_count * manifest.points * 12
    except OSError:
        return False


_HEADER = struct.Struct("<12siiffi")  # signature, version, points, start, step, samples


def _header(manifest: Manifest, points: int) -> bytes:
    return _HEADER.pack(b"POINTCACHE2\0", 1, points, float(manifest.start), 1.0 / manifest.samples,
                        manifest.sample_count)


def _temporary(clip: Path) -> Path:
    return clip.with_name(f".{clip.name}.{os.getpid()}.part")


def write_points(clip: Path, manifest: Manifest, points: int, samples: Iterable[np.ndarray]) -> None:
    """Another clip with the frames of a manifest, whole or not at all. samples: (points, 3) each."""
    temporary = _temporary(clip)
    with open(temporary, "wb") as file:
        file.write(_header(manifest, points))
        for rows in samples:
            file.write(np.ascontiguousarray(rows, "<f4").tobytes())
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, clip)


class ClipWriter:
    """Writes samples one after the other; nothing stands at the path before finish()."""

    def __init__(self, clip: Path, manifest: Manifest, attributes: tuple[Attribute, ...]) -> None:
        clip.parent.mkdir(parents=True, exist_ok=True)
        self.clip, self.manifest, self.attributes = clip, manifest, attributes
        self.before: np.ndarray | None = None  # points of the sample before
        self.temporary = _temporary(clip)
        self.file = open(self.temporary, "wb")
        self.file.write(_header(manifest, manifest.points))

    def add(self, result: FrameResult, coarse: np.ndarray) -> None:
        """One sample: what is shown, and the coarse pose it belongs to."""
        self.before = points_of(result, self.attributes, self.before)
        if len(self.before) != self.manifest.points:
            raise ValueError(f"expected {self.manifest.points} points, got {len(self.before)}")
        self.file.write(np.ascontiguousarray(self.before, "<f4").tobytes())
        self.manifest.poses.append([round(float(x), 6) for x in pose_points(coarse)])

    def finish(self) -> None:
        """Move clip and manifest into place."""
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()
        text = json.dumps(asdict(self.manifest))
        beside = manifest_path(self.temporary)
        beside.write_text(text, encoding="utf-8")
        os.replace(self.temporary, self.clip)
        os.replace(beside, manifest_path(self.clip))

    def discard(self) -> None:
        """Leave what stood there before."""
        self.file.close()
        self.temporary.unlink(missing_ok=True)


def delete(clip: Path) -> None:
    """Remove a clip and its manifest."""
    clip.unlink(missing_ok=True)
    manifest_path(clip).unlink(missing_ok=True)
