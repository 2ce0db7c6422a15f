# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertex animation textures of a moving mesh, in the layout of OpenVAT 1.1 (github.com/sharpen3d/openvat). No bpy here.

There is a texel for each point and frame. The points fill rows of `width` texels. Each row of points has a block of
`frames` rows in the texture, with the first frame on top. The mesh's second UV map has the texel of each point at the
first frame. A shader adds frame / height. A texel contains the offset of a point from its position at the first frame.
Each axis is mapped to 0..1 from its range in the file of remap information. A second texture has normals, mapped from
-1..1. Axes are Blender's, z up. The order of texels is free, because the UV map defines it. Here they are in the order
of the points.
"""
from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .clip_manifest import ClipFault

SMALLEST, LARGEST = 64, 8192  # texels: smallest width, largest side
STEPS = 65535  # largest value of 16 bits
TOO_FAR = 2e-4  # metres: larger errors are reported
UV_MAP = "VAT_UV"


@dataclass(frozen=True)
class Layout:
    """Sides in texels, powers of two."""

    points: int
    frames: int
    width: int
    height: int

    @classmethod
    def of(cls, points: int, frames: int) -> Layout:
        """The layout that OpenVAT would choose: the smallest one whose sides differ by at most a factor of two,
        otherwise the one whose sides differ least. Raises ClipFault."""
        found = []
        for width in (1 << power for power in range(int(math.log2(SMALLEST)), int(math.log2(LARGEST)) + 1)):
            height = 1 << (frames * -(-points // width) - 1).bit_length()
            if height <= LARGEST:
                apart = abs(int(math.log2(width)) - int(math.log2(height)))
                found.append((max(apart, 1), width * height, width, height))
        if not found:
            raise ClipFault(f"{points} points in {frames} frames need more than a texture of {LARGEST} x {LARGEST} "
                            "texels: export fewer frames, or lower the density")
        return cls(points, frames, *min(found)[2:])

    def texels(self) -> tuple[np.ndarray, np.ndarray]:
        """(row, column) of each point at the first frame, counted from the upper left. At frame f the row is f
        larger."""
        numbers = np.arange(self.points)
        return numbers // self.width * self.frames, numbers % self.width

    def uv(self) -> np.ndarray:
        """(points, 2) float32: the centres of these texels. v points upwards, as in Blender."""
        row, column = self.texels()
        return np.stack([(column + 0.5) / self.width, 1.0 - (row + 0.5) / self.height], 1).astype(np.float32)

    def picture(self, values: np.ndarray) -> np.ndarray:
        """(height, width, 3) float32 from values (frames, points, 3), the upper row first; zero where there is no
        point."""
        shown = np.zeros((self.height, self.width, 3), np.float32)
        row, column = self.texels()
        for frame in range(self.frames):
            shown[row + frame, column] = values[frame]
        return shown


@dataclass
class Remap:
    """The range of offsets on each axis. least, most: (3,) float64, object units."""

    least: np.ndarray
    most: np.ndarray

    @classmethod
    def of(cls, offsets: np.ndarray) -> Remap:
        flat = offsets.reshape(-1, 3)
        return cls(flat.min(0).astype(float), flat.max(0).astype(float))

    def encode(self, offsets: np.ndarray, deep: bool) -> np.ndarray:
        """Offsets mapped to 0..1, float32. deep: False: rounded to 16 bits. An axis without movement is 0."""
        size = self.most - self.least
        shares = (offsets - self.least) / np.where(size > 0.0, size, 1.0)
        return (shares if deep else np.rint(shares * STEPS) / STEPS).astype(np.float32)

    def decode(self, shares: np.ndarray) -> np.ndarray:
        """The offsets that a shader computes, float64."""
        return self.least + shares * (self.most - self.least)


def way_of(points: np.ndarray) -> np.ndarray:
    """Offset of the mean of all points from the mean at the first frame, (frames, 3) float32. points: (frames, n,
    3)."""
    middles = points.mean(1, dtype=np.float64)
    return (middles - middles[0]).astype(np.float32)


def encode_normals(normals: np.ndarray, deep: bool) -> np.ndarray:
    """Normals mapped from -1..1 to 0..1, float32. deep: False: rounded to 16 bits."""
    shares = (np.clip(normals, -1.0, 1.0) + 1.0) / 2.0
    return (shares if deep else np.rint(shares * STEPS) / STEPS).astype(np.float32)


def in_place_of(first: np.ndarray, world: np.ndarray, points: np.ndarray,
                normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals (n, 3) of an object with the matrix `world`, transformed into its space at the first frame.

    first, world: (4, 4), column vectors. An object that did not move keeps its bits.
    """
    if np.array_equal(first, world):
        return points, normals
    moved = np.linalg.inv(first) @ world
    turned = normals @ np.linalg.inv(moved[:3, :3])
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return ((points @ moved[:3, :3].T + moved[:3, 3]).astype(np.float32),
            (turned / np.where(lengths > 0.0, lengths, 1.0)).astype(np.float32))


def remap_text(remap: Remap, layout: Layout, about: dict[str, Any]) -> str:
    """The text of the file of remap information. OpenVAT's readers read `os-remap`; `rumple` describes the origin."""
    return json.dumps({"os-remap": {"Min": remap.least.tolist(), "Max": remap.most.tolist(), "Frames": layout.frames},
                       "rumple": {**about, "points": layout.points, "width": layout.width,
                                  "height": layout.height}}, indent=1) + "\n"
