# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the part of a body that is under a garment while both are at rest. Frames are solved from the result, so this
module uses sums and products only: libraries for matrices round differently on other machines. Never imports bpy."""
from __future__ import annotations

import numpy as np

from ..base.triangles import vertex_normals
from ..base.vertices import lengths
from ..mesh.figure_size import size_factor

SOME, NEAR = 200, 0.25  # tested vertices; distance / the garment's diagonal within which half of them have the body
CLOTH, AT_ONCE = 1_000, 200  # largest number of the garment's vertices; the body's vertices at a time
ABOVE, STEEP = 0.2, 0.5  # metres for clothes of an adult; cosine: cloth within both limits is above skin, like a skirt
CLOSE = 0.04  # metres: skin nearer to cloth than this is always under it


def is_worn(cloth: np.ndarray, body: np.ndarray) -> bool:
    """Whether a garment (n, 3) was modelled on a body (b, 3): half of it is near the body. If not, the body's rest
    positions have no meaning for the garment."""
    some = _some(cloth, SOME)
    if not len(some) or not len(body):
        return False
    nearest = [float(lengths(body - place).min()) for place in some]
    return bool(np.median(nearest) < NEAR * _diagonal(some))


def size_of(cloth: np.ndarray, metres: float, figure: float = 0.0) -> float:
    """Object units per metre of an adult's clothes. cloth: (n, 3). metres: per object unit. figure: height of the
    wearer, object units; 0: unknown."""
    return size_factor(_diagonal(cloth), metres, figure) / metres


def is_covered(body: np.ndarray, triangles: np.ndarray, cloth: np.ndarray, facing: np.ndarray,
               size: float) -> np.ndarray:
    """(b,) bool: which vertices of a body (b, 3) have cloth (n, 3) above them that faces the same way. triangles: (t,
    3), facing outwards. facing: (n, 3), normals of the cloth. size: object units per metre of an adult's clothes. Cost:
    about 20 ns for each pair of a body vertex in the garment's box and a garment vertex (at most 1,000 of these)."""
    reach, out = ABOVE * size, np.zeros(len(body), bool)
    within = ((body > cloth.min(axis=0) - reach) & (body < cloth.max(axis=0) + reach)).all(axis=1)
    normals = vertex_normals(body, triangles)
    normals = (normals / np.maximum(lengths(normals), 1e-30)[:, None]).astype(np.float32)
    over, facing = np.ascontiguousarray(_some(cloth, CLOTH).T), np.ascontiguousarray(_some(facing, CLOTH).T)
    rows = np.flatnonzero(within)
    for some in np.array_split(rows, len(rows) // AT_ONCE + 1):
        out[some] = _is_under(body[some].T[:, :, None], normals[some].T[:, :, None], over[:, None], facing[:, None],
                              np.float32(reach), np.float32(CLOSE * size))
    return out


def _is_under(points: np.ndarray, normals: np.ndarray, over: np.ndarray, facing: np.ndarray, reach: np.float32,
              close: np.float32) -> np.ndarray:
    """(k,) bool: which points of the body are under cloth. points, normals: (3, k, 1), of the body. over, facing: (3,
    1, c), of the cloth. All float32."""
    way, steep = over - points, np.float32(STEEP)
    squared, height = _dot(way, way), _dot(way, normals)
    above = (squared < reach * reach) & (height > 0.0) & (height * height > steep * steep * squared)
    result: np.ndarray = ((_dot(normals, facing) > steep) & (above | (squared < close * close))).any(axis=1)
    return result


def _dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    result: np.ndarray = (one[0] * other[0] + one[1] * other[1]) + one[2] * other[2]
    return result


def _diagonal(points: np.ndarray) -> float:
    return float(lengths(np.ptp(points, axis=0)))


def _some(points: np.ndarray, most: int) -> np.ndarray:
    return points[::-(-len(points) // most)] if len(points) > most else points
