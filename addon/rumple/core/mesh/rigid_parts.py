# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a mesh that are not cloth, and their motion. They keep their modelled shape. Buttons, buckles and pouches
follow the cloth around them. Skin and helmets follow the animation only. Caps that were cut from cloth follow it too,
and stay joined at the cut. Never imports bpy."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...native import kernels
from ..base.triangles import columnwise, corner_weights, frames_of, rowwise
from ..base.vertices import nearest_of, places, sample_of
from .body import OwnSkin
from .frame_result import Attribute, FrameResult

FAR = 0.02  # distance / diagonal of the cloth: parts farther away are not attached to the cloth
FEWEST_ANCHORS, MOST_ANCHORS = 8, 64
FEWEST_ON_SEAM = 3  # least number of common vertices that attach a cap


@dataclass(frozen=True)
class RigidParts:
    """All rigid parts of a mesh. m vertices, e edges, k polygons, c corners. Vertex numbers are those of the mesh that
    the parts were removed from."""

    part: np.ndarray  # (m,) int32: number of its part
    is_skin: np.ndarray  # (parts,) bool
    stays: np.ndarray  # (parts,) bool: it follows the animation only, like skin
    skin: OwnSkin  # all skin parts together
    vertex: np.ndarray  # (m,) int32
    triangle: np.ndarray  # (m, 3) int32: a triangle that begins with this vertex
    edges: np.ndarray  # (e, 2) int32: rows of `vertex`
    polygon: np.ndarray  # (k,) int32, the artist's numbers
    polygon_size: np.ndarray  # (k,)
    corner: np.ndarray  # (c,) int32, the artist's numbers
    corner_vertex: np.ndarray  # (c,) int32: row of `vertex`

    @property
    def count(self) -> int:
        """Number of parts."""
        return len(self.is_skin)

    def lines(self) -> list[str]:
        """Lines about the parts, for the status."""
        riding, solid, skin = (int(of.sum()) for of in (~self.stays, self.stays & ~self.is_skin, self.is_skin))
        return [line for count, line in (
            (riding, f"Rigid parts that ride on the cloth: {riding}"),
            (solid, f"Solid parts that stay as they are animated: {solid}"),
            (skin, f"Parts that are skin and stay as they are animated: {skin}")) if count]


@dataclass(frozen=True)
class _Cap:
    """A part that was cut from the cloth, so that both share an edge. The edge follows the cloth, and the rest of the
    cap follows the edge."""

    part: int
    rows: np.ndarray  # (k,) its vertices, as rows of RigidParts
    shares: np.ndarray  # (k, a) weights of its anchors; the sum for each vertex is 1


