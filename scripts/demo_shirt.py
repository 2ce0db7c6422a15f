# SPDX-License-Identifier: GPL-3.0-or-later
"""The shirt of the demo scene: one coarse quad mesh with pattern-like UVs.

Pure NumPy, no Blender; space as in demo_body. The mesh is two panels, sewn
at the sides and the shoulders, two sleeves and a collar:

    front and back: rows from the hem up, columns from -HALF_COLUMNS to
    HALF_COLUMNS; above ARMPIT_ROW the outermost column of either panel is cut
    away, and the rim of that hole, fourteen edges, is the first ring of a sleeve;
    the collar grows in the same way from the rim of the neck hole.

Only the corners of these holes are irregular (valence 5), two at each armpit
and four at the neck. Positions come from relaxing the mesh on a looser twin of
the body's distance function.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

import numpy as np

import demo_body as body
from demo_body import Array, Key

HALF_COLUMNS = 7  # columns of a panel from its centre to the side seam
ARMPIT_ROW = 11
SHOULDER_ROW = 17
NECK_HALF_COLUMNS = 3
NECK_ROW = {"front": 15, "back": 16}  # lowest row of the neck hole
COLLAR_ROWS = 2
COLLAR_HEIGHT = 0.038
SLEEVE_RINGS = 16
CUFF_RINGS = 2
HEM_HEIGHT = 0.895
CUFF_END = body.UPPER_ARM_LENGTH + body.FOREARM_LENGTH + 0.012  # metres from the shoulder
CUFF_LENGTH = 0.056
ARMHOLE_CENTRE = np.array([0.201, 0.008, 1.365])
ARMHOLE_DOWN = np.array([0.06, 0.0, -0.998])  # from the shoulder to the armpit
UV_UNITS_PER_METRE = 0.74

# Rows as in demo_body.BODY_TORSO.
SHIRT_TORSO = np.array([
    [0.80, 0.200, 0.144, 0.012],
    [0.90, 0.198, 0.143, 0.012],
    [1.00, 0.189, 0.136, 0.010],
    [1.10, 0.182, 0.130, 0.006],
    [1.20, 0.183, 0.133, 0.002],
    [1.30, 0.188, 0.138, -0.002],
    [1.37, 0.186, 0.132, 0.002],
    [1.43, 0.163, 0.110, 0.012],
    [1.475, 0.114, 0.090, 0.021],
    [1.52, 0.072, 0.074, 0.021],
])


@dataclass
class ShirtMesh:
    """Arrays of the finished shirt."""

    points: Array  # (n, 3) metres
    quads: Array  # (m, 4) vertex indices, normals outward
    uvs: Array  # (m, 4, 2) one per corner
    is_trim: Array  # (m,) bool: cuffs and collar
    seams: set[tuple[int, int]]  # sorted vertex pairs where the UVs are cut


def shirt_distance(points: Array) -> Array:
    """Distance to the smooth surface that the shirt lies on."""
    p = points.copy()
    p[..., 0] = np.abs(p[..., 0])
    end = body.SHOULDER + CUFF_END * body.ARM_DIRECTION
    d = body.torso_distance(p, SHIRT_TORSO)
    yoke = body.round_cone(p, np.array([0.05, 0.020, 1.452]), body.SHOULDER, 0.064, 0.068)
    d = body.smooth_union(d, yoke, 0.05)
    sleeve = np.minimum(body.round_cone(p, body.SHOULDER, body.ELBOW, 0.068, 0.065),
                        body.round_cone(p, body.ELBOW, end, 0.065, 0.055))
    return body.smooth_union(d, sleeve, 0.075)


def canonical(key: Key) -> Key:
    """One name for vertices that two panels share at side or shoulder."""
    part, row, column = key
    if part == "back" and (abs(column) == HALF_COLUMNS or row == SHOULDER_ROW):
        return ("front", row, column)
    return key


def armhole(sign: int) -> list[Key]:
    """Rim of an armhole from the armpit over the front and the shoulder to the back."""
    inner = sign * (HALF_COLUMNS - 1)
    up = [("front", row, inner) for row in range(ARMPIT_ROW, SHOULDER_ROW + 1)]
    down = [("back", row, inner) for row in range(SHOULDER_ROW - 1, ARMPIT_ROW - 1, -1)]
    return [("front", ARMPIT_ROW, sign * HALF_COLUMNS)] + up + down


def neck_hole() -> list[Key]:
    """Rim of the neck from the middle of the back over the left side to the front."""
    n = NECK_HALF_COLUMNS
    back, front = NECK_ROW["back"], NECK_ROW["front"]
    left = [("back", back, i) for i in range(0, n + 1)]
    left += [("back", row, n) for row in range(back + 1, SHOULDER_ROW)]
    left += [("front", row, n) for row in range(SHOULDER_ROW, front - 1, -1)]
    left += [("front", front, i) for i in range(n - 1, 0, -1)]
    right = [(part, row, -i) for part, row, i in reversed(left[1:])]
    return left + [("front", front, 0)] + right


def panel_cells(part: str) -> list[list[Key]]:
    """Cells of a front or back panel, corners counterclockwise seen from outside."""
    cells = []
    for row in range(SHOULDER_ROW):
        half = HALF_COLUMNS if row < ARMPIT_ROW else HALF_COLUMNS - 1
        for i in range(-half, half):
            in_neck = row >= NECK_ROW[part] and -NECK_HALF_COLUMNS <= i < NECK_HALF_COLUMNS
            if in_neck:
                continue
            cell = [(part, row, i), (part, row, i + 1), (part, row + 1, i + 1), (part, row + 1, i)]
            cells.append(cell if part == "front" else cell[::-1])
    return cells


def tube_cells(part: str, rim: list[Key], rings: int, flip: bool) -> list[list[Key]]:
    """Cells of a tube grown from a rim; ring 0 keeps the names (part, 0, j)."""
    count = len(rim)
    cells = []
    for ring in range(rings):
        for j in range(count):
            cell = [(part, ring, j), (part, ring, j + 1), (part, ring + 1, j + 1),
                    (part, ring + 1, j)]
            cells.append(cell[::-1] if flip else cell)
    return cells


TUBES = {  # part: rim, rings, whether the winding is reversed
    "sleeve_left": (armhole(1), SLEEVE_RINGS, True),
    "sleeve_right": (armhole(-1), SLEEVE_RINGS, False),
    "collar": (neck_hole(), COLLAR_ROWS, True),
}


def vertex_name(key: Key) -> Key:
    """The vertex behind a cell corner: closes tubes and joins them to their rims."""
    part, row, column = key
    if part in TUBES:
        rim = TUBES[part][0]
        column %= len(rim)
        return canonical(rim[column]) if row == 0 else (part, row, column)
    return canonical(key)


def all_cells() -> list[list[Key]]:
    """Every quad of the shirt as four corner keys."""
    cells = panel_cells("front") + panel_cells("back")
    for part, (rim, rings, flip) in TUBES.items():
        cells += tube_cells(part, rim, rings, flip)
    return cells


def sleeve_station(ring: int) -> tuple[float, float]:
    """Distance along the arm from the shoulder and radius of a sleeve ring."""
    cuff_start = SLEEVE_RINGS - CUFF_RINGS
    if ring >= cuff_start:
        t = (ring - cuff_start) / CUFF_RINGS
        return CUFF_END - CUFF_LENGTH * (1.0 - t), 0.0465 - 0.0025 * t
    t = ring / (cuff_start - 0.35)
    return 0.03 + t * (CUFF_END - CUFF_LENGTH - 0.03), 0.07


def collar_point(row: int, angle: float) -> Array:
    """Point of the stand collar; angle 0 is the nape, pi/2 the left side.

    Row 0 lies on the shirt's surface; the rows above lean to the neck.
    """
    front = 0.5 - 0.5 * np.cos(angle)
    radial = np.array([np.sin(angle), np.cos(angle), 0.0])
    start = np.array([0.0, 0.016 - 0.014 * front, 1.508 - 0.056 * front]) + 0.086 * radial
    base = body.project_to_surface(start[None], shirt_distance, steps=8)[0]
    height = COLLAR_HEIGHT * row / COLLAR_ROWS
    return base + height * (np.array([0.0, -0.15, 1.0]) - (0.12 + 0.25 * front) * radial)


def armhole_points() -> Array:
    """Seam of the left sleeve, evenly spaced, in the order of armhole().

    It is where rays in the plane of the armhole leave the shirt's surface.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 145)[:, None]
    rays = np.cos(angles) * ARMHOLE_DOWN + np.sin(angles) * body.THUMB_DIRECTION
    reach = np.zeros(len(rays))
    for step in 0.125 * 0.5 ** np.arange(20):
        further = shirt_distance(ARMHOLE_CENTRE + (reach + step)[:, None] * rays) < 0.0
        reach += step * further
    curve = ARMHOLE_CENTRE + reach[:, None] * rays
    halves = []
    for half in (curve[:73], curve[72:]):
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(half, axis=0), axis=1))])
        stations = np.linspace(0.0, length[-1], len(armhole(1)) // 2 + 1)[:-1]
        halves.append(np.stack([np.interp(stations, length, half[:, k]) for k in range(3)], axis=1))
    return np.concatenate(halves)


def initial_point(key: Key) -> Array:
    """Rough position of a vertex, to be relaxed."""
    part, row, column = key
    if part == "collar":
        return collar_point(row, 2.0 * np.pi * column / len(TUBES[part][0]))
    if part in TUBES:
        side = 1.0 if part == "sleeve_left" else -1.0
        along, radius = sleeve_station(row)
        angle = 2.0 * np.pi * column / len(TUBES[part][0])
        inward = np.array([body.ARM_DIRECTION[2], 0.0, -body.ARM_DIRECTION[0]])
        p = (body.SHOULDER + along * body.ARM_DIRECTION
             + radius * (np.cos(angle) * inward + np.sin(angle) * body.THUMB_DIRECTION))
        return p * np.array([side, 1.0, 1.0])
    depth = -0.13 if part == "front" else 0.13
    if row == SHOULDER_ROW:
        return np.array([0.035 * column, 0.015, 1.52 - 0.012 * abs(column)])
    z = HEM_HEIGHT + (1.47 - HEM_HEIGHT) * row / SHOULDER_ROW
    angle = 0.5 * np.pi * column / HALF_COLUMNS
    return np.array([0.2 * np.sin(angle), depth * np.cos(angle), z])


def hem_height(x: Array) -> Array:
    """Shirt tails: the hem rises a little at the side seams."""
    return HEM_HEIGHT + 0.022 * (x / 0.2) ** 4


def relax(points: Array, edges: Array, fixed: Array, hem: Array) -> Array:
    """Even out the edges on the surface of shirt_distance.

    Every edge pulls in proportion to its length, so that long ones shorten first.
    Fixed points stay; hem points slide at the height of the hem.
    """
    for step in range(400):
        pull = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1) + 0.005
        moved = points + 0.6 * (body.neighbour_average(points, edges, pull) - points)
        if step % 4 == 3:
            moved = body.project_to_surface(moved, shirt_distance, steps=1)
        moved[fixed] = points[fixed]
        moved[hem, 2] = hem_height(moved[hem, 0])
        points = moved
    free = ~fixed
    points[free] = body.project_to_surface(points[free], shirt_distance)
    points[hem, 2] = hem_height(points[hem, 0])
    return points


