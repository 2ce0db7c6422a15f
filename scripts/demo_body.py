# SPDX-License-Identifier: GPL-3.0-or-later
"""The mannequin of the demo scene: a signed distance and its quad mesh.

Pure NumPy, no Blender. Space: metres, z up, the figure faces -y, its left side
is +x. The figure rests in an A pose. Everything is mirror symmetric in x, so
distances are computed for |x| only.
"""

from __future__ import annotations

from typing import Callable

import numpy as np

Array = np.ndarray
Key = tuple[str, int, int]  # a vertex of a garment: part, row or ring, column

# Joints of the left half, rest pose.
SHOULDER = np.array([0.176, 0.012, 1.402])
ARM_DIRECTION = np.array([0.735, 0.0, -0.678]) / np.hypot(0.735, 0.678)
UPPER_ARM_LENGTH = 0.285
FOREARM_LENGTH = 0.255
HAND_LENGTH = 0.175
ELBOW = SHOULDER + UPPER_ARM_LENGTH * ARM_DIRECTION
WRIST = ELBOW + FOREARM_LENGTH * ARM_DIRECTION

# Frame of the hand: fingers along the arm, thumb to the front, palm to the thigh.
THUMB_DIRECTION = np.array([0.0, -1.0, 0.0])
PALM_DIRECTION = np.cross(ARM_DIRECTION, THUMB_DIRECTION)

# Joints of the left leg. It points down; the foot points to the front.
HIP = np.array([0.085, 0.012, 0.885])
KNEE = np.array([0.100, -0.004, 0.485])
ANKLE = np.array([0.106, 0.022, 0.090])
HEEL, TOE = np.array([0.106, 0.034, 0.030]), np.array([0.118, -0.135, 0.020])

# Torso as a stack of superellipses: height, half width, half depth, centre y.
BODY_TORSO = np.array([
    [0.78, 0.080, 0.060, 0.014],
    [0.84, 0.140, 0.096, 0.014],
    [0.91, 0.164, 0.110, 0.016],
    [1.00, 0.152, 0.102, 0.010],
    [1.09, 0.138, 0.094, 0.004],
    [1.20, 0.147, 0.104, 0.000],
    [1.30, 0.158, 0.113, -0.002],
    [1.37, 0.160, 0.108, 0.002],
    [1.43, 0.138, 0.088, 0.012],
    [1.475, 0.090, 0.066, 0.018],
    [1.52, 0.050, 0.050, 0.018],
])
TORSO_EXPONENT = 2.35


def smooth_interpolation(x: Array, knots: Array, values: Array) -> Array:
    """Cubic Hermite curve through the knots (central slopes), constant outside."""
    slopes = np.gradient(values, knots)
    slopes[0] = slopes[-1] = 0.0
    x = np.clip(x, knots[0], knots[-1])
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    width = knots[i + 1] - knots[i]
    t = (x - knots[i]) / width
    t2, t3 = t * t, t * t * t
    return ((2 * t3 - 3 * t2 + 1) * values[i] + (t3 - 2 * t2 + t) * width * slopes[i]
            + (3 * t2 - 2 * t3) * values[i + 1] + (t3 - t2) * width * slopes[i + 1])


def round_cone(points: Array, start: Array, end: Array, r0: float, r1: float) -> Array:
    """Distance to a capsule whose radius goes linearly from r0 to r1."""
    axis = end - start
    offset = points - start
    t = np.clip(offset @ axis / (axis @ axis), 0.0, 1.0)
    return np.linalg.norm(offset - t[..., None] * axis, axis=-1) - (r0 + (r1 - r0) * t)


def ellipsoid(points: Array, centre: tuple, radii: tuple) -> Array:
    """First-order distance to an axis-aligned ellipsoid."""
    offset = points - np.asarray(centre)
    radii = np.asarray(radii)
    k0 = np.linalg.norm(offset / radii, axis=-1)
    k1 = np.linalg.norm(offset / radii**2, axis=-1)
    return k0 * (k0 - 1.0) / np.maximum(k1, 1e-9)


def smooth_union(a: Array, b: Array, radius: float) -> Array:
    """Minimum of two distances with a fillet of the given radius (metres)."""
    h = np.maximum(radius - np.abs(a - b), 0.0) / radius
    return np.minimum(a, b) - 0.25 * h * h * radius


