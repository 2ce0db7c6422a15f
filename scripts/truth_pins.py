# SPDX-License-Identifier: GPL-3.0-or-later
"""Where scripts/ground_truth holds a garment to its animated base: collar, waistband, cuffs. Pure NumPy.

A garment's borders are told apart at rest, the figure upright along z and symmetric in x.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from interpolation import smoothstep

HEM = 0.012  # metres: as far from a border the cloth lies double
FALLOFF = {"collar": 0.10}  # metres along the cloth, from the border's strength to nothing; the yoke is held, too
USUAL_FALLOFF = 0.05
STRENGTHS = {"collar": 0.9, "waistband": 0.9, "cuff": 0.8, "short sleeve": 0.3, "leg": 0.0, "hem": 0.0}


@dataclass
class Border:
    """One closed border of the garment."""

    vertices: np.ndarray  # (k,) indices, in order around
    centre: np.ndarray  # (3,) metres, at rest
    outward: np.ndarray  # (3,) unit: from the cloth over the border
    perimeter: float  # metres
    distance: float  # metres, mean to the nearest vertex of the body
    kind: str = ""
    strength: float = 0.0

    def line(self) -> str:
        """For the screen."""
        x, y, z = self.centre
        return (f"{self.kind:12} pinned {self.strength:.2f}  perimeter {1e3 * self.perimeter:4.0f} mm, "
                f"{1e3 * self.distance:3.0f} mm from the body, centre {x:.2f} {y:.2f} {z:.2f}")


def edges_of(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (e, 2), smaller index first, and how many triangles (e,) each has."""
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.unique(sides, axis=0, return_counts=True)


def border_loops(triangles: np.ndarray) -> list[np.ndarray]:
    """Vertices of every closed border, in order."""
    edges, counts = edges_of(triangles)
    neighbours: dict[int, list[int]] = {}
    for a, b in edges[counts == 1].tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    loops, seen = [], set()
    for start in neighbours:
        if start in seen:
            continue
        loop, here = [], start
        while here is not None:
            loop.append(here)
            seen.add(here)
            here = next((v for v in neighbours[here] if v not in seen), None)
        loops.append(np.array(loop))
    return loops


def along_cloth(rest: np.ndarray, triangles: np.ndarray, sources: np.ndarray, farthest: float) -> np.ndarray:
    """(n,) metres from the nearest source along edges; infinite beyond `farthest`."""
    edges, _ = edges_of(triangles)
    length = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    distance = np.full(len(rest), np.inf)
    distance[sources] = 0.0
    while True:
        before = distance.copy()
        for a, b in ((0, 1), (1, 0)):
            np.minimum.at(distance, edges[:, a], before[edges[:, b]] + length)
        distance[distance > farthest] = np.inf
        if np.array_equal(distance, before):
            return distance


def describe(rest: np.ndarray, triangles: np.ndarray, body: np.ndarray) -> list[Border]:
    """The garment's borders with their kinds. rest (n, 3), body (b, 3) metres."""
    borders = []
    for loop in border_loops(triangles):
        points = rest[loop]
        near = np.isfinite(along_cloth(rest, triangles, loop, 0.05))
        outward = points.mean(0) - rest[near].mean(0)
        around = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum()
        nearest = [np.sqrt(((body - p) ** 2).sum(1).min()) for p in points[::max(1, len(points) // 40)]]
        borders.append(Border(loop, points.mean(0), outward / np.linalg.norm(outward), float(around),
                              float(np.mean(nearest))))
    for border in borders:
        border.kind = kind_of(border, borders, rest)
        border.strength = STRENGTHS[border.kind]
    return borders


def kind_of(border: Border, borders: list[Border], rest: np.ndarray) -> str:
    """Upwards: collar, or waistband where the garment has legs. To a side: sleeves, short where the cuff is wide
    and loose. Downwards: a leg beside the middle, the hem in the middle."""
    middle = 0.5 * (rest[:, 0].min() + rest[:, 0].max())
    beside = [abs(b.centre[0] - middle) > 0.15 * b.perimeter for b in borders]
    if border.outward[2] > 0.6:
        legs = any(side and b.outward[2] < -0.8 for b, side in zip(borders, beside))
        return "waistband" if legs else "collar"
    if abs(border.centre[0] - middle) <= 0.15 * border.perimeter:
        return "hem"
    if border.outward[2] < -0.8:
        return "leg"
    return "cuff" if border.perimeter < 0.30 and border.distance < 0.02 else "short sleeve"


def hugging(rest: np.ndarray, triangles: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Vertices of the borders that lie close and are rolled in: all but hem and legs."""
    loops = [b.vertices for b in describe(rest, triangles, body) if b.kind not in ("hem", "leg")]
    return np.concatenate(loops) if loops else np.empty(0, int)


def choose(borders: list[Border], wish: str | None) -> None:
    """Apply --pin KIND=STRENGTH,...: another strength for a kind."""
    for part in (wish or "").split(","):
        if part:
            kind, strength = part.split("=")
            if kind not in STRENGTHS:
                raise SystemExit(f"--pin knows {', '.join(STRENGTHS)}, not {kind}")
            for border in borders:
                if border.kind == kind:
                    border.strength = float(strength)


def closed(rest: np.ndarray, triangles: np.ndarray, borders: list[Border]) -> np.ndarray:
    """(n,) whether a vertex is of a part of the mesh that has no border."""
    on_borders = np.concatenate([border.vertices for border in borders])
    return ~np.isfinite(along_cloth(rest, triangles, on_borders, np.inf))


@dataclass
class Hold:
    """Vertex weights, 0 to 1."""

    pins: np.ndarray  # (n,) float32: how much of the animated base's place is kept
    hems: np.ndarray  # (n,) float32: stiff


def hold(rest: np.ndarray, triangles: np.ndarray, borders: list[Border]) -> Hold:
    """Each border's strength, smoothly to nothing; the hems. Parts without a border, as a buckle, are held wholly."""
    pins, hems = np.zeros(len(rest), np.float32), np.zeros(len(rest), np.float32)
    for border in borders:
        falloff = FALLOFF.get(border.kind, USUAL_FALLOFF)
        away = along_cloth(rest, triangles, border.vertices, falloff)
        hems[away <= HEM] = 1.0
        pins = np.maximum(pins, border.strength * (1.0 - smoothstep(away / falloff)))
    if borders:
        pins[closed(rest, triangles, borders)] = 1.0
    return Hold(pins.astype(np.float32), hems)