class AttachedParts:
    """The rigid parts of one shown mesh, and their anchors: the shown vertices that are nearest to each part at rest.
    Skin and parts far from cloth have no anchors. They follow the animation only."""

    def __init__(self, positions: np.ndarray, size: float, parts: RigidParts, shown: kernels.ShownMesh) -> None:
        """positions: (n, 3) float32 of the coarse mesh at rest. size: diagonal of the cloth. shown: of the cloth."""
        self.parts = parts
        cloth = np.unique(shown.corner_vertex)
        rest, place = shown.positions_rest[cloth], places(positions)
        on_seam = np.isin(place[parts.vertex], place[np.unique(shown.triangle_vertex[cloth])])
        found, self._caps = [], []
        for part, stays in enumerate(parts.stays):
            own = np.flatnonzero(parts.part == part)
            seam = positions[parts.vertex[own[on_seam[own]]]]
            if stays:
                found.append(cloth[:0])
            elif len(seam) < FEWEST_ON_SEAM:
                found.append(cloth[_anchors(positions[parts.vertex[own]], rest, size)])
            else:
                found.append(cloth[_around(seam, rest)])
                self._caps.append(_Cap(part, own, _shares(positions[parts.vertex[own]],
                                                          shown.positions_rest[found[-1]])))
        self._starts = np.cumsum([0, *(len(anchors) for anchors in found)], dtype=np.int32)
        self._anchors = np.concatenate(found)
        self._corners = shown.triangle_vertex[self._anchors]
        self._weights = corner_weights(shown)[self._anchors, :, None]
        # Offsets of the anchors from the flat triangles of the coarse mesh, in the triangles' frames. So they are valid
        # in every pose.
        frames, points = self._embedded(positions)
        self._from_base = rowwise(frames, shown.positions_rest[self._anchors] - points)

    def placed(self, animated: np.ndarray, cloth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions of the m vertices, and their offsets in the frames of their triangles of the animated mesh: (m, 3)
        each.

        animated: (n, 3) of the coarse mesh; cloth: (d, 3) of the shown mesh, both float32, object space. Each part gets
        the rigid motion that fits the motion of its anchors from the animated surface best. The edge of a cap is then
        moved onto the cut.
        """
        frames, points = self._embedded(animated)
        moved = self._moved(animated, points + columnwise(frames, self._from_base), cloth[self._anchors])
        return moved, rowwise(frames_of(animated, self.parts.triangle), moved - animated[self.parts.vertex])

    def displacements(self, animated: np.ndarray, over: np.ndarray) -> np.ndarray:
        """(m, 3): displacements by the base cloth alone, for frames without a shown mesh. over: (n, 3) the base
        cloth."""
        moved = self._moved(animated, self._embedded(animated)[1], self._embedded(over)[1])
        return moved - animated[self.parts.vertex]

    def _moved(self, animated: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        of_part = kernels.rigid_motions(self._starts, np.ascontiguousarray(before, np.float32),
                                        np.ascontiguousarray(after, np.float32))
        motions = of_part[self.parts.part]
        moved = rowwise(motions[:, :3], animated[self.parts.vertex]) + motions[:, 3]
        for cap in self._caps:
            anchors, motion = slice(self._starts[cap.part], self._starts[cap.part + 1]), of_part[cap.part]
            rigid = rowwise(np.broadcast_to(motion[:3], (len(before[anchors]), 3, 3)), before[anchors]) + motion[3]
            moved[cap.rows] += (cap.shares[:, :, None] * (after[anchors] - rigid)[None]).sum(1)
        return moved

    def add_to(self, result: FrameResult, animated: np.ndarray, corners: int,
               attributes: tuple[Attribute, ...]) -> None:
        """Append the parts to the result of the cloth. corners: of the whole shown mesh."""
        positions, local_offset = self.placed(animated, result.positions)
        rest = FrameResult.at_rest(positions, len(self.parts.corner_vertex), attributes).attributes
        result.positions = np.concatenate([result.positions, positions])
        result.local_offset = np.concatenate([result.local_offset, local_offset])
        for a in attributes:
            values = result.attributes[a.name]
            # else the values already include the corners of the rigid parts
            if a.domain == "POINT" or len(values) < corners:
                result.attributes[a.name] = np.concatenate([values, rest[a.name]])

    def _embedded(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Frames of the anchors' triangles, and the anchors' points on them."""
        corner = positions[self._corners]
        return frames_of(positions, self._corners), (self._weights * corner).sum(1)


def _around(seam: np.ndarray, cloth: np.ndarray) -> np.ndarray:
    """The rows of the cloth that are anchors of a cap: vertices all along the cut."""
    return np.unique(nearest_of(sample_of(seam, MOST_ANCHORS), cloth, np.arange(len(cloth)))[0])


def _shares(points: np.ndarray, anchors: np.ndarray) -> np.ndarray:
    """(k, a) float32: weights of anchors by inverse distance (Shepard 1968). The sum for each point is 1."""
    squared = ((points[:, None].astype(np.float64) - anchors[None]) ** 2).sum(2)
    near = 1.0 / np.maximum(squared, 1e-6 * squared.max() + 1e-30)
    return (near / near.sum(1, keepdims=True)).astype(np.float32)


def _anchors(part: np.ndarray, cloth: np.ndarray, size: float) -> np.ndarray:
    """The rows of the cloth that are anchors of a part. size: of the garment."""
    centre = part.mean(0)
    radius = float(np.linalg.norm(part - centre, axis=1).max())
    distance = np.linalg.norm(cloth - centre, axis=1)
    order = np.argsort(distance, kind="stable")[:MOST_ANCHORS]
    if not len(order) or distance[order[0]] > 2.0 * radius + FAR * size:
        return order[:0]
    near = max(int(np.searchsorted(distance[order], distance[order[0]] + radius)), FEWEST_ANCHORS)
    return order[:near]
