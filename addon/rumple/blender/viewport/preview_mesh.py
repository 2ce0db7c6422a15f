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
from ..objects import incoming_mesh, mesh_reader, runtimes, units
from . import gpu_arrays, proxy_layer
from .gpu_mesh import GpuMesh, GpuShownMesh, Kernels


def _compile() -> gpu.types.GPUShader:
    between = gpu.types.GPUStageInterfaceInfo("rumple_mesh")
    for name in ("normal", "place"):
        between.smooth("VEC3", name)
    between.smooth("VEC2", "image_uv")
    return gpu_arrays.drawing_shader(
        between, (("INT", "vertex"), ("VEC2", "uv")), ("shown", "shown_normals", "image"), ("preview/mesh_vertex",),
        ("preview/mesh_fragment",), outputs=(("VEC4", "out_color"), ("FLOAT", "out_depth")))


class Drawing:
    """The wrinkle mesh of one object; see preview.Drawing."""

    def __init__(self, model: Any) -> None:
        self._model = model
        self.has_uv = False
        self.mesh: GpuMesh | None = None
        self.shown: GpuShownMesh | None = None
        self._drawn: Any = None  # the native shown mesh in the batches
        self._slots: np.ndarray | None = None  # material slot of every coarse triangle
        self._batches: dict[int, gpu.types.GPUBatch] = {}

    def update(self, obj: bpy.types.Object, runtime: runtimes.Runtime, before: runtimes.Inputs | None,
               slots: np.ndarray) -> bool:
        """Solve the frame after the one that is on the GPU. All others are taken over from the engine: after a jump,
        after a change of settings or paint, and at the clip's first frame."""
        inputs, evaluator = runtime.inputs, runtime.evaluator
        assert isinstance(evaluator, WrinkleMesh)
        same = (self.mesh is not None and before is not None and before.paint is inputs.paint
                and before.settings == inputs.settings)
        goes_on = (same and not inputs.settings.stateless
                   and inputs.frame == before.frame + 1.0 > units.first_frame(obj, bpy.context.scene))
        state = None if goes_on else evaluator.wrinkles_of(inputs.frame)
        if not goes_on and state is None:
            return False
        kernels = gpu_arrays.kept("mesh kernels", Kernels)
        if not same:
            constraints, settings = evaluator.passes(inputs.settings)
            self.mesh = GpuMesh(kernels, constraints, settings)
            self._proxy = proxy_layer.Proxy(constraints.triangles)
        positions, normals, smooth = self._model.weld_pose(evaluator.base.points(inputs.positions))
        self.mesh.pose(positions, normals)
        self._coarse = gpu_arrays.upload(positions if evaluator.vertex_count > MOST_UNDER_PROXY else smooth)
        if goes_on:
            self.mesh.solve()
        else:
            self.mesh.begin(state.offset, state.solved_length)
            self.mesh.stay()
        drawn = evaluator.in_viewport if inputs.in_viewport else evaluator
        self._collect_batches(obj, drawn, slots)
        if self.shown is None:
            self.shown = GpuShownMesh(kernels, drawn.shown, self.mesh.vertex)
        self.shown.show(self.mesh.solution)
        return True

    def _collect_batches(self, obj: bpy.types.Object, drawn: Any, slots: np.ndarray) -> None:
        """Make a batch of triangles for every used material slot, if the mesh or the slots have changed."""
        if self._drawn is drawn.shown and self._slots is not None and np.array_equal(slots, self._slots):
            return
        if self._drawn is not drawn.shown:
            self.shown = None
        self._drawn, self._slots = drawn.shown, slots
        start, corners = drawn.shown.polygon_start, drawn.shown.corner_vertex
        buffer = gpu_arrays.vertex_buffer(vertex=np.array(corners, np.int32), uv=self._uv(obj, drawn))
        _triangles, polygons = drawn.coarse_triangles()
        of_polygon = np.zeros(len(incoming_mesh.of(obj).polygons), np.int32)
        of_polygon[polygons] = slots
        slot = of_polygon[drawn.polygon_parent[:len(start) - 1]]  # without polygons that lie on others
        self._batches = {}
        for number in np.unique(slot):
            chosen = np.flatnonzero(slot == number)
            index = gpu.types.GPUIndexBuf(type="TRIS", seq=fans(start[chosen], np.diff(start)[chosen]))
            self._batches[int(number)] = gpu.types.GPUBatch(type="TRIS", buf=buffer, elem=index)

    def _uv(self, obj: bpy.types.Object, drawn: Any) -> np.ndarray:
        """(k, 2) float32: UV of every corner; zeros without a UV map."""
        uv = mesh_reader.render_uv(incoming_mesh.of(obj))
        self.has_uv = uv is not None
        count = len(drawn.shown.corner_vertex)
        return drawn.carry_corners(uv)[:count] if uv is not None else np.zeros((count, 2), np.float32)

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


def fans(first: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(t, 3) uint32: corners of the triangles of polygons with these first corners and sizes."""
    found = []
    for size in np.unique(sizes):
        of_size = first[sizes == size][:, None]
        for k in range(1, size - 1):
            found.append(of_size + np.array([[0, k, k + 1]]))
    return np.ascontiguousarray(np.concatenate(found) if found else np.zeros((0, 3)), np.uint32)
