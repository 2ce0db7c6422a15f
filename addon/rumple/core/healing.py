# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that are no oriented manifold: solved on a healed copy, shown as they are. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .vertices import pair_keys

# What was healed: the kind of its elements, and what to say of one, {1}, and of {1} of them, the first of which is {2}.
# {0}: the object.
TURNED, CUT, DOUBLED, REPEATED = "turned", "cut", "doubled", "repeated"
SENTENCES: dict[str, tuple[str, str, str]] = {
    TURNED: ("FACE", "{0}: face {1} faces the other way than those beside it, or inwards: turned for the wrinkles",
             "{0}: each of {1} faces (the first is face {2}) faces the other way than those beside it, or inwards: "
             "turned for the wrinkles"),
    CUT: ("EDGE", "{0}: edge {1} has more faces than two, or none that faces the same way: wrinkles end there",
          "{0}: each of {1} edges (the first is edge {2}) has more faces than two, or none that faces the same way: "
          "wrinkles end there"),
    DOUBLED: ("FACE", "{0}: face {1} lies on another face: it gets the same wrinkles",
              "{0}: each of {1} faces (the first is face {2}) lies on another face: it gets the same wrinkles"),
    REPEATED: ("FACE", "{0}: face {1} uses a vertex twice: it hangs at one corner less",
               "{0}: each of {1} faces (the first is face {2}) uses a vertex twice: it hangs at one corner less"),
}


@dataclass(frozen=True)
class Origin:
    """Where the elements of a healed mesh come from. n vertices, p polygons, c corners."""

    vertex_count: int  # of the mesh as the artist has it: the first of the healed ones
    corner_count: int
    vertex: np.ndarray  # (n,) int32
    corner: np.ndarray  # (c,) int32
    polygon: np.ndarray  # (p,) int32
    copies: list["Copies"]  # of faces that lie on others
    elements: dict[str, np.ndarray] = field(default_factory=dict)  # what was healed, in the artist's numbering

    def kinds(self) -> list[str]:
        """Of what was healed."""
        return [kind for kind in SENTENCES if len(self.elements[kind])]

    def notes(self, name: str) -> list[str]:
        """A sentence for each of the kinds. name: of the object."""
        return [_sentence(name, kind, self.elements[kind]) for kind in self.kinds()]


@dataclass(frozen=True)
class Copies:
    """Faces that lie on others, no two on the same: they show the wrinkles of those."""

    corner: np.ndarray  # (c,) int32: of every healed corner the copy's corner there; where there is no copy its own
    polygon: np.ndarray  # (k,) int32, the artist's
    lies_on: np.ndarray  # (k,) int32, healed
    is_turned: np.ndarray  # (k,) bool: it faces the other way


def origin_of_itself(vertices: int, polygons: int, corners: int) -> Origin:
    """Of a mesh that is as the artist has it."""
    vertex, corner, polygon = (np.arange(count, dtype=np.int32) for count in (vertices, corners, polygons))
    return Origin(vertices, corners, vertex, corner, polygon, [], {kind: np.empty(0, np.int32) for kind in SENTENCES})


def origin_of(healed: Any, polygon_start: np.ndarray, corner_vertex: np.ndarray, vertex_count: int) -> Origin:
    """Of a native HealedMesh, and the mesh that it was made from."""
    elements = {TURNED: healed.turned, CUT: healed.cut, DOUBLED: healed.doubled[:, 0], REPEATED: healed.repeated}
    return Origin(vertex_count, len(corner_vertex), healed.vertex_source, healed.corner_source, healed.polygon_source,
                  _copies(healed, polygon_start, corner_vertex), elements)


def creases_of(edge: np.ndarray, sharpness: np.ndarray, origin: Origin,
               sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Creases of the mesh as the artist has it, (k, 2) vertices and (k,), -> of the healed one. sides: (c, 2) int32,
    the vertices of the healed polygons' sides."""
    keys, wanted = (pair_keys(pairs, origin.vertex_count) for pairs in (edge, origin.vertex[sides]))
    order = np.argsort(keys, kind="stable")
    place = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(order) - 1)] if len(order) else wanted
    found = np.flatnonzero(keys[place] == wanted) if len(order) else np.empty(0, np.int64)
    return np.ascontiguousarray(sides[found], np.int32), np.ascontiguousarray(sharpness[place[found]], np.float32)


def _copies(healed: Any, polygon_start: np.ndarray, corner_vertex: np.ndarray) -> list[Copies]:
    """In as many groups as the most faces that lie on one."""
    place = np.searchsorted(healed.polygon_source, healed.doubled[:, 1])
    groups: list[list[tuple[int, int]]] = []
    seen: dict[int, int] = {}
    for (copy, original), kept in zip(healed.doubled.tolist(), place.tolist()):
        number = seen[original] = seen.get(original, -1) + 1
        if number == len(groups):
            groups.append([])
        groups[number].append((copy, kept))
    return [_copies_of(group, healed, polygon_start, corner_vertex) for group in groups]


def _copies_of(group: list[tuple[int, int]], healed: Any, polygon_start: np.ndarray,
               corner_vertex: np.ndarray) -> Copies:
    corner, turned = healed.corner_source.copy(), []
    for copy, kept in group:
        own = range(polygon_start[copy], polygon_start[copy + 1])
        at = {int(corner_vertex[c]): c for c in own}
        for c in range(healed.polygon_start[kept], healed.polygon_start[kept + 1]):
            corner[c] = at[int(healed.vertex_source[healed.corner_vertex[c]])]
        first = healed.polygon_start[kept]
        turned.append(int(corner[first + 1]) != own[(corner[first] + 1 - own[0]) % len(own)])
    copies, kept_ones = zip(*group)
    return Copies(corner, np.array(copies, np.int32), np.array(kept_ones, np.int32), np.array(turned, bool))


def _sentence(name: str, kind: str, elements: np.ndarray) -> str:
    """Elements are numbers, or for edges two."""
    _domain, of_one, of_several = SENTENCES[kind]
    first = "-".join(str(number) for number in np.atleast_1d(elements[0]).tolist())
    return of_one.format(name, first) if len(elements) == 1 else of_several.format(name, len(elements), first)
