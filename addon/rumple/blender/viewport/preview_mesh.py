# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Mesh on the GPU: solved and drawn there, so that its vertices never leave it (Mueller and Chentanez
2010). Only a single mesh over the animation: bodies, base cloth and layers need searches that these passes do not have.
"""
from __future__ import annotations

from typing import Any, Callable

import bpy
import gpu
import numpy as np

from ...core.systems.wrinkle_mesh import MOST_UNDER_PROXY, WrinkleMesh
from ..objects import incoming_mesh, mesh_reader, runtimes
from . import gpu_arrays, proxy_layer
from .gpu_mesh import GpuMesh, GpuShownMesh, Kernels

_PATIENCE = 0.5  # seconds that a redraw may wait for frames that the library has to solve first


def _compile() -> gpu.types.GPUShader:
    between = gpu.types.GPUStageInterfaceInfo("rumple_mesh")
    for name in ("normal", "place"):
        between.smooth("VEC3", name)
    between.smooth("VEC2", "image_uv")
    return gpu_arrays.drawing_shader(
        between, (("INT", "shown_vertex"), ("VEC2", "uv")), ("shown", "shown_normals", "image"),
        ("preview/mesh_vertex",), ("preview/mesh_fragment",),
        outputs=(("VEC4", "out_color"), ("FLOAT", "out_depth")))


class Drawing:
    """The wrinkle mesh of one object; see preview.Drawing."""

    def __init__(self, model: Any) -> None:
        self._model = model
        self.has_uv = False
        self.mesh: GpuMesh | None = None
        self.shown: GpuShownMesh | None = None
        self._drawn: Any = None  # the native shown mesh in the batches
        self._slots: np.ndarray | None = None  # material slot of every coarse triangle
        self._coarse_uv: np.ndarray | None = None  # UV of the coarse corners in the batches; None: no UV map
        self._batches: dict[int, gpu.types.GPUBatch] = {}

    def update(self, obj: bpy.types.Object, runtime: runtimes.Runtime, before: runtimes.Inputs | None,
               slots: np.ndarray) -> bool:
        """Solve this frame on the card if it follows the one that is there. Otherwise take over the engine's state."""
        inputs, evaluator = runtime.inputs, runtime.evaluator
        assert isinstance(evaluator, WrinkleMesh)
        drawn = evaluator.in_viewport if inputs.in_viewport else evaluator
        if not self._collect_batches(obj, drawn, slots):
            return False
        kernels = gpu_arrays.kept("mesh kernels", Kernels)
        same = (self.mesh is not None and before is not None and before.paint is inputs.paint
                and before.settings == inputs.settings)
        if not same:
            constraints, settings = evaluator.passes(inputs.settings)
            self.mesh = GpuMesh(kernels, constraints, settings)
            self._proxy = proxy_layer.Proxy(constraints.triangles)
            self.shown = None
        positions, normals, smooth = self._model.weld_pose(evaluator.base.points(inputs.positions))
        self.mesh.pose(positions, normals)
        self._coarse = gpu_arrays.upload(positions if evaluator.vertex_count > MOST_UNDER_PROXY else smooth)
        if same and inputs.goes_on_from(before):
            self.mesh.solve()
        elif evaluator.frame_cache.seconds_until_solved(inputs.frame) > _PATIENCE:
            self.mesh.solve_from_start()
        else:
            state = evaluator.wrinkles_of(inputs.frame)
            if state is None:
                return False
            self.mesh.take_over(state.offset, state.solved_length)
        if self.shown is None:
            self.shown = GpuShownMesh(kernels, drawn.shown, self.mesh.vertex)
        self.shown.show(self.mesh.solution)
        return True

    def _collect_batches(self, obj: bpy.types.Object, drawn: Any, slots: np.ndarray) -> bool:
        """Make a batch of triangles for every used material slot, if the mesh, its UV map or the slots have changed.
        Returns whether there are batches."""
        coarse = incoming_mesh.of(obj)
        uv = mesh_reader.render_uv(coarse)
        corners, polygons = drawn.coarse_triangles()
        if len(coarse.polygons) <= polygons.max(initial=-1) or (uv is not None and len(uv) <= corners.max(initial=-1)):
            return bool(self._batches)  # edited: until the wrinkles are rebuilt
        same_uv = uv is None if self._coarse_uv is None else uv is not None and np.array_equal(uv, self._coarse_uv)
        if self._drawn is drawn.shown and same_uv and np.array_equal(slots, self._slots):
            return bool(self._batches)
        if self._drawn is not drawn.shown:
            self.shown = None
        self._drawn, self._slots, self._coarse_uv, self.has_uv = drawn.shown, slots, uv, uv is not None
        self._batches = _batches(drawn, uv, _slots_of_polygons(len(coarse.polygons), polygons, slots))
        return bool(self._batches)

    def shader(self) -> gpu.types.GPUShader:
        return gpu_arrays.kept("mesh", _compile)

    def arrays(self) -> dict[str, gpu.types.GPUTexture]:
        return {"shown": self.shown.places, "shown_normals": self.shown.normals}

    def slots(self) -> list[int]:
        return list(self._batches)

    def present(self, paint: Callable[[], None], over: gpu_arrays.Overlays, block: gpu.types.GPUUniformBuf) -> None:
        proxy_layer.present(paint, lambda: self._proxy.draw(block, self._coarse), over)

    def draw(self, shader: gpu.types.GPUShader, slot: int) -> None:
        self._batches[slot].draw(shader)


def _slots_of_polygons(count: int, polygons: np.ndarray, slots: np.ndarray) -> np.ndarray:
    """(count,) int32: the slot of every coarse polygon. polygons, slots: of the coarse triangles."""
    of_polygon = np.zeros(count, np.int32)
    of_polygon[polygons] = slots
    return of_polygon


def _batches(drawn: Any, coarse_uv: np.ndarray | None, slots: np.ndarray) -> dict[int, gpu.types.GPUBatch]:
    """The triangles of a shown mesh, by material slot. Polygons that lie on others are left out. coarse_uv: of the
    corners of the coarse mesh. slots: of its polygons."""
    start, corners = drawn.shown.polygon_start, drawn.shown.corner_vertex
    uv = np.zeros((len(corners), 2), np.float32)
    if coarse_uv is not None:
        uv = drawn.carry_corners(coarse_uv)[:len(corners)]
    buffer = gpu_arrays.vertex_buffer(shown_vertex=np.array(corners, np.int32), uv=uv)
    slot = slots[drawn.polygon_parent[:len(start) - 1]]
    batches = {}
    for number in np.unique(slot):
        chosen = np.flatnonzero(slot == number)
        index = gpu.types.GPUIndexBuf(type="TRIS", seq=fans(start[chosen], np.diff(start)[chosen]))
        batches[int(number)] = gpu.types.GPUBatch(type="TRIS", buf=buffer, elem=index)
    return batches


def fans(first: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(t, 3) uint32: corners of the triangles of polygons with these first corners and sizes."""
    found = []
    for size in np.unique(sizes):
        of_size = first[sizes == size][:, None]
        for k in range(1, size - 1):
            found.append(of_size + np.array([[0, k, k + 1]]))
    return np.ascontiguousarray(np.concatenate(found) if found else np.zeros((0, 3)), np.uint32)
