# SPDX-License-Identifier: GPL-3.0-or-later
"""Compute shaders over arrays (gpu_arrays.py): from Blender 4 on. All functions need a drawing context."""
from __future__ import annotations

from typing import Any, Iterable

import gpu

from . import glsl

_GROUP = 128  # elements of a work group


def are_available() -> bool:
    """Whether Python can start compute shaders. Blender 3.4 has none."""
    return hasattr(gpu, "compute")


class Kernel:
    """A compute shader with a function work(int), which runs once for every element."""

    def __init__(self, source: str, inputs: tuple[str, ...], images: dict[str, set[str]],
                 constants: tuple[tuple[str, str], ...] = ()) -> None:
        """source: GLSL. inputs: names of arrays that it reads. images: of arrays that it writes, and what it does with
        them: READ, WRITE. constants: (type, name)."""
        info = gpu.types.GPUShaderCreateInfo()
        info.local_group_size(_GROUP)
        for slot, name in enumerate(inputs):
            info.sampler(slot, "FLOAT_2D", name)
        for slot, (name, access) in enumerate(images.items()):
            info.image(slot, "RGBA32F", "FLOAT_2D", name, qualifiers=access)
        for kind, name in (("INT", "first"), ("INT", "count"), *constants):
            info.push_constant(kind, name)
        info.compute_source(source + glsl.text("preview/kernel"))
        self._shader, self._inputs, self._images = gpu.shader.create_from_info(info), inputs, tuple(images)

    def run(self, count: int, arrays: dict[str, gpu.types.GPUTexture], **constants: float) -> None:
        """Run for elements 0 to count - 1. arrays: at least all inputs and images, by name."""
        self.run_each([(0, count)], arrays, **constants)

    def run_each(self, ranges: Iterable[tuple[int, int]], arrays: dict[str, gpu.types.GPUTexture],
                 **constants: float) -> None:
        """Run for one range after the other: (first element, number of elements)."""
        shader: Any = self._shader
        shader.bind()
        for name in self._inputs:
            shader.uniform_sampler(name, arrays[name])
        for name in self._images:
            shader.image(name, arrays[name])
        for name, value in constants.items():
            shader.uniform_float(name, value)
        for first, count in ranges:
            shader.uniform_int("first", first)
            shader.uniform_int("count", count)
            gpu.compute.dispatch(shader, -(-count // _GROUP), 1, 1)
