# SPDX-License-Identifier: GPL-3.0-or-later
"""The trousers of the demo scene: one coarse quad mesh with pattern-like UVs.

Pure NumPy, no Blender; space as in demo_body. A tube of rings goes from the waistband down to the crotch. There a
strip between the middle of the front and the middle of the back, CROTCH edges long, closes the first ring of each
leg. Only the two ends of that strip are irregular (valence 5 and more). Parts of a Key: hips, left, right, and crotch
for the strip's own vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import demo_body as body
from demo_body import Array, Key

HALF = 14  # edges from the middle of the back over one side to the middle of the front
CROTCH = 4  # edges of the strip between the legs
HIP_RINGS, LEG_RINGS = 7, 21
WAIST_HEIGHT, CROTCH_HEIGHT, HEM_HEIGHT = 1.015, 0.765, 0.062  # metres
LEAST_ROOM, HIP_ROOM = 0.007, 0.005  # metres between cloth and body; what hangs from the waistband lies on the hips
UV_UNITS_PER_METRE = 0.74

# Height, half width, half depth, centre y: no wider than they hang. What is wider sinks to the body, and is pressed
# together around the hips: at rest that was a fold with a knob in the middle of the front.
HIPS = np.array([
    [0.775, 0.184, 0.118, 0.016],
    [0.840, 0.182, 0.119, 0.016],
    [0.910, 0.174, 0.115, 0.016],
    [0.960, 0.166, 0.111, 0.013],
    [1.015, 0.158, 0.108, 0.010],
])
# Height, centre x, centre y, radius.
LEG = np.array([
    [0.062, 0.108, 0.004, 0.083],
    [0.120, 0.107, 0.012, 0.081],
    [0.300, 0.104, 0.012, 0.083],
    [0.485, 0.101, 0.000, 0.087],
    [0.640, 0.095, 0.004, 0.091],
    [0.765, 0.092, 0.014, 0.102],
])


@dataclass
class TrousersMesh:
    """Arrays of the finished trousers."""

    points: Array  # (n, 3) metres
    quads: Array  # (m, 4) vertex indices, normals outward
    uvs: Array  # (m, 4, 2) one per corner


def vertex_name(key: Key) -> Key:
    """The vertex behind a corner. Columns of the hips go around from the middle of the back over the left side; those
    of a leg begin there as well, go over its own side to the front and back along the crotch."""
    part, ring, column = key
    if part == "hips":
        return part, ring, column % (2 * HALF)
    column %= HALF + CROTCH
    if ring > 0:
        return part, ring, column
    if column <= HALF:
        return "hips", HIP_RINGS, column if part == "left" else -column % (2 * HALF)
    return "crotch", 0, column - HALF


def cells_of(part: str, rings: int, columns: int, flip: bool) -> list[list[Key]]:
    """Cells of a tube that grows downwards."""
    cells = [[(part, ring, j), (part, ring, j + 1), (part, ring + 1, j + 1), (part, ring + 1, j)]
             for ring in range(rings) for j in range(columns)]
    return [cell[::-1] for cell in cells] if flip else cells


def all_cells() -> list[list[Key]]:
    """Every quad as four corners, counterclockwise seen from outside."""
    return (cells_of("hips", HIP_RINGS, 2 * HALF, False) + cells_of("left", LEG_RINGS, HALF + CROTCH, False)
            + cells_of("right", LEG_RINGS, HALF + CROTCH, True))


def initial_point(key: Key) -> Array:
    """Rough position of a vertex, to be relaxed."""
    part, ring, column = key
    if part == "crotch":
        share = column / CROTCH
        return np.array([0.0, -0.095 + 0.205 * share, CROTCH_HEIGHT - 0.02 * np.sin(np.pi * share)])
    if part == "hips":
        height = WAIST_HEIGHT + (CROTCH_HEIGHT + 0.02 - WAIST_HEIGHT) * ring / HIP_RINGS
        wide, deep, middle = (body.smooth_interpolation(np.array(height), HIPS[:, 0], HIPS[:, k]) for k in (1, 2, 3))
        angle = np.pi * column / HALF
        return np.array([wide * np.sin(angle), middle + deep * np.cos(angle), height])
    height = CROTCH_HEIGHT + (HEM_HEIGHT - CROTCH_HEIGHT) * ring / LEG_RINGS
    x, y, radius = (body.smooth_interpolation(np.array(height), LEG[:, 0], LEG[:, k]) for k in (1, 2, 3))
    # The ends of the crotch strip stand at 40 degrees to the inside of the leg.
    inner = np.radians(40.0)
    angle = (inner + (2.0 * np.pi - 2.0 * inner) * column / HALF if column <= HALF
             else -inner + 2.0 * inner * (column - HALF) / CROTCH)
    side = 1.0 if part == "left" else -1.0
    return np.array([side * (x - radius * np.cos(angle)), y + radius * np.sin(angle), height])


def relax(points: Array, edges: Array, fixed: Array) -> Array:
    """Even out the cloth, never nearer to the body than its room."""
    for _ in range(8):
        moved = points + 0.5 * (body.neighbour_average(points, edges) - points)
        moved[fixed] = points[fixed]
        points = moved
    return away_from_body(points)


def away_from_body(points: Array) -> Array:
    """Move what is too near to the body outwards."""
    room = np.interp(points[:, 2], (CROTCH_HEIGHT, CROTCH_HEIGHT + 0.05), (LEAST_ROOM, HIP_ROOM))
    for _ in range(4):
        short = np.maximum(room - body.body_distance(points), 0.0)
        gradient = body.distance_gradient(points, body.body_distance)
        points = points + short[:, None] * gradient / np.maximum(np.linalg.norm(gradient, axis=1), 0.2)[:, None]
    return points


def build_trousers() -> TrousersMesh:
    """Topology, relaxed positions and UVs."""
    cells = all_cells()
    number, quads = body.number_vertices(cells, vertex_name)
    points = np.array([initial_point(key) for key in number])
    fixed = np.array([key[0] == "crotch" or (key[1] < 4 if key[0] == "hips" else key[1] >= 4) for key in number])
    points = np.round(relax(points, body.edges_of_quads(quads), fixed), 6)
    return TrousersMesh(points, quads, cell_uvs(cells, points, number))


def cell_uvs(cells: list[list[Key]], points: Array, number: dict[Key, int]) -> Array:
    """UVs (m, 4, 2): hips and legs are an island each, columns across, heights along, in the cloth's own measures."""
    origin = {"hips": (0.03, 1.02), "left": (0.03, 0.25), "right": (0.70, 0.25)}
    across = {"hips": 1.06 / (2 * HALF), "left": 0.58 / (HALF + CROTCH), "right": 0.58 / (HALF + CROTCH)}

    def corner(key: Key) -> Array:
        part, _, column = key
        height = points[number[vertex_name(key)], 2] - (CROTCH_HEIGHT if part == "hips" else 0.0)
        return UV_UNITS_PER_METRE * np.array([origin[part][0] + across[part] * column, origin[part][1] + height])

    return np.array([[corner(key) for key in cell] for cell in cells])
