# SPDX-License-Identifier: GPL-3.0-or-later
"""The solver of the Wrinkle Mesh on the graphics card: M. Mueller and N. Chentanez, Wrinkle Meshes, SCA 2010, section 4.

As in the paper, the wrinkle mesh stays on the card: a frame uploads the positions and normals of the base. The result is
that of the library but for rounding, because every pass projects the pairs in the library's order.
"""
from __future__ import annotations

from typing import Any

import gpu
import numpy as np

from ...core.base.wording import UserError
from . import glsl, gpu_arrays
from .gpu_arrays import Pass, Target, upload

_SHARED = ("preview/texels", "shared/wrinkle_mesh")
_PAIR, _LENGTHS = "RGBA32F", "RG32F"
_BOUNDS = ("attachments", "normals", "bounds")


class Passes:
    """The compiled stages, which all objects share."""

    def __init__(self) -> None:
        def stage(name: str, *arguments: Any, more: tuple[str, ...] = ()) -> Pass:
            return Pass(glsl.source(*_SHARED, *more, f"preview/mesh_{name}"), *arguments)

        self.attach = stage("attach", ("places", "spans", "limits", "positions", "normals"),
                            ("out_attachment", "out_normal"), (("FLOAT", "curved"),), more=("shared/pn_triangle",))
        self.targets = stage("targets", ("pairs", "attachments", "former", "starts", "lengths", "changes"),
                             ("out_length", "out_change"),
                             (("FLOAT", "stretch_relief"), ("FLOAT", "buckling_threshold"),
                              ("FLOAT", "compression_limit"), ("BOOL", "is_first"), ("BOOL", "is_distance")))
        self.start = stage("start", ("changes", "neighbour_spans", "neighbours", "places", "positions", "attachments",
                                     "normals", "offsets", "bounds"), ("out_start", "out_solved"))
        self.relax = stage("relax", ("pairs", "lengths", "solved"), ("out_solved",))
        self.bounds = stage("bounds", ("solved", *_BOUNDS), ("out_solved",),
                            (("FLOAT", "tangential_pull"), ("FLOAT", "normal_pull")))
        self.finish = stage("finish", ("solved", "starts", "places", "positions", "offsets", *_BOUNDS),
                            ("out_solved", "out_offset"), (("FLOAT", "damping"),))
        self.show = stage("show", ("row_spans", "rows", "solved"), ("out_place",))
        self.normals = stage("normals", ("corner_spans", "corners", "shown"), ("out_normal",))


