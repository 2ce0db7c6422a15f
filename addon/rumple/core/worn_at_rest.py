# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a body is under a garment while both are at rest. Never imports bpy."""
from __future__ import annotations

import numpy as np

from .cloth import size_factor

SOME, NEAR = 200, 0.25  # vertices that are asked; of the garment's diagonal: half of them have the body as near
CLOTH, AT_ONCE = 1_000, 1_000  # vertices of the garment, at most; of the body, at a time
ABOVE, STEEP = 0.2, 0.5  # metres, of clothes of an adult, and cosine: cloth there is above skin, as a skirt is
CLOSE = 0.04  # metres: whatever is as near to cloth is under it


def is_worn(cloth: np.ndarray, body: np.ndarray) -> bool:
    """Whether a garment (n, 3) was modelled on a body (b, 3): half of it is near. Where it was not, the body's place at
    rest tells nothing."""
    some = _some(cloth, SOME)
    if not len(some) or not len(body):
        return False
    near = NEAR * float(np.linalg.norm(np.ptp(some, axis=0)))
    nearest = [float(np.square(body - place).sum(axis=1).min()) for place in some]
    return bool(np.median(nearest) < near * near)


def size_of(cloth: np.ndarray, metres: float) -> float:
    """Object units to a metre of what an adult wears. cloth: (n, 3). metres: to an object unit."""
    return size_factor(float(np.linalg.norm(np.ptp(cloth, axis=0))), metres) / metres


def is_covered(body: np.ndarray, triangles: np.ndarray, cloth: np.ndarray, facing: np.ndarray,
               size: float) -> np.ndarray:
    """(b,) bool: has cloth (n, 3) above it that faces as it does. Of a body (b, 3) with triangles (t, 3) that face
    outwards. facing: (n, 3), normals. size: object units to a metre of what an adult wears."""
    normals, some, facing = _normals(body, triangles), _some(cloth, CLOTH), _some(facing, CLOTH)
    out = np.zeros(len(body), bool)
    for first in range(0, len(body), AT_ONCE):
        chunk = slice(first, first + AT_ONCE)
        way = some[None] - body[chunk, None]
        distance = np.sqrt(np.square(way).sum(axis=2))
        height = np.einsum("bck,bk->bc", way, normals[chunk])
        above = (distance < ABOVE * size) & (height > STEEP * distance)
        alike = normals[chunk] @ facing.T > STEEP
        out[chunk] = (alike & (above | (distance < CLOSE * size))).any(axis=1)
    return out


def _some(points: np.ndarray, most: int) -> np.ndarray:
    return points[::-(-len(points) // most)] if len(points) > most else points


def _normals(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(n, 3), unit or zero."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    of_face, normals = np.cross(b - a, c - a), np.zeros_like(points)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], of_face)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.maximum(length, 1e-30)