def torso_distance(points: Array, table: Array) -> Array:
    """First-order distance to a stack of superellipses (rows as in BODY_TORSO)."""
    z = points[..., 2]
    a, b, c = (smooth_interpolation(z, table[:, 0], table[:, k]) for k in (1, 2, 3))
    n = TORSO_EXPONENT
    u, v = np.abs(points[..., 0]) / a, np.abs(points[..., 1] - c) / b
    q = np.maximum((u**n + v**n) ** (1.0 / n), 1e-6)
    slope = np.hypot((u / q) ** (n - 1) / a, (v / q) ** (n - 1) / b)
    return np.maximum((q - 1.0) / slope, np.maximum(z - table[-1, 0], table[0, 0] - z))


def arm_distance(points: Array) -> Array:
    """Distance to the left arm without its hand; points have x >= 0."""
    belly = ELBOW + 0.07 * ARM_DIRECTION
    d = round_cone(points, SHOULDER, ELBOW, 0.051, 0.038)
    d = smooth_union(d, round_cone(points, ELBOW, belly, 0.037, 0.041), 0.02)
    return smooth_union(d, round_cone(points, belly, WRIST, 0.041, 0.027), 0.02)


def hand_distance(points: Array) -> Array:
    """Distance to the left hand: palm, four slightly curled fingers, thumb."""
    def at(along: float, thumbward: float, palmward: float) -> Array:
        return (WRIST + along * ARM_DIRECTION + thumbward * THUMB_DIRECTION
                + palmward * PALM_DIRECTION)

    d = round_cone(points, at(-0.01, 0.0, 0.0), at(0.02, 0.0, 0.0), 0.024, 0.020)
    for thumbward, length in ((0.030, 0.070), (0.0105, 0.078), (-0.009, 0.073), (-0.028, 0.056)):
        root = at(0.085, thumbward, 0.0)
        palm = round_cone(points, at(0.015, 0.4 * thumbward, 0.0), root, 0.017, 0.0125)
        d = smooth_union(d, palm, 0.016)
        knuckle = at(0.085 + 0.55 * length, 1.12 * thumbward, 0.010)
        tip = at(0.085 + 0.95 * length, 1.12 * thumbward, 0.032)
        finger = np.minimum(round_cone(points, root, knuckle, 0.0105, 0.0092),
                            round_cone(points, knuckle, tip, 0.0092, 0.0078))
        d = smooth_union(d, finger, 0.006)
    thumb = np.minimum(
        round_cone(points, at(0.025, 0.016, 0.006), at(0.060, 0.048, 0.018), 0.0155, 0.0115),
        round_cone(points, at(0.060, 0.048, 0.018), at(0.098, 0.058, 0.026), 0.0115, 0.0085))
    return smooth_union(d, thumb, 0.014)


def leg_distance(points: Array) -> Array:
    """Distance to the left leg; points have x >= 0."""
    calf = KNEE + 0.28 * (ANKLE - KNEE) + (0.0, 0.014, 0.0)
    d = round_cone(points, HIP, KNEE, 0.090, 0.053)
    d = smooth_union(d, round_cone(points, KNEE, calf, 0.050, 0.053), 0.02)
    d = smooth_union(d, round_cone(points, calf, ANKLE, 0.052, 0.035), 0.02)
    return smooth_union(d, round_cone(points, HEEL, TOE, 0.034, 0.026), 0.04)


def head_distance(points: Array) -> Array:
    """Distance to neck and head: a shop mannequin with nose, eye sockets and ears."""
    d = ellipsoid(points, (0.0, 0.004, 1.712), (0.077, 0.096, 0.094))
    d = smooth_union(d, ellipsoid(points, (0.0, -0.040, 1.655), (0.060, 0.060, 0.082)), 0.05)
    nose = round_cone(points, np.array([0.0, -0.094, 1.694]), np.array([0.0, -0.113, 1.657]),
                      0.005, 0.0095)
    d = smooth_union(d, nose, 0.014)
    socket = ellipsoid(points, (0.033, -0.108, 1.690), (0.022, 0.022, 0.015))
    d = -smooth_union(-d, socket, 0.022)
    ear = ellipsoid(points, (0.077, 0.012, 1.675), (0.009, 0.017, 0.029))
    d = smooth_union(d, ear, 0.012)
    neck = round_cone(points, np.array([0.0, 0.022, 1.45]), np.array([0.0, 0.004, 1.62]),
                      0.057, 0.051)
    return smooth_union(d, neck, 0.03)


