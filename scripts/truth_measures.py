# SPDX-License-Identifier: GPL-3.0-or-later
"""How a fine surface differs from the smooth bare base under it: numbers by which wrinkles and a simulation compare.

Pure NumPy. The detail is the height of the fine surface above the base along the base's normals, vertex by vertex.
Wavelengths are measured along the cloth at rest: the bands come from smoothing by functions of the Laplacian of the
rest shape, so they follow the surface round sleeves and over seams. One Cloth holds what does not change with the
frame; `measures` is for one frame. Waves of less than three edges seem longer than they are: 20 mm on edges of 8 mm
counts as 26 mm.
"""
from __future__ import annotations

from dataclasses import dataclass
from math import erf

import numpy as np

CUTS = (0.028, 0.055, 0.110, 0.220)  # metres: the bands lie below, between and above these wavelengths
BANDS = ("below_28", "28_to_55", "55_to_110", "110_to_220", "above_220")
DEGREE = 400  # of the Chebyshev polynomials
SHARPNESS = 0.12  # octaves: standard deviation of a cut's edge
TINY = 0.3  # of the median vertex's area; the smallest that the Laplacian sees, it bounds the eigenvalues
COMPRESSED, LOOSE = 0.97, 0.98  # smallest stretch: below is compressed, above is not


@dataclass
class Cloth:
    """A fine garment at rest. n vertices, t triangles, p patches (triangles of the coarse base)."""

    rest: np.ndarray  # (n, 3) float64, metres
    triangles: np.ndarray  # (t, 3)
    patch: np.ndarray  # (t,) 0 to p - 1
    rest_area: np.ndarray  # (t,) square metres
    vertex_area: np.ndarray  # (n,) square metres, sums to the whole
    inertia: np.ndarray  # (n,) square metres: the same for the Laplacian, tiny vertices let out
    edges: np.ndarray  # (e, 2)
    cotangents: np.ndarray  # (e,) Laplacian's weights
    largest: float  # bound of the Laplacian's eigenvalues, 1 / square metres
    to_rest: np.ndarray  # (t, 3, 2) from a triangle's two edges to its rest plane's axes, in space: see strain