def build_shirt() -> ShirtMesh:
    """Topology, relaxed positions, UVs, materials and seams of the shirt."""
    cells = all_cells()
    number, quads = body.number_vertices(cells, vertex_name)
    points = np.array([initial_point(key) for key in number])
    for j, key in enumerate(TUBES["collar"][0]):
        points[number[canonical(key)]] = collar_point(0, 2.0 * np.pi * j / len(neck_hole()))
    for sign in (1, -1):
        for key, point in zip(armhole(sign), armhole_points()):
            points[number[canonical(key)]] = point * (sign, 1, 1)
    fixed = np.array([is_fixed(key) for key in number])
    hem = np.array([key[0] in ("front", "back") and key[1] == 0 for key in number])
    points = np.round(relax(points, body.edges_of_quads(quads), fixed, hem), 6)
    uvs = cell_uvs(cells, lambda key: points[number[vertex_name(key)]])
    return ShirtMesh(points, quads, uvs, np.array([is_trim_cell(cell) for cell in cells]),
                     uv_seams(quads, uvs))


def is_fixed(key: Key) -> bool:
    """Whether relaxation leaves a vertex where it is: collar, its rim and cuffs."""
    part, row, _ = key
    if part == "collar":
        return True
    if part in TUBES:
        return row >= SLEEVE_RINGS - CUFF_RINGS
    return key in {canonical(rim) for rim in neck_hole()}


