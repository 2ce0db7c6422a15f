# SPDX-License-Identifier: GPL-3.0-or-later
"""The paint Rigid: patches of a garment without folds or rounding, like a badge, a belt or a sole. Never imports bpy.

A patch has the shape of the posed coarse mesh, so a sole bends at the toes as it was skinned. The motion of the base
cloth is replaced by one rigid motion of the whole patch. A weight between 0 and 1 mixes both results.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...native import kernels
from ..base.triangles import columnwise, corner_weights, frames_of, rowwise
from ..base.vertices import places
from ..mesh.base_mesh import BaseMesh
from ..mesh.connected import lowest_connected, spokes
from ..mesh.frame_result import FrameResult
from ..mesh.shown_mesh import ShownMesh
from .keep_smooth import move

RIGID = "rigid"  # the paint: 1: rigid, 0: as without paint
WHOLE = 0.999  # a separate part of the mesh whose vertices all have at least this weight is not cloth at all
CORE = 0.5  # vertices with a lower weight belong to a patch, but do not determine its motion


def wholly_painted(base: BaseMesh, rigid: np.ndarray) -> np.ndarray | None:
    """(n,) bool: vertices of separate parts that are completely painted; None if there are none. rigid: (n,) paint of
    the artist's mesh."""
    whole = rigid >= WHOLE
    if not whole.any():
        return None
    first, other = spokes(base)
    part = lowest_connected(np.arange(len(rigid)), first, other)
    whole[np.isin(part, part[~whole])] = False
    return whole if whole.any() else None


def patches_of(rigid: np.ndarray, base: BaseMesh) -> np.ndarray:
    """(n,) int32: number of the patch of every vertex; -1 where nothing is painted. A patch is a connected set of
    vertices with a weight of CORE or more. Vertices with a lower weight belong to the nearest patch."""
    place = places(base.positions)
    first, other = (place[ends] for ends in spokes(base))
    sides = place[base.sides()]
    painted = np.zeros(len(rigid), np.float32)
    np.maximum.at(painted, place, rigid)  # the maximum of all vertices at one place
    none = len(rigid)
    label = np.full(none, none)
    for least in (CORE, float(np.finfo(np.float32).tiny)):  # then patches that have only low weights
        found = np.where((painted >= least) & (label == none), np.arange(none), none)
        inside = (found[first] < none) & (found[other] < none)
        found[found < none] = lowest_connected(np.arange(none), first[inside], other[inside])[found < none]
        label = np.minimum(label, found) if least == CORE else np.where(label < none, label, found)
        label = _spread(label, painted > 0.0, sides, none)
    used = np.zeros(none, bool)
    used[base.corner_vertex] = True
    label = np.where(used & (label[place] < none), label[place], none)
    numbers = np.unique(label[label < none])
    return np.where(label < none, np.searchsorted(numbers, label), -1).astype(np.int32)


def _spread(label: np.ndarray, allowed: np.ndarray, sides: np.ndarray, none: int) -> np.ndarray:
    """Spread labels along edges to allowed vertices without one. The lowest label wins."""
    while True:
        reached = label.copy()
        for one, other in ((0, 1), (1, 0)):
            np.minimum.at(reached, sides[:, one], label[sides[:, other]])
        new = (label == none) & (reached < none) & allowed
        if not new.any():
            return label
        label = np.where(new, reached, label)


@dataclass(frozen=True)
class _OnShown:
    """The painted vertices of one shown mesh, m of them."""

    rows: np.ndarray  # (m,)
    corners: np.ndarray  # (m, 3) base vertices
    weights: np.ndarray  # (m, 3, 1) weights of these vertices
    shares: np.ndarray  # (m, 3, 1): weight of the patches' motions, for each of these vertices
    share: np.ndarray  # (m,): the sum of them
    patch: np.ndarray  # (m, 3)
    from_base: np.ndarray | None  # (m, 3) of an artist's own fine mesh: offsets at rest, in the frames of the triangles


