# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps between a mesh that is not an oriented manifold and its healed copy, which is solved. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..base.vertices import pair_keys

# By kind of repair: the kind of elements, the message about one element, {1}, and the message about {1} elements, of
# which the first is {2}. {0}: the object.
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

    vertex_count: int  # of the artist's mesh; the healed mesh begins with these vertices
    corner_count: int
    vertex: np.ndarray  # (n,) int32
    corner: np.ndarray  # (c,) int32
    polygon: np.ndarray  # (p,) int32
    copies: list["Copies"]  # faces that lie on other faces
    elements: dict[str, np.ndarray] = field(default_factory=dict)  # what was healed, in the artist's numbering

    def kinds(self) -> list[str]:
        """The kinds of repairs that were made."""
        return [kind for kind in SENTENCES if len(self.elements[kind])]

    def notes(self, name: str) -> list[str]:
        """A sentence for each kind of repair. name: of the object."""
        return [_sentence(name, kind, self.elements[kind]) for kind in self.kinds()]


@dataclass(frozen=True)
class Copies:
    """Faces that lie on other faces, no two on the same one. They show the wrinkles of the face below."""

    corner: np.ndarray  # (c,) int32: for every healed corner the copy's corner at this place, or its own
    polygon: np.ndarray  # (k,) int32, the artist's
    lies_on: np.ndarray  # (k,) int32, healed
    is_turned: np.ndarray  # (k,) bool: it faces the other way


def origin_of_itself(vertices: int, polygons: int, corners: int) -> Origin:
    """The origin of a mesh that was not changed."""
    vertex, corner, polygon = (np.arange(count, dtype=np.int32) for count in (vertices, corners, polygons))
    return Origin(vertices, corners, vertex, corner, polygon, [], {kind: np.empty(0, np.int32) for kind in SENTENCES})


def origin_of(healed: Any, polygon_start: np.ndarray, corner_vertex: np.ndarray, vertex_count: int) -> Origin:
    """The origin from a native HealedMesh and the mesh that it was made from."""
    elements = {TURNED: healed.turned, CUT: healed.cut, DOUBLED: healed.doubled[:, 0], REPEATED: healed.repeated}
    return Origin(vertex_count, len(corner_vertex), healed.vertex_source, healed.corner_source, healed.polygon_source,
                  _copies(healed, polygon_start, corner_vertex), elements)


def creases_of(edge: np.ndarray, sharpness: np.ndarray, origin: Origin,
               sides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Creases of the artist's mesh, (k, 2) vertices and (k,) sharpness -> of the healed mesh. sides: (c, 2) int32, the
    vertices of the healed polygons' sides."""
    keys, wanted = (pair_keys(pairs, origin.vertex_count) for pairs in (edge, origin.vertex[sides]))
    order = np.argsort(keys, kind="stable")
    place = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(order) - 1)] if len(order) else wanted
    found = np.flatnonzero(keys[place] == wanted) if len(order) else np.empty(0, np.int64)
    return np.ascontiguousarray(sides[found], np.int32), np.ascontiguousarray(sharpness[place[found]], np.float32)


def _copies(healed: Any, polygon_start: np.ndarray, corner_vertex: np.ndarray) -> list[Copies]:
    """The doubled faces in groups, so that no two faces of a group lie on the same face."""
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
    """The message about a repair. An element is a number, or two numbers for an edge."""
    _domain, of_one, of_several = SENTENCES[kind]
    first = "-".join(str(number) for number in np.atleast_1d(elements[0]).tolist())
    return of_one.format(name, first) if len(elements) == 1 else of_several.format(name, len(elements), first)