def is_trim_cell(cell: list[Key]) -> bool:
    """Whether a cell belongs to collar or cuff."""
    part = cell[0][0]
    return part == "collar" or (part.startswith("sleeve")
                                and min(k[1] for k in cell) >= SLEEVE_RINGS - CUFF_RINGS)


def strip_uvs(rows: dict[int, list[int]], centre: int, position: Callable[..., Array]) -> dict[tuple[int, int], Array]:
    """Lay rows of vertices flat: arc length along each row, mean spacing between rows.

    rows lists the columns present in each row; position(row, column) is a point.
    """
    uvs: dict[tuple[int, int], Array] = {}
    height = 0.0
    for row in sorted(rows):
        if row > min(rows):
            shared = [c for c in rows[row] if c in rows[row - 1]]
            height += float(np.mean([np.linalg.norm(position(row, c) - position(row - 1, c))
                                     for c in shared]))
        for sign in (1, -1):
            length, previous = 0.0, centre
            for column in sorted((c for c in rows[row] if (c - centre) * sign >= 0),
                                 key=lambda c: abs(c - centre)):
                length += np.linalg.norm(position(row, column) - position(row, previous))
                uvs[row, column] = np.array([sign * length, height])
                previous = column
    return uvs


def island_origin(part: str) -> Array:
    """Centre of the lower edge of a part's UV island, in metres of cloth."""
    return np.array({"front": (0.32, 0.02), "back": (0.98, 0.02), "sleeve_left": (0.32, 0.69),
                     "sleeve_right": (0.98, 0.69), "collar": (0.65, 1.29)}[part])


