# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest of a baked clip: what it was baked from, and its checksums. It is stored in the clip's file.

Anybody may have written the file. So read() accepts only known entries of known types within bounds, and says what is
wrong. Never imports bpy.
"""
from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np

from ..base.vertices import sample_of

FORMAT = 4  # in the clip's file, with checksums. Format 3 was in a file beside the clip, without checksums
FORMAT_OF_SEAMS = 5  # the clip has seams: an older Rumple would verify it from its first frame, and get other bits
POSE_POINTS = 16  # coarse points kept for each sample, to notice that the animation changed
POSE_TOLERANCE = 1e-3  # share of the coarse mesh's extent. Other Blender versions and machines differ by far less
_LAST_FRAME = 1 << 20  # Blender's
_MOST_POINTS = (1 << 31) - 1  # in the header of a clip
_BOUNDS = dict(vertices=(1, _MOST_POINTS), points=(1, _MOST_POINTS), coarse_vertices=(1, _MOST_POINTS),
               start=(-_LAST_FRAME, _LAST_FRAME), end=(-_LAST_FRAME, _LAST_FRAME), samples=(1, 16),
               format=(1, FORMAT_OF_SEAMS), pre_roll=(0, _LAST_FRAME))


class ClipFault(Exception):
    """What is wrong with a clip or its folder. The message is the rest of a sentence that begins with an object."""


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
    file: str = ""  # the blend file that it was baked from, without its folder
    checksums: list[int] = field(default_factory=list)  # CRC-32 of each sample; none before format 4
    curves: int = 0  # CRC-32 over the checksums of the clip of its path curves; 0: it has none
    source: str = ""  # digest of the saved files that it was baked from; empty: from a window
    pre_roll: int = 0  # frames that were solved before each seam; 0: the clip was baked in one piece
    seams: list[int] = field(default_factory=list)  # frames at which solving began anew, ascending

    @property
    def sample_count(self) -> int:
        return (self.end - self.start) * self.samples + 1

    def sample_frame(self, sample: int) -> tuple[int, float]:
        """Frame and subframe of a sample."""
        frame, part = divmod(sample, self.samples)
        return self.start + frame, part / self.samples

    def sample_of(self, frame: float) -> int | None:
        """The sample exactly at a frame; None between samples and outside the clip."""
        place = (frame - self.start) * self.samples
        sample = round(place)
        return sample if abs(place - sample) < 1e-3 and 0 <= sample < self.sample_count else None

    def samples_around(self, frame: float) -> list[int]:
        """The samples that are shown at a frame: one, or the two around it."""
        place = min(max((frame - self.start) * self.samples, 0.0), self.sample_count - 1.0)
        return sorted({math.floor(place + 1e-3), math.ceil(place - 1e-3)})

    def pose_differs(self, sample: int, positions: np.ndarray) -> bool:
        """Whether the pose of the coarse mesh differs from the one that was baked."""
        baked, now = np.array(self.poses[sample], np.float32), pose_points(positions)
        extent = float(np.ptp(positions, axis=0).max()) if len(positions) else 0.0
        return baked.shape != now.shape or not np.allclose(baked, now, rtol=0.0, atol=POSE_TOLERANCE * extent)

    def to_json(self) -> str:
        data = asdict(self)
        if not self.seams:
            del data["pre_roll"], data["seams"]
        return json.dumps(data)


def pose_points(positions: np.ndarray) -> np.ndarray:
    """A few points spread over the mesh, flat."""
    return sample_of(positions, POSE_POINTS).ravel()


def stored_pose(positions: np.ndarray) -> list[float]:
    """An entry of `poses`."""
    return [round(float(x), 6) for x in pose_points(positions)]


def is_pose(value: Any, coarse_vertices: int) -> bool:
    """Whether it can be an entry of `poses`."""
    numbers = 3 * min(POSE_POINTS, coarse_vertices)
    return isinstance(value, list) and len(value) == numbers and all(_is_number(x) for x in value)


# ---------------------------------------------------------------- reading
def read(text: str | bytes) -> Manifest:
    """Read the text that to_json(), or an older Rumple, wrote. Raises ClipFault."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ClipFault("its manifest is damaged") from error
    if not isinstance(data, dict):
        raise ClipFault("its manifest is damaged")
    if _is_whole(data.get("format")) and data["format"] > FORMAT_OF_SEAMS:
        raise ClipFault("it was baked by a newer Rumple")
    known = {f.name: f for f in fields(Manifest)}
    missing = {"object", "vertices", "points", "coarse_vertices", "start", "end", "samples", "inputs"} - data.keys()
    if missing or data.keys() - known.keys():
        raise ClipFault(f"its manifest is not one: {', '.join(sorted(missing or data.keys() - known.keys()))[:80]}")
    for name in ("object", "inputs", "file", "source"):
        if not isinstance(data.get(name, ""), str):
            raise ClipFault(f"its manifest is not one: {name} is no text")
    for name, (low, high) in _BOUNDS.items():
        if not (_is_whole(data.get(name, low)) and low <= data.get(name, low) <= high):
            raise ClipFault(f"its manifest is not one: {name} is no number from {low} to {high}")
    if data["end"] < data["start"] or data["points"] < data["vertices"]:
        raise ClipFault("its manifest is not one: it ends before it starts")
    data.setdefault("format", 3)
    manifest = Manifest(**data)
    _check_samples(manifest)
    _check_seams(manifest)
    return manifest


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _check_samples(manifest: Manifest) -> None:
    """Check that there is one pose and one checksum for each sample."""
    checksums = manifest.format >= 4
    if not isinstance(manifest.poses, list) or len(manifest.poses) != manifest.sample_count:
        raise ClipFault("its manifest is not one: it does not have a pose for each sample")
    if not all(is_pose(pose, manifest.coarse_vertices) for pose in manifest.poses):
        raise ClipFault("its manifest is not one: a pose is damaged")
    if not isinstance(manifest.checksums, list) or len(manifest.checksums) != manifest.sample_count * checksums:
        raise ClipFault("its manifest is not one: it does not have a checksum for each sample")
    if not all(_is_whole(value) and 0 <= value < 1 << 32 for value in (*manifest.checksums, manifest.curves)):
        raise ClipFault("its manifest is not one: a checksum is damaged")


def _check_seams(manifest: Manifest) -> None:
    """Check that there are no seams and no pre-roll; or seams in ascending order, with a pre-roll."""
    seams = manifest.seams
    if not isinstance(seams, list) or not all(map(_is_whole, seams)) or bool(seams) != (manifest.pre_roll > 0) or (
            bool(seams) != (manifest.format >= FORMAT_OF_SEAMS)):
        raise ClipFault("its manifest is not one: its seams are damaged")
    there = [manifest.start, *seams, manifest.end + 1]
    if any(after <= before for before, after in zip(there, there[1:])):
        raise ClipFault("its manifest is not one: its seams are not in order")


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e30  # not NaN either