def build_cloth(rest: np.ndarray, triangles: np.ndarray, patch: np.ndarray | None = None) -> Cloth:
    """rest (n, 3) metres, triangles (t, 3), patch (t,): the coarse triangle that each lies in (itself without)."""
    rest = np.asarray(rest, np.float64)
    triangles = np.asarray(triangles, np.int64)
    patch = np.arange(len(triangles)) if patch is None else np.unique(patch, return_inverse=True)[1]
    a, b, c = (rest[triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    vertex_area = np.bincount(triangles.ravel(), np.repeat(area / 3.0, 3), len(rest))
    edges, weights = _cotangents(rest, triangles)
    inertia = np.maximum(vertex_area, TINY * np.median(vertex_area))
    pulls = np.bincount(edges.ravel(), np.repeat(weights, 2), len(rest)) / inertia
    to_rest = np.linalg.pinv(np.stack([b - a, c - a], axis=2)).transpose(0, 2, 1)
    return Cloth(rest, triangles, patch, area, vertex_area, inertia, edges, weights, 2.0 * float(pulls.max()), to_rest)


def _cotangents(rest: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (e, 2) with half the sum of the cotangents (e,) opposite; kept within 0.02 and 4 for thin triangles."""
    sides, values = [], []
    for k in range(3):
        i, j, top = triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3], triangles[:, k]
        u, v = rest[i] - rest[top], rest[j] - rest[top]
        sides.append(np.sort(np.stack([i, j], 1), axis=1))
        values.append(0.5 * (u * v).sum(1) / np.maximum(np.linalg.norm(np.cross(u, v), axis=1), 1e-20))
    edges, number = np.unique(np.concatenate(sides), axis=0, return_inverse=True)
    return edges, np.clip(np.bincount(number.ravel(), np.concatenate(values), len(edges)), 0.02, 4.0)


def vertex_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(n, 3) unit, weighted by area."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    normals = np.stack([np.bincount(triangles.ravel(), np.repeat(face[:, k], 3), len(positions)) for k in range(3)], 1)
    return normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-20)[:, None]


def heights(cloth: Cloth, base: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """(n,) metres along the normals of the base (n, 3) to the fine surface (n, 3)."""
    base = np.asarray(base, np.float64)
    return ((fine - base) * vertex_normals(base, cloth.triangles)).sum(1)


def bands(cloth: Cloth, height: np.ndarray) -> np.ndarray:
    """(5, n): the height (n,) taken apart by wavelength, as in BANDS; the sum is the height again."""
    a, b = cloth.edges[:, 0], cloth.edges[:, 1]
    count = len(height)

    def laplacian(x: np.ndarray) -> np.ndarray:
        """x, scaled so that the eigenvalues lie within -1 and 1."""
        flow = cloth.cotangents * (x[a] - x[b])
        pull = (np.bincount(a, flow, count) - np.bincount(b, flow, count)) / cloth.inertia
        return pull * (2.0 / cloth.largest) - x

    series = [_low_pass(cut, cloth.largest) for cut in CUTS]
    before, now = height, laplacian(height)
    smooth = [c[0] * before + c[1] * now for c in series]
    for k in range(2, DEGREE + 1):
        before, now = now, 2.0 * laplacian(now) - before
        for total, c in zip(smooth, series):
            total += c[k] * now
    steps = [height, *smooth, np.zeros_like(height)]
    return np.stack([steps[k] - steps[k + 1] for k in range(len(CUTS) + 1)])


def _low_pass(cut: float, largest: float) -> np.ndarray:
    """(DEGREE + 1,) Chebyshev coefficients of 1 for longer waves than `cut` metres, 0 for shorter."""
    angles = np.pi * (np.arange(4 * DEGREE) + 0.5) / (4 * DEGREE)
    eigenvalue = 0.5 * largest * (np.cos(angles) + 1.0)
    octaves = 0.5 * np.log2(np.maximum(eigenvalue, 1e-12) * (cut / (2.0 * np.pi)) ** 2)
    wanted = np.array([0.5 - 0.5 * erf(x / (SHARPNESS * np.sqrt(2.0))) for x in octaves])
    result = np.cos(np.outer(np.arange(DEGREE + 1), angles)) @ wanted / (2 * DEGREE)
    result[0] *= 0.5
    return result


def strain(cloth: Cloth, base: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The base's (n, 3) strongest compression. Smallest stretch of every patch (p,), and its direction in space on
    every triangle (t, 3), unit: a patch's triangles are averaged, the direction is carried by each."""
    a, b, c = (np.asarray(base, np.float64)[cloth.triangles[:, k]] for k in range(3))
    gradient = np.stack([b - a, c - a], axis=2) @ cloth.to_rest.transpose(0, 2, 1)  # (t, 3, 3)
    patches = int(cloth.patch.max()) + 1
    green = np.einsum("tki,tkj->tij", gradient, gradient) * cloth.rest_area[:, None, None]
    p, q, r = (cloth.rest[cloth.triangles[:, k]] for k in range(3))
    normal = np.cross(q - p, r - p)
    total = np.zeros((patches, 3, 3))
    up = np.zeros((patches, 3))
    np.add.at(total, cloth.patch, green)
    np.add.at(up, cloth.patch, normal)
    total /= np.bincount(cloth.patch, cloth.rest_area, patches)[:, None, None]
    up /= np.linalg.norm(up, axis=1)[:, None]
    x = np.cross(up, np.where(np.abs(up[:, :1]) < 0.7, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    x /= np.linalg.norm(x, axis=1)[:, None]
    plane = np.stack([x, np.cross(up, x)], axis=2)  # (p, 3, 2)
    squares, axes = np.linalg.eigh(plane.transpose(0, 2, 1) @ total @ plane)
    direction = np.einsum("pij,pj->pi", plane, axes[:, :, 0])
    carried = np.einsum("tij,tj->ti", gradient, direction[cloth.patch])
    carried /= np.maximum(np.linalg.norm(carried, axis=1), 1e-20)[:, None]
    return np.sqrt(np.maximum(squares[:, 0], 0.0)), carried


def gradients(cloth: Cloth, base: np.ndarray, height: np.ndarray) -> np.ndarray:
    """(t, 3) of the height (n,) over the base's triangles, metres per metre."""
    a, b, c = (np.asarray(base, np.float64)[cloth.triangles[:, k]] for k in range(3))
    to_plane = np.linalg.pinv(np.stack([b - a, c - a], axis=1), rcond=1e-3)  # (t, 3, 2)
    h = height[cloth.triangles]
    return np.einsum("tij,tj->ti", to_plane, h[:, 1:] - h[:, :1])


def area(cloth: Cloth, positions: np.ndarray) -> float:
    """Square metres."""
    a, b, c = (np.asarray(positions, np.float64)[cloth.triangles[:, k]] for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def measures(cloth: Cloth, base: np.ndarray, fine: np.ndarray) -> dict[str, float]:
    """One frame's numbers. base, fine (n, 3) metres. RMS in millimetres, by band and together; alignment of the
    detail with the base's compression (mean cos squared, 0.5: unrelated; nan where nothing is compressed or there is
    no detail); shares of 1. The detail is what is shorter than 220 mm: not how far the cloth hangs from the body."""
    height = heights(cloth, base, fine)
    weight = cloth.vertex_area / cloth.vertex_area.sum()
    parts = bands(cloth, height)
    result = {f"rms_{name}_mm": 1e3 * float(np.sqrt((weight * part ** 2).sum())) for name, part in zip(BANDS, parts)}
    result["rms_mm"] = 1e3 * float(np.sqrt((weight * height ** 2).sum()))
    detail = height - parts[-1]
    result["rms_detail_mm"] = 1e3 * float(np.sqrt((weight * detail ** 2).sum()))
    stretch, direction = strain(cloth, base)
    gradient = gradients(cloth, base, detail)
    size = cloth.rest_area * (gradient ** 2).sum(1) * (stretch < COMPRESSED)[cloth.patch]
    along = cloth.rest_area * (gradient * direction).sum(1) ** 2 * (stretch < COMPRESSED)[cloth.patch]
    result["alignment"] = float(along.sum() / size.sum()) if size.sum() > 1e-12 else float("nan")
    loose = (stretch > LOOSE)[cloth.patch]
    squared = cloth.rest_area * (detail[cloth.triangles] ** 2).mean(1)
    result["detail_where_not_compressed"] = float(squared[loose].sum() / max(squared.sum(), 1e-20))
    result["area_not_compressed"] = float(cloth.rest_area[loose].sum() / cloth.rest_area.sum())
    whole = float(cloth.rest_area.sum())
    result["area_kept"], result["area_of_base"] = area(cloth, fine) / whole, area(cloth, base) / whole
    return result