class PaintedRigid:
    """The paint Rigid of one base, for all frames."""

    def __init__(self, rigid: np.ndarray, base: BaseMesh) -> None:
        """rigid: (n,) paint of the base's vertices; NaN counts as 0."""
        self.base = base
        self.rigid = np.clip(np.nan_to_num(rigid, nan=0.0), 0.0, 1.0).astype(np.float32)
        self.patch = patches_of(self.rigid, base)
        core = np.flatnonzero(self.rigid >= CORE)
        self._core = [rows if len(rows) else np.flatnonzero(self.patch == number) for number in range(self.count)
                      for rows in (core[self.patch[core] == number],)]
        self._on: dict[kernels.ShownMesh, _OnShown] = {}  # by native output mesh

    @property
    def count(self) -> int:
        """Number of patches."""
        return int(self.patch.max(initial=-1)) + 1

    def left(self) -> np.ndarray:
        """(n,) share of the folds that is left."""
        return np.float32(1.0) - self.rigid

    def add_to(self, result: FrameResult, mesh: ShownMesh, animated: np.ndarray, over: np.ndarray,
               heights: tuple[str, ...]) -> None:
        """Apply it to a result. mesh: of the result, without its rigid parts. animated: (n, 3) of the base, object
        space. over: the same on the base cloth, or the coarse mesh in place of the base. heights: names of the
        attributes that contain the height of folds."""
        on = self._on_shown(mesh)
        corner = animated[on.corners]
        points = (on.weights * corner).sum(1)
        if on.from_base is not None:
            points = points + columnwise(frames_of(animated, on.corners), on.from_base)
        motions = self._motions(animated, over, result, on)
        at, displacements = result.positions[on.rows], np.zeros_like(points)
        for k in range(3):
            moved = points
            if motions is not None:
                motion = motions[np.maximum(on.patch[:, k], 0)]
                moved = rowwise(motion[:, :3], points) + motion[:, 3]
            displacements += on.shares[:, k] * (moved - at)
        offset = np.array(result.offset)
        offset[on.rows] *= (np.float32(1.0) - on.share)[:, None]
        move(result, on.rows, displacements, mesh.shown, animated)
        result.attributes["rumple_offset"] = offset
        for name in heights:
            values = np.array(result.attributes[name])
            values[on.rows] *= np.float32(1.0) - on.share
            result.attributes[name] = values

    def _motions(self, animated: np.ndarray, over: np.ndarray, result: FrameResult,
                 on: _OnShown) -> np.ndarray | None:
        """(patches, 4, 3) rigid motions from the animated mesh to the base cloth; None without a base cloth."""
        if over is animated:
            return None
        if len(over) == len(animated):
            groups = self._core
            before, after = animated, over
        else:  # it was solved on a coarser mesh, so the positions of the cloth come from the result
            found = on.patch.max(1)
            groups = [on.rows[(found == number) & (on.share >= CORE)] for number in range(self.count)]
            before, after = result.positions - result.offset, result.positions
        starts = np.cumsum([0, *map(len, groups)], dtype=np.int32)
        rows = np.concatenate(groups) if groups else np.empty(0, np.int64)
        return kernels.rigid_motions(starts, np.ascontiguousarray(before[rows], np.float32),
                                     np.ascontiguousarray(after[rows], np.float32))

    def _on_shown(self, mesh: ShownMesh) -> _OnShown:
        if mesh.shown not in self._on:
            self._on[mesh.shown] = self._made_for(mesh)
        return self._on[mesh.shown]

    def _made_for(self, mesh: ShownMesh) -> _OnShown:
        shown = mesh.shown
        weights = corner_weights(shown)
        shares = (weights * self.rigid[shown.triangle_vertex]).astype(np.float32)
        rows = np.flatnonzero(shares.max(1, initial=0.0) > 0.0)
        corners, weights, shares = shown.triangle_vertex[rows], weights[rows, :, None], shares[rows, :, None]
        from_base = None
        if mesh.source is not mesh.base:  # an artist's own fine mesh keeps its offsets from the coarse mesh
            rest = self.base.positions
            points = (weights * rest[corners]).sum(1)
            from_base = rowwise(frames_of(rest, corners), shown.positions_rest[rows] - points)
        return _OnShown(rows, corners, weights.astype(np.float32), shares, np.minimum(shares.sum(1)[:, 0], 1.0),
                        self.patch[corners], from_base)
