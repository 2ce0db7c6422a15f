# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawings that change the shape: they are drawn into a layer with its own depth, which is laid over the viewport.

Blender draws the coarse mesh meanwhile, as a proxy for depth, outlines and clicks. All functions need a drawing
context.
"""
from __future__ import annotations

from typing import Callable

import gpu
import numpy as np

from ...core.base.wording import UserError
from . import glsl, gpu_arrays

_MOST_SIZES = 4  # number of viewport sizes whose layers are kept
_COMPOSED = ("layer", "layer_depth", "proxy_depth")


class Proxy:
    """The coarse mesh as Blender draws it."""

    def __init__(self, triangles: np.ndarray) -> None:
        """triangles: (t, 3) vertices."""
        self._triangles = gpu_arrays.upload(triangles)
        corners = np.indices((len(triangles), 3), np.int32).reshape(2, -1).T
        self._batch = gpu.types.GPUBatch(type="TRIS", buf=gpu_arrays.vertex_buffer(spot=corners))

    def draw(self, block: gpu.types.GPUUniformBuf, positions: gpu.types.GPUTexture) -> None:
        """positions: of the vertices. block: the transforms of object and viewer."""
        shader = gpu_arrays.kept("proxy", _proxy_shader)
        shader.bind()
        shader.uniform_sampler("triangles", self._triangles)
        shader.uniform_sampler("positions", positions)
        shader.uniform_block("preview", block)
        self._batch.draw(shader)


def _proxy_shader() -> gpu.types.GPUShader:
    return gpu_arrays.drawing_shader(None, (("IVEC2", "spot"),), ("triangles", "positions"), ("preview/proxy_vertex",),
                                     ("preview/proxy_fragment",), outputs=(("FLOAT", "out_depth"),))


def present(paint: Callable[[], None], paint_proxy: Callable[[], None], over: gpu_arrays.Overlays) -> None:
    """Show paint() in the viewport, under the overlays `over`. Inside the layer its own depth hides it. Against
    everything else it is at most as far away as the proxy."""
    left, bottom, width, height = gpu.state.viewport_get()
    layer, proxy = layers((width, height))
    proxy.drawn(paint_proxy)
    layer.drawn(paint)
    composite_layer(layer, proxy, over, (left, bottom))


class Layer:
    """An image with its own depth, which is its last texture: 0 where nothing is drawn."""

    def __init__(self, size: tuple[int, int], colors: tuple[str, ...]) -> None:
        """colors: formats of the images, the last one R32F for the depth."""
        self.textures = [gpu.types.GPUTexture(size, format=form) for form in colors]
        self._depth = gpu.types.GPUTexture(size, format="DEPTH_COMPONENT32F")
        self.frame_buffer = gpu.types.GPUFrameBuffer(depth_slot=self._depth, color_slots=tuple(self.textures))

    def drawn(self, paint: Callable[[], None]) -> None:
        """Clear the layer and draw paint() into it."""
        with self.frame_buffer.bind():
            self.frame_buffer.clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
            paint()


def layers(size: tuple[int, int]) -> tuple[Layer, Layer]:
    """One for a drawing with its light, and one for the proxy that Blender draws."""
    found = gpu_arrays.kept("layers", dict)
    if size not in found:
        if len(found) >= _MOST_SIZES:
            found.clear()
        found[size] = Layer(size, ("RGBA16F", "R32F")), Layer(size, ("R32F",))
    return found[size]


def composite_layer(layer: Layer, proxy: Layer, over: gpu_arrays.Overlays, origin: tuple[int, int]) -> None:
    """Draw a layer into the bound frame buffer, whose viewport starts at origin. over: from overlays()."""
    shader, batch = gpu_arrays.kept("composite layer", _composite_shader), gpu_arrays.kept("whole", gpu_arrays.whole)
    shader.bind()
    for name, texture in zip(_COMPOSED, (*layer.textures, *proxy.textures)):
        shader.uniform_sampler(name, texture)
    over.bind(shader)
    shader.uniform_int("origin", origin)
    batch.draw(shader)


def _composite_shader() -> gpu.types.GPUShader:
    info = gpu.types.GPUShaderCreateInfo()
    for slot, name in enumerate((*_COMPOSED, "overlays")):
        info.sampler(slot, "FLOAT_2D", name)
    info.push_constant("IVEC2", "origin")
    for kind, name in gpu_arrays.OVERLAY_CONSTANTS:
        info.push_constant(kind, name)
    info.vertex_in(0, "VEC2", "corner")
    info.fragment_out(0, "VEC4", "out_color")
    if hasattr(info, "depth_write"):
        info.depth_write("ANY")
    elif gpu_arrays.backend() == "METAL":
        raise UserError("GPU Preview of this system needs a later Blender on macOS: the fine mesh is shown")
    else:  # 4.3 itself declares that the shader keeps the depth, and NVIDIA's driver relies on this
        info.define("depth_unchanged", "depth_any")
    info.vertex_source(glsl.source("preview/pass_vertex"))
    info.fragment_source(glsl.source("preview/under_overlays", "preview/composite_layer"))
    return gpu.shader.create_from_info(info)
