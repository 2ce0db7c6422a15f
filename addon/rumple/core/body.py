# SPDX-License-Identifier: GPL-3.0-or-later
"""What a garment is worn over. Never imports bpy."""
from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace

import numpy as np

INSIDE_OUT = 0.03  # volume over area^1.5 from which a surface has an inside, as for garments (heal_winding.cpp)


@dataclass(frozen=True)
class Body:
    """The surfaces that cloth stays outside of, as they stand in a frame; all bodies of a garment in one."""

    positions: np.ndarray  # (b, 3) float32, object space of the garment
    triangles: np.ndarray  # (t, 3) int32, into positions; counter-clockwise seen from outside
    digest: bytes = b""  # digest_of_triangles(), where it is kept from frame to frame

    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """What tells it from another, for digests."""
        return self.positions, np.frombuffer(self.digest or digest_of_triangles(self.triangles), np.uint8)

    def same_as(self, other: "Body | None") -> bool:
        """Whether both are the same surfaces at the same places, to the bit."""
        return (other is not None and np.array_equal(self.positions, other.positions)
                and same_triangles(self.triangles, other.triangles))


class OwnSkin:
    """Skin in the mesh of a garment: the garment's own body."""

    def __init__(self, triangles: np.ndarray) -> None:
        """triangles: (t, 3) int32, vertices of the garment's mesh."""
        self.triangles = triangles
        self._vertices, rows = np.unique(triangles, return_inverse=True)
        self._own = np.ascontiguousarray(rows.reshape(-1, 3), np.int32)  # rows of _vertices
        self._joined: tuple[np.ndarray, Body] | None = None  # with which triangles of a body, and what it became

    def is_all_of(self, body: Body) -> bool:
        """Whether joined() added nothing to it."""
        return len(self._own) > 0 and len(body.positions) == len(self._vertices)

    def joined(self, positions: np.ndarray, body: Body | None) -> Body | None:
        """A body, or none, and the skin. positions: (n, 3) float32 of the garment's mesh in the frame."""
        if not len(self._own):
            return body
        own = positions[self._vertices]
        others = np.zeros((0, 3), np.int32) if body is None else body.triangles
        if self._joined is None or not same_triangles(self._joined[0], others):
            triangles = np.concatenate([self._own, others + np.int32(len(own))])
            self._joined = others, Body(own, triangles, digest_of_triangles(triangles))
        places = own if body is None else np.concatenate([own, body.positions])
        return replace(self._joined[1], positions=np.ascontiguousarray(places, np.float32))


def digest_of_triangles(triangles: np.ndarray) -> bytes:
    """16 bytes. triangles: (t, 3) int32."""
    return hashlib.blake2b(np.ascontiguousarray(triangles).data, digest_size=16).digest()


def same_triangles(some: np.ndarray, others: np.ndarray) -> bool:
    """Of bodies: mostly these are one array, frame after frame."""
    return some is others or np.array_equal(some, others)


def facing_outwards(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles (t, 3), turned where the surface (n, 3) is inside out: Blender shows such a body as any other.

    Holes, as where skin was deleted under clothes, do not count: the volume is measured from the surface's middle.
    """
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    half = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(half, axis=1)
    area = areas.sum()
    if not area > 0.0:
        return triangles
    middle = (areas[:, None] * a).sum(0) / area
    volume = ((a - middle) * half).sum() / 3.0
    return triangles[:, ::-1] if volume < -INSIDE_OUT * area ** 1.5 else triangles
