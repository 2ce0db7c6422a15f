# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Paths on the GPU: chapter 7 of Gillette 2015 without a tessellation stage, because Blender has none.

Triangles are subdivided by patterns that are made once: indexed grids with 1, 2, 4 .. 32 parts along an edge. A frame
uploads the coarse vertices, the lists of section 7.2, and the pattern of every triangle.
"""
from __future__ import annotations

from typing import Any, Callable

import bpy
import gpu
import numpy as np

from ...core.mesh.frame_result import PreviewFrame
from ..objects import incoming_mesh, mesh_reader, runtimes
from . import glsl, gpu_arrays, proxy_layer
from .gpu_arrays import upload

PROFILES = ("SPLINE", "QUARTIC", "CIRCULAR_ARCS", "SINE")  # in the order of shaders/shared/wrinkle_paths.glsl
_MOST_SPOTS = 1 << 16  # largest number of vertices of a pattern repeated for several triangles


def spots(parts: int) -> np.ndarray:
    """(n, 2) int32: the points of a triangle with this number of parts per edge, in steps towards corners 1 and 2."""
    return np.array([(i, j) for j in range(parts + 1) for i in range(parts + 1 - j)], np.int32)


def cells(parts: int) -> np.ndarray:
    """(parts^2, 3) int32: its triangles, as indices into spots()."""
    row = np.cumsum([0, *range(parts + 1, 0, -1)])  # index of the first point with j steps
    found = []
    for j in range(parts):
        for i in range(parts - j):
            a, above = row[j] + i, row[j + 1] + i
            found.append((a, a + 1, above))
            if i < parts - j - 1:
                found.append((a + 1, above + 1, above))
    return np.array(found, np.int32)


def _pattern(parts: int, count: int) -> gpu.types.GPUBatch:
    """The pattern for this number of triangles."""
    points, triangles = spots(parts), cells(parts)
    which = np.repeat(np.arange(count, dtype=np.int32), len(points))
    buffer = gpu_arrays.vertex_buffer(spot=np.column_stack((which, np.tile(points, (count, 1)))))
    steps = len(points) * np.arange(count, dtype=np.int32)[:, None, None]
    indices = np.ascontiguousarray((triangles + steps).reshape(-1, 3), np.uint32)
    return gpu.types.GPUBatch(type="TRIS", buf=buffer, elem=gpu.types.GPUIndexBuf(type="TRIS", seq=indices))


def runs(first: int, count: int, parts: int) -> list[tuple[int, int]]:
    """(first, count) of draws with few different counts: powers of two, so that patterns can be reused."""
    found, most = [], 1 << max(_MOST_SPOTS // len(spots(parts)), 1).bit_length() - 1
    while count:
        size = min(1 << count.bit_length() - 1, most)
        found.append((first, size))
        first, count = first + size, count - size
    return found


def _compile() -> gpu.types.GPUShader:
    between = gpu.types.GPUStageInterfaceInfo("rumple_paths")
    for name in ("normal", "place", "flat_place"):
        between.smooth("VEC3", name)
    between.smooth("VEC2", "image_uv")
    between.smooth("FLOAT", "hem")
    between.flat("IVEC2", "list")
    formulas = (*glsl.FOLDS, "preview/folds")
    return gpu_arrays.drawing_shader(
        between, (("IVEC3", "spot"),),
        ("triangles", "flats", "smooths", "normals", "uvs", "patches", "ranges", "ends", "image"),
        (*formulas, "preview/paths_vertex"), (*formulas, "preview/paths_fragment"),
        (("INT", "first_patch"), ("INT", "parts"), ("INT", "profile_kind"), ("FLOAT", "curved")),
        (("VEC4", "out_color"), ("FLOAT", "out_depth")))


class Drawing:
    """The folds of one object, and the smooth surface between them; see preview.Drawing."""

    def __init__(self, model: Any) -> None:
        self._arrays = {"triangles": upload(model.triangle_vertex)}
        self._proxy = proxy_layer.Proxy(model.triangle_vertex)
        self._groups: dict[int, list[tuple[int, int, int]]] = {}  # material slot -> (parts, first patch, patches)
        self.has_uv = False

    def update(self, obj: bpy.types.Object, runtime: runtimes.Runtime, _before: runtimes.Inputs | None,
               slots: np.ndarray) -> bool:
        """Upload the last solved frame."""
        if not isinstance(runtime.result, PreviewFrame):
            return False
        drawing = runtime.result.drawing
        uv = mesh_reader.render_uv(incoming_mesh.of(obj))
        corners = runtime.evaluator.coarse_triangles()[0].ravel()
        # An edited mesh may have fewer corners until the wrinkles are rebuilt.
        self.has_uv = uv is not None and corners.max(initial=-1) < len(uv)
        self._profile, self._curved = PROFILES.index(runtime.inputs.settings.profile), float(drawing.curved)
        self._arrays.update(
            uvs=upload(uv[corners]) if self.has_uv else gpu_arrays.blank(),
            flats=upload(np.column_stack((drawing.flat, drawing.hem))), smooths=upload(drawing.smooth),
            normals=upload(drawing.normal), ranges=upload(drawing.lists.ranges),
            ends=upload(drawing.lists.ends.reshape(-1, 4)), patches=self._collect_patches(drawing, slots))
        return True

    def _collect_patches(self, drawing: Any, slots: np.ndarray) -> gpu.types.GPUTexture:
        """The triangles, ordered by material slot and parts, as shaders/preview/paths_vertex.glsl reads them."""
        parts, start = drawing.parts, drawing.lists.triangle_start
        order = np.lexsort((parts[:, 0], slots))
        patches = np.zeros((len(order), 2, 4), np.float32)
        patches[:, 0, 0], patches[:, 0, 1], patches[:, 0, 2] = order, start[:-1][order], start[1:][order]
        patches[:, 1, :3] = parts[order, 1:]
        keys = np.column_stack((slots, parts[:, 0]))[order]
        changes = np.flatnonzero(np.diff(keys, axis=0).any(1)) + 1
        self._groups = {}
        for first, end in zip((0, *changes), (*changes, len(order))):
            slot, cut = keys[first].tolist()
            self._groups.setdefault(slot, []).append((cut, int(first), int(end - first)))
        return upload(patches.reshape(-1, 4))

    def shader(self) -> gpu.types.GPUShader:
        return gpu_arrays.kept("paths", _compile)

    def arrays(self) -> dict[str, gpu.types.GPUTexture]:
        return self._arrays

    def slots(self) -> list[int]:
        return list(self._groups)

    def present(self, paint: Callable[[], None], over: gpu_arrays.Overlays, block: gpu.types.GPUUniformBuf) -> None:
        proxy_layer.present(paint, lambda: self._proxy.draw(block, self._arrays["smooths"]), over)

    def draw(self, shader: gpu.types.GPUShader, slot: int) -> None:
        shader.uniform_int("profile_kind", self._profile)
        shader.uniform_float("curved", self._curved)
        for parts, first, count in self._groups[slot]:
            shader.uniform_int("parts", parts)
            for start, size in runs(first, count, parts):
                shader.uniform_int("first_patch", start)
                gpu_arrays.kept(f"pattern {parts} {size}", lambda: _pattern(parts, size)).draw(shader)
