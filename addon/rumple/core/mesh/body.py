# SPDX-License-Identifier: GPL-3.0-or-later
"""Body: the surfaces that a garment is worn over. Never imports bpy."""
from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace

import numpy as np

INSIDE = 0.03  # least volume / area^1.5 of a surface that has an inside, as for garments (heal_winding.cpp)
CLOSED_INSIDE = 0.005  # the same for a nearly closed surface: whole bodies have 0.026 to 0.047, a long pole 0.018
NEARLY_CLOSED = 0.2  # most opening / area; bodies with a hole at the neck have 0.05, a bowl has 0.5


@dataclass(frozen=True)
class Body:
    """The surfaces that the cloth stays outside of, in the pose of one frame. It joins all bodies of a garment."""

    positions: np.ndarray  # (b, 3) float32, object space of the garment
    triangles: np.ndarray  # (t, 3) int32, into positions; counter-clockwise seen from outside
    digest: bytes = b""  # digest_of_triangles(), if the caller keeps it from frame to frame
    rest: np.ndarray | None = None  # (b, 3) float32: positions while the garment is at rest, NaN where not known

    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """The arrays that identify it, for digests."""
        return self.positions, np.frombuffer(self.digest or digest_of_triangles(self.triangles, self.rest), np.uint8)

    def same_as(self, other: "Body | None") -> bool:
        """Whether both are the same surfaces at the same positions, in the frame and at rest, bit for bit."""
        return other is not None and np.array_equal(self.positions, other.positions) and same_at_rest(self, other)


class OwnSkin:
    """Skin that is part of a garment's mesh. It acts as a body of this garment."""

    def __init__(self, triangles: np.ndarray) -> None:
        """triangles: (t, 3) int32, vertices of the garment's mesh."""
        self.triangles = triangles
        self._vertices, rows = np.unique(triangles, return_inverse=True)
        self._own = np.ascontiguousarray(rows.reshape(-1, 3), np.int32)  # rows of _vertices
        self._joined: tuple[Body | None, Body] | None = None  # the last body that was joined, and the result

    def is_all_of(self, body: Body) -> bool:
        """Whether a body from joined() consists of this skin only."""
        return len(self._own) > 0 and len(body.positions) == len(self._vertices)

    def joined(self, positions: np.ndarray, body: Body | None) -> Body | None:
        """The body with the skin added; body may be None. positions: (n, 3) float32 of the garment's mesh in the
        frame."""
        if not len(self._own):
            return body
        own = positions[self._vertices]
        if self._joined is None or not same_at_rest(self._joined[0], body):
            others = np.zeros((0, 3), np.int32) if body is None else body.triangles
            triangles, rest = np.concatenate([self._own, others + np.int32(len(own))]), self._rest_with(body)
            self._joined = body, Body(own, triangles, digest_of_triangles(triangles, rest), rest)
        places = own if body is None else np.concatenate([own, body.positions])
        return replace(self._joined[1], positions=np.ascontiguousarray(places, np.float32))

    def _rest_with(self, body: Body | None) -> np.ndarray | None:
        return None if body is None else joined_rest([(len(self._vertices), None), (len(body.positions), body.rest)])


def digest_of_triangles(triangles: np.ndarray, rest: np.ndarray | None = None) -> bytes:
    """16 bytes. triangles: (t, 3) int32. rest: as in Body."""
    digest = hashlib.blake2b(np.ascontiguousarray(triangles).data, digest_size=16)
    if rest is not None:
        digest.update(np.ascontiguousarray(rest).data)
    return digest.digest()


def joined_rest(parts: list[tuple[int, np.ndarray | None]]) -> np.ndarray | None:
    """Body.rest for all bodies of a garment together. parts: number of vertices and own rest of each body."""
    if all(rest is None for _, rest in parts):
        return None
    unknown = [np.full((count, 3), np.nan, np.float32) if rest is None else rest for count, rest in parts]
    return np.ascontiguousarray(np.concatenate(unknown), np.float32)


def same_at_rest(one: Body | None, other: Body | None) -> bool:
    """Whether both are the same surfaces, in any pose."""
    if one is None or other is None:
        return one is other
    return same_triangles(one.triangles, other.triangles) and _same_rest(one.rest, other.rest)


def _same_rest(some: np.ndarray | None, others: np.ndarray | None) -> bool:
    if some is None or others is None:
        return some is others
    return some is others or np.array_equal(some, others, equal_nan=True)


def same_triangles(some: np.ndarray, others: np.ndarray) -> bool:
    """Whether two bodies have equal triangles. Usually both are the same array, so no element is compared."""
    return some is others or np.array_equal(some, others)


def facing_outwards(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles (t, 3), reversed if the surface (n, 3) is inside out. Blender shows such a body like any other, so
    artists do not notice it."""
    return triangles[:, ::-1] if side(positions, triangles) < 0 else triangles


def side(positions: np.ndarray, triangles: np.ndarray) -> int:
    """1: the triangles (t, 3) of a surface (n, 3) face outwards, -1: they face inwards, 0: it has no inside."""
    volume, area, opening = _inside(positions, triangles)
    least = (CLOSED_INSIDE if opening < NEARLY_CLOSED else INSIDE) * area ** 1.5
    return (volume > least) - (volume < -least)


def is_nearly_closed(positions: np.ndarray, triangles: np.ndarray) -> bool:
    """Whether its inside stays inside however it bends. A hood, for example, can turn inside out."""
    return _inside(positions, triangles)[2] < NEARLY_CLOSED


def volume_share(positions: np.ndarray, triangles: np.ndarray) -> float:
    """Volume / area^1.5 of a surface. A ball has 0.094, a body 0.03, clothes with a thickness less than 0.01."""
    volume, area, _ = _inside(positions, triangles)
    return abs(volume) / area ** 1.5 if area > 0.0 else 0.0


def _inside(positions: np.ndarray, triangles: np.ndarray) -> tuple[float, float, float]:
    """Volume, area, and the opening's share of the area.

    The volume is measured from the centre of the surface, so holes change little (skin deleted under clothes, for
    example). It takes 2 ms for 28,000 triangles; np.cross would take 12 ms.
    """
    with np.errstate(all="ignore"):  # positions that are not finite give NaN, and each comparison with it is false
        columns = np.ascontiguousarray(positions.T)
        a, b, c = (columns[:, corner] for corner in np.ascontiguousarray(triangles.T))
        u, v = b - a, c - a
        # The length of a normal is twice the triangle's area.
        normal = [u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)]
        areas = np.sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2])
        twice = float(areas.sum(dtype=np.float64))
        if not twice > 0.0:
            return 0.0, 0.0, 0.0
        middle = [float((areas * a[k]).sum(dtype=np.float64)) / twice for k in range(3)]
        volume = sum(float(((a[k] - np.float32(middle[k])) * normal[k]).sum(dtype=np.float64)) for k in range(3)) / 6.0
        opening = math.hypot(*(float(along.sum(dtype=np.float64)) for along in normal)) / twice
        return volume, 0.5 * twice, opening