def body_distance(points: Array) -> Array:
    """Signed distance (first order, negative inside) to the whole mannequin."""
    p = points.copy()
    p[..., 0] = np.abs(p[..., 0])
    d = torso_distance(p, BODY_TORSO)
    shoulder = round_cone(p, np.array([0.05, 0.020, 1.452]), SHOULDER, 0.042, 0.050)
    d = smooth_union(d, shoulder, 0.05)
    d = smooth_union(d, arm_distance(p), 0.035)
    d = smooth_union(d, leg_distance(p), 0.05)
    d = smooth_union(d, hand_distance(p), 0.012)
    d = smooth_union(d, head_distance(p), 0.04)
    return np.maximum(d, -p[..., 2])


def project_to_surface(points: Array, distance: Callable[[Array], Array], steps: int = 3) -> Array:
    """Newton steps onto distance = 0 with central differences (1 mm)."""
    for _ in range(steps):
        gradient = distance_gradient(points, distance)
        points = points - distance(points)[:, None] * gradient / np.maximum(
            np.sum(gradient**2, axis=1), 0.2)[:, None]
    return points


def distance_gradient(points: Array, distance: Callable[[Array], Array]) -> Array:
    """Central differences of a distance function, step 1 mm."""
    step = 1e-3
    columns = [(distance(points + step * e) - distance(points - step * e)) / (2 * step)
               for e in np.eye(3)]
    return np.stack(columns, axis=1)


def neighbour_average(points: Array, edges: Array, weights: Array | None = None) -> Array:
    """Mean position of each point's edge neighbours; weights: one per edge."""
    if weights is None:
        weights = np.ones(len(edges))
    ends = np.concatenate([edges[:, 0], edges[:, 1]])
    others = np.concatenate([edges[:, 1], edges[:, 0]])
    both = np.concatenate([weights, weights])
    total = np.stack([np.bincount(ends, both * points[others, k], len(points))
                      for k in range(3)], axis=1)
    return total / np.bincount(ends, both, len(points))[:, None]


def number_vertices(cells: list[list[Key]], vertex_name: Callable[[Key], Key]) -> tuple[dict[Key, int], Array]:
    """Vertices of a garment, numbered in the order in which its cells name them; and the cells in these numbers."""
    number: dict[Key, int] = {}
    for cell in cells:
        for key in cell:
            number.setdefault(vertex_name(key), len(number))
    return number, np.array([[number[vertex_name(key)] for key in cell] for cell in cells])


def edges_of_quads(quads: Array) -> Array:
    """Unique undirected edges, sorted, shape (m, 2)."""
    pairs = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def surface_nets(values: Array) -> tuple[Array, Array]:
    """Dual quad mesh of the zero set of a sampled function (Gibson 1998).

    Returns the cells that hold a vertex (integer coordinates) and the quads.
    """
    inside = values < 0.0
    corner_count = sum(inside[i:i - 1 or None, j:j - 1 or None, k:k - 1 or None].astype(np.int8)
                       for i in (0, 1) for j in (0, 1) for k in (0, 1))
    mixed = (corner_count > 0) & (corner_count < 8)
    number = np.full(mixed.shape, -1, dtype=np.int64)
    number[mixed] = np.arange(np.count_nonzero(mixed))
    quads = []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        first, second = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
        for leaving in (True, False):
            crossing = (first & ~second) if leaving else (~first & second)
            at = np.argwhere(np.moveaxis(crossing, 0, axis))
            around = [at - u - v, at - v, at, at - u]
            ring = np.stack([number[tuple(c.T)] for c in around], axis=1)
            quads.append(ring if leaving else ring[:, ::-1])
    return np.argwhere(mixed), np.concatenate(quads)


def build_body(spacing: float = 0.0075, bottom: float = 0.0) -> tuple[Array, Array]:
    """Mannequin mesh above the height bottom: points (n, 3) in metres and quads (m, 4), normals outward.

    The grid stays clear of the surface, so every crossed edge has four cells.
    """
    def distance(points: Array) -> Array:
        return np.maximum(body_distance(points), bottom - points[..., 2])

    low, high = np.array([-0.78, -0.22, bottom - 0.02]), np.array([0.78, 0.20, 1.84])
    counts = np.ceil((high - low) / spacing).astype(int)
    axes = [low[k] + spacing * np.arange(counts[k]) for k in range(3)]
    values = np.stack([distance(np.stack(np.meshgrid([x], axes[1], axes[2], indexing="ij"), axis=-1))[0]
                       for x in axes[0]])
    cells, quads = surface_nets(values)
    points = low + spacing * (cells + 0.5)
    edges = edges_of_quads(quads)
    for _ in range(4):
        points = project_to_surface(points, distance, steps=1)
        points = 0.5 * points + 0.5 * neighbour_average(points, edges)
    return np.round(project_to_surface(points, distance), 6), quads
