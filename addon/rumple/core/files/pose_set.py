# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes data sets for machine learning: a garment in many poses, as blocks of arrays and a manifest. No bpy here.

    manifest.json       names, counts, units, what it was made from; written first, the same by every worker
    mesh.npz            the constant data: rest positions, faces, bones at rest
    block-00000.npz     256 poses each, the last one fewer; each appears by one rename

Random numbers depend only on the seed and the number of the pose (SHAKE-128). So they are the same on any machine, in
any order and with any number of workers.
"""
from __future__ import annotations

import hashlib
import json
import os
import zipfile
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import clip_folder
from .clip_manifest import ClipFault

BLOCK = 256  # poses of a file
FORMAT = 2
MANIFEST = "manifest.json"


def shares(seed: int, pose: int, count: int) -> np.ndarray:
    """Random numbers of a pose in [0, 1), (count,) float64."""
    stream = hashlib.shake_128(f"rumple poses {seed} {pose}".encode()).digest(8 * count)
    return (np.frombuffer(stream, "<u8") >> np.uint64(11)) * 2.0**-53


@dataclass
class BoneRange:
    """The range of angles of one bone, radians: Euler XYZ in its own space, relative to its rest pose. least, most: for
    each axis. source: for each axis where the range comes from: constraint, ik, clip, or none (it does not move)."""

    armature: str
    bone: str
    least: list[float]
    most: list[float]
    source: list[str]

    def angles(self, drawn: np.ndarray) -> list[float]:
        """The angles for random numbers. drawn: (3,) in [0, 1)."""
        return [low + share * (high - low) for low, high, share in zip(self.least, self.most, drawn.tolist())]


def widened(least: float, most: float, factor: float) -> tuple[float, float]:
    """A range scaled about its middle, to at most half a turn to each side."""
    middle, half = (least + most) / 2.0, min(factor * (most - least) / 2.0, np.pi)
    return middle - half, middle + half


@dataclass
class PoseSet:
    """The manifest. coarse, fine: numbers of vertices."""

    object: str
    source: str  # digest of the blend file and all files that it reads
    made_by: str
    seed: int
    count: int
    kind: str  # random or clip
    frames: list[int]  # first and last frame of the clip; random poses are at the first one
    coarse: int
    fine: int
    metres_a_unit: float
    ranges: list[BoneRange] = field(default_factory=list)  # the bones of `pose`, in order
    widen: float = 1.0

    def text(self) -> str:
        arrays = {"number": ["poses"], "frame": ["poses"], "pose": ["poses", len(self.ranges), 4, 4],
                  "coarse": ["poses", self.coarse, 3], "fine": ["poses", self.fine, 3]}
        return json.dumps(dict(
            format=FORMAT, **{**asdict(self), "ranges": [asdict(one) for one in self.ranges]}, block=BLOCK,
            blocks=[self.block_name(number) for number in range(self.blocks)], arrays=arrays,
            numbers={name: array.dtype.name for name, array in empty_block(self, 0).items()},
            space="of the object; z up. pose: from rest-pose bone space to object space, column vectors",
            history="none: each pose is solved by itself, from the canonical start, as a still picture"),
            indent=1) + "\n"

    @property
    def blocks(self) -> int:
        return -(-self.count // BLOCK)

    def block_name(self, number: int) -> str:
        return f"block-{number:05d}.npz"

    def poses_of(self, block: int) -> range:
        return range(block * BLOCK, min((block + 1) * BLOCK, self.count))

    @property
    def bytes(self) -> int:
        """The approximate size of all files."""
        return self.count * (12 * (self.coarse + self.fine) + 64 * len(self.ranges) + 16)


# ---------------------------------------------------------------- the folder
def begin(folder: Path, wanted: PoseSet, mesh: dict[str, np.ndarray], resume: bool) -> None:
    """Write the manifest and the mesh, unless they exist. Raises ClipFault."""
    clip_folder.make(folder, 0)
    path, text = folder / MANIFEST, wanted.text()
    try:
        found = path.read_text("utf-8") if path.exists() else None
        if found is not None and not resume:
            raise ClipFault(f"{folder} holds a set of poses: give --resume to go on with it, or choose another folder")
        if found is not None and found != text:
            raise ClipFault(f"{folder} holds another set of poses ({_first_difference(found, text)}): choose another "
                            "folder")
        missing = sum(not (folder / wanted.block_name(block)).exists() for block in range(wanted.blocks))
        clip_folder.make(folder, wanted.bytes * missing // max(wanted.blocks, 1))
        if found is None:
            write_arrays(folder / "mesh.npz", mesh)
            with clip_folder.written(path) as manifest:
                manifest.write_text(text, "utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ClipFault(clip_folder.in_words(error, folder)) from error


def _first_difference(found: str, wanted: str) -> str:
    """The first difference of two manifests, as text."""
    try:
        there, here = json.loads(found), json.loads(wanted)
        return next(f"{key} {str(there.get(key))[:40]}, not {str(value)[:40]}" for key, value in here.items()
                    if there.get(key) != value)
    except (ValueError, AttributeError, StopIteration):
        return f"its {MANIFEST} cannot be read"


def write_arrays(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """Write a file of arrays, by one rename. The same arrays give the same bytes. Raises ClipFault."""
    try:
        with clip_folder.written(path) as new, open(new, "wb") as file:
            np.savez(file, **arrays)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise ClipFault(clip_folder.in_words(error, path.parent)) from error


def read_block(folder: Path, wanted: PoseSet, block: int) -> dict[str, np.ndarray] | None:
    """The arrays of a block; None if it is missing or damaged."""
    path, poses = folder / wanted.block_name(block), wanted.poses_of(block)
    try:
        with zipfile.ZipFile(path) as opened:
            if opened.testzip() is not None:
                return None
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except Exception:  # zipfile, zlib and NumPy raise many different exceptions for damaged files
        return None
    shapes = {name: array.shape for name, array in arrays.items()}
    return arrays if shapes == {name: array.shape for name, array in empty_block(wanted, len(poses)).items()} else None


def empty_block(wanted: PoseSet, count: int) -> dict[str, Any]:
    """The arrays of a block, filled with zeros."""
    return dict(number=np.zeros(count, np.int32), frame=np.zeros(count, np.float64),
                pose=np.zeros((count, len(wanted.ranges), 4, 4), np.float32),
                coarse=np.zeros((count, wanted.coarse, 3), np.float32),
                fine=np.zeros((count, wanted.fine, 3), np.float32))
