# SPDX-License-Identifier: GPL-3.0-or-later
"""The solver of the Wrinkle Mesh on the graphics card: Mueller and Chentanez, Wrinkle Meshes, SCA 2010, section 4.

As in the paper, the wrinkle mesh stays on the card: a frame uploads the positions and normals of the base. The result
is that of the library but for rounding, because the passes project the pairs in the library's order. They are compute
shaders, not fragment shaders: each touches only its own pairs, and some cards have few units for fragments.
"""
from __future__ import annotations

from typing import Any

import gpu
import numpy as np

from . import glsl, gpu_arrays
from .gpu_arrays import empty, upload
from .gpu_kernels import Kernel

_NEVER = -1e30  # a length when a pair was last solved, from which every length has changed
_READ_WRITE, _WRITE = {"READ", "WRITE"}, {"WRITE"}


class Kernels:
    """The compiled stages, which all objects share."""

    def __init__(self) -> None:
        def stage(name: str, inputs: tuple[str, ...], images: dict[str, set[str]], *constants: str,
                  more: tuple[str, ...] = ()) -> Kernel:
            source = glsl.source("preview/texels", "preview/images", *more, "shared/wrinkle_mesh",
                                 f"preview/mesh_{name}")
            return Kernel(source, inputs, images, tuple(("FLOAT", constant) for constant in constants))

        on_base, within = ("places", "positions"), ("attachments", "normals", "bounds")
        around = ("pairs", "pair_spans", "pairs_of")
        self.attach = stage("attach", (*on_base, "spans", "limits", "base_normals"),
                            {"attachments": _WRITE, "normals": _WRITE}, "curved", more=("shared/pn_triangle",))
        self.targets = stage("targets", ("pairs", "attachments", "starts"), {"lengths": _READ_WRITE}, "stretch_relief",
                             "buckling_threshold", "compression_limit")
        self.changes = stage("changes", (*around, "lengths"), {"changes": _WRITE})
        self.start = stage("start", (*around, *on_base, *within, "changes", "offsets"),
                           {"starts": _WRITE, "solved": _WRITE})
        self.relax = stage("relax", ("pairs", "lengths"), {"solved": _READ_WRITE})
        self.bounds = stage("bounds", within, {"solved": _READ_WRITE}, "tangential_pull", "normal_pull")
        self.finish = stage("finish", (*on_base, *within, "starts"),
                            {"solved": _READ_WRITE, "offsets": _READ_WRITE}, "damping")
        self.show = stage("show", ("row_spans", "rows", "solved"), {"shown": _WRITE})
        self.normals = stage("normals", ("corner_spans", "corners", "shown"), {"shown_normals": _WRITE})


def ranges(counts: np.ndarray) -> np.ndarray:
    """(n, 2): the first element of every list, and their numbers, which are given, if the lists follow one another."""
    return np.column_stack((np.cumsum(counts) - counts, counts))


