# SPDX-License-Identifier: GPL-3.0-or-later
"""A baked clip on disk: points in PC2, which Blender's own Mesh Cache reads, and a manifest beside it.

A clip has POINTS_PER_VERTEX points for each vertex of the fine mesh, block after block: its positions, then what
shaders read, as if they were positions too. The node tree takes them apart (node_tree.py).
Both are written whole or not at all: into a temporary file in the same folder, then moved into place.
No bpy here.
"""
from __future__ import annotations

import json
import os
import struct
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from ..core.engine import Picture

FORMAT = 2
POINTS_PER_VERTEX = 4  # position; (smallest, largest stretch, 0); direction of compression; offset
POSE_POINTS = 16  # coarse points kept for each sample, to notice that the animation changed
POSE_TOLERANCE = 1e-3  # of the coarse mesh's extent: other Blenders and machines differ by far less


@dataclass
class Manifest:
    """What a clip was baked from."""

    object: str
    vertices: int  # of the fine mesh
    coarse_vertices: int
    start: int
    end: int
    samples: int  # for each frame
    inputs: str  # fingerprint of settings, paint and meshes
    poses: list[list[float]] = field(default_factory=list)  # for each sample, POSE_POINTS coarse points
    format: int = FORMAT

    @property
    def points(self) -> int:
        return self.vertices * POINTS_PER_VERTEX

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


def points_of(picture: Picture) -> np.ndarray:
    """The points of a sample, (POINTS_PER_VERTEX * n, 3) float32."""
    stretch = np.stack([picture.stretch_min, picture.stretch_max, np.zeros_like(picture.stretch_min)], 1)
    return np.concatenate([picture.positions, stretch, picture.stretch_direction, picture.offset])


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


class ClipWriter:
    """Writes samples one after the other; nothing stands at the path before finish()."""

    def __init__(self, clip: Path, manifest: Manifest) -> None:
        clip.parent.mkdir(parents=True, exist_ok=True)
        self.clip, self.manifest = clip, manifest
        self.temporary = clip.with_name(f".{clip.name}.{os.getpid()}.part")
        self.file = open(self.temporary, "wb")
        self.file.write(_HEADER.pack(b"POINTCACHE2\0", 1, manifest.points, float(manifest.start),
                                     1.0 / manifest.samples, manifest.sample_count))

    def add(self, picture: Picture, coarse: np.ndarray) -> None:
        """One sample: what is shown, and the coarse pose it belongs to."""
        if picture.positions.shape != (self.manifest.vertices, 3):
            raise ValueError(f"expected {self.manifest.vertices} vertices, got {len(picture.positions)}")
        self.file.write(np.ascontiguousarray(points_of(picture), "<f4").tobytes())
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