def cell_uvs(cells: list[list[Key]], position: Callable[..., Array]) -> Array:
    """UVs of all corners; every part is one island, laid out like a sewing pattern."""
    corners: dict[str, dict[int, set[int]]] = {}
    for part, row, column in (key for cell in cells for key in cell):
        corners.setdefault(part, {}).setdefault(row, set()).add(column)
    flat: dict[Key, Array] = {}
    for part, rows in corners.items():
        centre = len(TUBES[part][0]) // 2 if part in TUBES else 0
        if part not in TUBES:  # measure across the neck hole, too
            rows = {r: cols | {0} for r, cols in rows.items()}
        placed = strip_uvs({r: sorted(c) for r, c in rows.items()}, centre,
                           lambda row, column, p=part: bridged(p, row, column, position))
        mirror = -1.0 if part == "back" or (part in TUBES and TUBES[part][2]) else 1.0
        for (row, column), uv in placed.items():
            flat[part, row, column] = (uv * (mirror, 1.0) + island_origin(part)) * UV_UNITS_PER_METRE
    return np.array([[flat[key] for key in cell] for cell in cells])


def bridged(part: str, row: int, column: int, position: Callable[..., Array]) -> Array:
    """Position of a corner; the missing column 0 of a neck row is the middle of the gap."""
    if column == 0 and part in NECK_ROW and row > NECK_ROW[part]:
        n = NECK_HALF_COLUMNS
        return 0.5 * (position((part, row, n)) + position((part, row, -n)))
    return position((part, row, column))


def uv_seams(quads: Array, uvs: Array) -> set[tuple[int, int]]:
    """Edges whose two faces disagree about the UV of an end."""
    seen: dict[tuple[int, int], dict[int, Array]] = {}
    seams = set()
    for quad, corners in zip(quads.tolist(), uvs):
        for k in range(4):
            a, b = quad[k], quad[(k + 1) % 4]
            edge = (min(a, b), max(a, b))
            here = {a: corners[k], b: corners[(k + 1) % 4]}
            there = seen.setdefault(edge, here)
            if any(np.abs(here[v] - there[v]).max() > 1e-6 for v in edge):
                seams.add(edge)
    return seams