def packed(start: np.ndarray, *columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lists of different lengths, two entries in a texel: (n, 2) first texel and number of texels of every list, and
    (m, 4) texels. start: (n + 1,) first entry of every list, then their number. columns: two numbers of every entry.
    The second half of an odd list's last texel is zero."""
    counts = np.diff(start)
    texels = ranges((counts + 1) // 2)
    entries = np.zeros((2 * int(texels[:, 1].sum()), 2), np.float32)
    place = np.repeat(2 * texels[:, 0] - start[:-1], counts) + np.arange(int(counts.sum()))
    for column, values in enumerate(columns):
        entries[place, column] = values
    return texels, entries.reshape(-1, 4)


class GpuMesh:
    """The arrays of one object: what depends only on rest pose, settings and paint, and the state. Solved vertices are
    in the order of the native passes, so that neighbours lie near one another."""

    def __init__(self, kernels: Kernels, passes: Any, settings: Any) -> None:
        """passes: WrinkleMeshPasses, made with these settings: WrinkleMeshSettings. Raises UserError if the mesh
        is too large for a texture. Cost: O(pairs), once for each change of the settings."""
        self._kernels, self._settings = kernels, settings
        self.count, self.vertex = passes.vertex_count, passes.vertex
        self._curved = float(passes.curved)
        spans, limits = packed(passes.limit_start, passes.limit_vertex, passes.limit_weight)
        gpu_arrays.check_size(max(self.count, len(limits), 2 * len(passes.pairs)))
        self._arrays = {
            "places": upload(passes.base_vertices), "limits": upload(limits),
            "spans": upload(np.column_stack((passes.weights, spans))),
            "bounds": upload(np.column_stack((passes.radius, passes.depth, passes.push, passes.noise))),
            **{name: empty(self.count) for name in ("attachments", "normals", "starts", "solved", "changes")}}
        self._collect_pairs(passes)

    def _collect_pairs(self, passes: Any) -> None:
        """Pairs in the order of the passes, and the pairs of every vertex, first those that keep distances."""
        order = self._pair_order = np.argsort(passes.of_pass, kind="stable")
        counts = np.bincount(passes.of_pass, minlength=passes.pass_count)
        self._ranges = [(first, count) for first, count in ranges(counts).tolist() if count]
        pairs = passes.pairs[order]
        self._stiffness = passes.stiffness[order]
        is_bending = np.tile(order >= passes.distance_count, 2)
        ends, index = pairs.T.ravel(), np.tile(np.arange(len(pairs)), 2)
        of_vertex = np.lexsort((is_bending, ends))
        totals = np.bincount(ends, minlength=self.count)
        distances = np.bincount(ends[~is_bending], minlength=self.count)
        entries = np.zeros(4 * -(-max(len(index), 1) // 4), np.float32)
        entries[:len(index)] = index[of_vertex]
        self._arrays.update(
            pairs=upload(np.column_stack((pairs, passes.stretched[order], passes.rest[order]))),
            pair_spans=upload(np.column_stack((ranges(totals), distances))),
            pairs_of=upload(entries.reshape(-1, 4)))

    def pose(self, positions: np.ndarray, normals: np.ndarray) -> None:
        """Upload this frame's welded vertices of the base, both (w, 3), and attach the mesh to them (section 4). Each
        frame begins with this. After it: solve(), take_over() or solve_from_start()."""
        self._arrays.update(positions=upload(positions), base_normals=upload(normals))
        self._kernels.attach.run(self.count, self._arrays, curved=self._curved)

    def take_over(self, offset: np.ndarray, solved_length: np.ndarray) -> None:
        """Show a frame that the library has solved, and go on from it. The arrays of its WrinkleMeshState: (v, 3)
        object units, in the frames of the base's triangles; (p,) object units."""
        self._set_state(offset[self.vertex], solved_length[self._pair_order])

    def solve_from_start(self) -> None:
        """Solve from the attachments, without a frame before (the canonical start)."""
        pairs = len(self._pair_order)
        self._set_state(np.zeros((self.count, 3), np.float32), np.full(pairs, _NEVER, np.float32))
        self._measure()
        self._relax(self._settings.start_iterations, damping=0.0)

    def solve(self) -> None:
        """Go on from the frame before (section 4.1). Cost: O(iterations x pairs)."""
        self._measure()
        self._relax(self._settings.iterations, self._settings.damping)

    def _set_state(self, offset: np.ndarray, solved_length: np.ndarray) -> None:
        """A state in the card's order. No vertex is active in it."""
        lengths = np.zeros((len(solved_length), 4), np.float32)
        lengths[:, 1], lengths[:, 2] = solved_length, self._stiffness
        none = upload(np.zeros((self.count, 4), np.float32))
        self._arrays.update(offsets=upload(offset), lengths=upload(lengths), changes=none)
        self._kernels.start.run(self.count, self._arrays)  # without changes nothing is active

    def _measure(self) -> None:
        """The targets of all pairs, what has changed, and where the vertices start."""
        settings = self._settings
        self._kernels.targets.run(len(self._pair_order), self._arrays, stretch_relief=settings.stretch_relief,
                                  buckling_threshold=settings.buckling_threshold,
                                  compression_limit=settings.compression_limit)
        self._kernels.changes.run(self.count, self._arrays)
        self._kernels.start.run(self.count, self._arrays)

    def _relax(self, iterations: int, damping: float) -> None:
        kernels, settings, arrays = self._kernels, self._settings, self._arrays
        for _ in range(iterations):
            kernels.relax.run_each(self._ranges, arrays)
            kernels.bounds.run(self.count, arrays, tangential_pull=settings.tangential_pull,
                               normal_pull=settings.normal_pull)
        kernels.finish.run(self.count, arrays, damping=damping)

    @property
    def solution(self) -> gpu.types.GPUTexture:
        """The solved vertices in this frame."""
        return self._arrays["solved"]

    @property
    def attachments(self) -> gpu.types.GPUTexture:
        """a_i (section 4)"""
        return self._arrays["attachments"]

    @property
    def offsets(self) -> gpu.types.GPUTexture:
        """o_i (section 4.1), in the frames of the base's triangles."""
        return self._arrays["offsets"]


class GpuShownMesh:
    """The shown mesh of solved vertices: places and normals."""

    def __init__(self, kernels: Kernels, shown: Any, vertex: np.ndarray) -> None:
        """shown: a native shown mesh. vertex: of every solved vertex in the card's order its number in the library.
        Cost: O(corners), once."""
        self._kernels, self.count = kernels, shown.vertex_count
        order = np.empty(len(vertex), np.int32)
        order[vertex] = np.arange(len(vertex), dtype=np.int32)
        spans, rows = packed(shown.solved_start, order[shown.solved_vertex], shown.solved_weight)
        gpu_arrays.check_size(max(len(shown.corner_vertex), len(rows)))
        self._arrays = {"row_spans": upload(spans), "rows": upload(rows), "shown": empty(self.count),
                        "shown_normals": empty(self.count)}
        self._collect_corners(shown)

    def _collect_corners(self, shown: Any) -> None:
        """The other vertices of the polygons around every vertex."""
        start, corners = shown.polygon_start, shown.corner_vertex
        sizes = np.repeat(np.diff(start), np.diff(start))
        first = np.repeat(start[:-1], np.diff(start))
        place = np.arange(len(corners)) - first
        order = np.argsort(corners, kind="stable")
        others = [corners[first + (place + step) % sizes][order] for step in (1, sizes - sizes // 2, sizes - 1)]
        counts = np.bincount(corners, minlength=self.count)
        self._arrays.update(corner_spans=upload(ranges(counts)), corners=upload(np.column_stack(others)))

    def show(self, solution: gpu.types.GPUTexture) -> None:
        """Cost: O(corners)."""
        self._arrays["solved"] = solution
        self._kernels.show.run(self.count, self._arrays)
        self._kernels.normals.run(self.count, self._arrays)

    @property
    def places(self) -> gpu.types.GPUTexture:
        return self._arrays["shown"]

    @property
    def normals(self) -> gpu.types.GPUTexture:
        """Not of length 1; zero where a vertex has no area around it."""
        return self._arrays["shown_normals"]