def packed(start: np.ndarray, *columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lists of different lengths, two entries in a texel: (n, 2) first texel and number of texels of every list, and
    (m, 4) texels. start: (n + 1,) first entry of every list, then their number. columns: two numbers of every entry.
    The second half of an odd list's last texel is zero."""
    counts = np.diff(start)
    texels = (counts + 1) // 2
    first = np.cumsum(texels) - texels
    entries = np.zeros((2 * int(texels.sum()), 2), np.float32)
    place = np.repeat(2 * first - start[:-1], counts) + np.arange(int(counts.sum()))
    for column, values in enumerate(columns):
        entries[place, column] = values
    return np.column_stack((first, texels)), entries.reshape(-1, 4)


class GpuMesh:
    """The textures of one object: what depends only on rest pose, settings and paint, and the state. Arrays of solved
    vertices are in the order of the native passes, so that neighbours lie near one another."""

    def __init__(self, passes: Passes, constraints: Any, settings: Any) -> None:
        """constraints: WrinkleMeshPasses, made with these settings: WrinkleMeshSettings. Raises UserError if a texture
        is too small for the mesh. Cost: O(pairs), once for each change of the settings."""
        self._passes, self._settings = passes, settings
        count = self.count = constraints.vertex_count
        self.vertex = constraints.vertex
        self._curved = float(constraints.curved)
        self._places = upload(constraints.base_vertices)
        spans, limits = packed(constraints.limit_start, constraints.limit_vertex, constraints.limit_weight)
        gpu_arrays.check_size(max(count, len(limits)))
        self._spans = upload(np.column_stack((constraints.weights, spans)))
        self._limits = upload(limits)
        self._bounds = upload(np.column_stack((constraints.radius, constraints.depth, constraints.push,
                                               constraints.noise)))
        self._collect_pairs(constraints)
        self._collect_neighbours(constraints.pairs[:constraints.distance_count])
        self._attached = [Target(count, 2) for _ in range(2)]  # attachments, normals: of this frame and the one before
        self._started, self._solved = Target(count, 2), [Target(count) for _ in range(2)]
        self._finished = [Target(count, 2) for _ in range(2)]  # positions, offsets: reads its former result
        changes = [Target(count) for _ in range(2)]
        self._measured = [[Target.of(count, [gpu_arrays.empty(count, _LENGTHS), changes[j % 2].textures[0]])
                           for j in range(len(self._pairs))] for _ in range(2)]
        self._unchanged = upload(np.zeros((count, 4), np.float32))

    def _collect_pairs(self, constraints: Any) -> None:
        """The pair of every vertex in every pass, and which pairs these are."""
        order = np.argsort(constraints.of_pass, kind="stable")
        ends = np.searchsorted(constraints.of_pass[order], np.arange(1, constraints.pass_count + 1))
        self._pairs: list[gpu.types.GPUTexture] = []
        self._is_distance: list[bool] = []
        self._in_pass: list[tuple[np.ndarray, np.ndarray]] = []  # pairs of the native side; vertices, (2, n)
        for which in np.split(order, ends[:-1]):
            ends_of = constraints.pairs[which].T
            texels = np.zeros((self.count, 4), np.float32)
            texels[:, 0] = -1.0
            for own, other in (ends_of, ends_of[::-1]):
                texels[own] = np.column_stack((other, constraints.stretched[which], constraints.stiffness[which],
                                               constraints.rest[which]))
            self._pairs.append(upload(texels))
            self._is_distance.append(bool(len(which)) and int(which[0]) < constraints.distance_count)
            self._in_pass.append((which, ends_of))

    def _collect_neighbours(self, edges: np.ndarray) -> None:
        """The vertices at the other ends of edges, (e, 2), four in a texel."""
        own, other = np.concatenate([edges, edges[:, ::-1]]).T
        order = np.argsort(own, kind="stable")
        counts = np.bincount(own, minlength=self.count)
        entries = np.zeros(4 * -(-len(other) // 4), np.float32)
        entries[:len(other)] = other[order]
        self._neighbour_spans = upload(np.column_stack((np.cumsum(counts) - counts, counts)))
        self._neighbours = upload(entries.reshape(-1, 4))

    def begin(self, offset: np.ndarray, solved_length: np.ndarray) -> None:
        """Take over the state of a solved frame: the arrays of a WrinkleMeshState. No vertex is active in it."""
        self._offsets = upload(offset[self.vertex])
        self._lengths: list[gpu.types.GPUTexture] = []
        for which, ends_of in self._in_pass:
            texels = np.zeros((self.count, 2), np.float32)
            for own in ends_of:
                texels[own, 1] = solved_length[which]
            self._lengths.append(upload(texels, _LENGTHS))
        self._starts = self._unchanged

    def pose(self, positions: np.ndarray, normals: np.ndarray) -> None:
        """Upload this frame's welded vertices of the base, both (w, 3), and attach the mesh to them (section 4)."""
        self._positions = upload(positions)
        self._attached.reverse()
        self._passes.attach.run(self._attached[0], {
            "places": self._places, "spans": self._spans, "limits": self._limits, "positions": self._positions,
            "normals": upload(normals)}, curved=self._curved)

    def stay(self) -> None:
        """The frame whose state was taken over, as it was solved."""
        self._start(self._unchanged)
        self._solution = self._started.textures[0]

    def solve(self) -> None:
        """Go on from the frame before (section 4.1). Cost: O(iterations x passes x vertices)."""
        self._start(self._measure())
        self._starts = self._started.textures[0]
        self._solution = self._relax(self._started.textures[1])
        self._finished.reverse()
        self._passes.finish.run(self._finished[0], {
            "solved": self._solution, "starts": self._starts, "offsets": self._offsets, **self._on_base(),
            **self._within()}, damping=self._settings.damping)
        self._solution, self._offsets = self._finished[0].textures

    def _on_base(self) -> dict[str, gpu.types.GPUTexture]:
        return {"places": self._places, "positions": self._positions}

    def _within(self) -> dict[str, gpu.types.GPUTexture]:
        return dict(zip(_BOUNDS, (*self._attached[0].textures, self._bounds)))

    def _measure(self) -> gpu.types.GPUTexture:
        """The targets of all pairs. Returns the texture with what changed around every vertex."""
        settings, changes = self._settings, self._unchanged
        attachments, former = (attached.textures[0] for attached in self._attached)
        self._measured.reverse()
        for j, (pairs, target) in enumerate(zip(self._pairs, self._measured[0])):
            self._passes.targets.run(target, {
                "pairs": pairs, "attachments": attachments, "former": former, "starts": self._starts,
                "lengths": self._lengths[j], "changes": changes}, stretch_relief=settings.stretch_relief,
                buckling_threshold=settings.buckling_threshold, compression_limit=settings.compression_limit,
                is_first=j == 0, is_distance=self._is_distance[j])
            self._lengths[j], changes = target.textures
        return changes

    def _start(self, changes: gpu.types.GPUTexture) -> None:
        self._passes.start.run(self._started, {
            "changes": changes, "neighbour_spans": self._neighbour_spans, "neighbours": self._neighbours,
            "offsets": self._offsets, **self._on_base(), **self._within()})

    def _relax(self, solved: gpu.types.GPUTexture) -> gpu.types.GPUTexture:
        """The positions after all iterations."""
        settings, within = self._settings, self._within()
        for _ in range(settings.iterations):
            for pairs, lengths in zip(self._pairs, self._lengths):
                solved = self._next(self._passes.relax, {"pairs": pairs, "lengths": lengths, "solved": solved})
            solved = self._next(self._passes.bounds, {"solved": solved, **within},
                                tangential_pull=settings.tangential_pull, normal_pull=settings.normal_pull)
        return solved

    def _next(self, stage: Pass, inputs: dict[str, gpu.types.GPUTexture], **constants: float) -> gpu.types.GPUTexture:
        self._solved.reverse()
        stage.run(self._solved[0], inputs, **constants)
        return self._solved[0].textures[0]

    # ------------------------------------------------------------ what was computed
    @property
    def solution(self) -> gpu.types.GPUTexture:
        """Of the solved vertices in this frame."""
        return self._solution

    @property
    def offsets(self) -> gpu.types.GPUTexture:
        """o_i (section 4.1), in the frames of the base's triangles."""
        return self._offsets


class GpuShownMesh:
    """The shown mesh of solved vertices: places and normals."""

    def __init__(self, passes: Passes, shown: Any, vertex: np.ndarray) -> None:
        """shown: a native shown mesh. vertex: of every solved vertex in the card's order its number in the library.
        Cost: O(corners), once."""
        self._passes = passes
        count = shown.vertex_count
        order = np.empty(len(vertex), np.int32)
        order[vertex] = np.arange(len(vertex), dtype=np.int32)
        spans, rows = packed(shown.solved_start, order[shown.solved_vertex], shown.solved_weight)
        gpu_arrays.check_size(max(len(shown.corner_vertex), len(rows)))
        self._row_spans, self._rows = upload(spans), upload(rows)
        self._collect_corners(shown)
        self._places, self._normals = Target(count), Target(count)

    def _collect_corners(self, shown: Any) -> None:
        """The other vertices of the polygons around every vertex."""
        start, corners = shown.polygon_start, shown.corner_vertex
        sizes = np.repeat(np.diff(start), np.diff(start))
        first = np.repeat(start[:-1], np.diff(start))
        place = np.arange(len(corners)) - first
        order = np.argsort(corners, kind="stable")
        others = [corners[first + (place + step) % sizes][order] for step in (1, sizes - sizes // 2, sizes - 1)]
        counts = np.bincount(corners, minlength=shown.vertex_count)
        self._corner_spans = upload(np.column_stack((np.cumsum(counts) - counts, counts)))
        self._corners = upload(np.column_stack(others))

    def show(self, solution: gpu.types.GPUTexture) -> None:
        """Cost: O(corners)."""
        self._passes.show.run(self._places, {"row_spans": self._row_spans, "rows": self._rows, "solved": solution})
        self._passes.normals.run(self._normals, {"corner_spans": self._corner_spans, "corners": self._corners,
                                                 "shown": self._places.textures[0]})

    @property
    def places(self) -> gpu.types.GPUTexture:
        return self._places.textures[0]

    @property
    def normals(self) -> gpu.types.GPUTexture:
        """Not of length 1; zero where a vertex has no area around it."""
        return self._normals.textures[0]
