# SPDX-License-Identifier: GPL-3.0-or-later
"""GPU helpers shared by the previews: arrays as textures, passes over them, and drawing shaders.

Arrays are wrapped by rows (shaders/preview/texels.glsl). All functions need a drawing context. Never call them in
background mode or outside the main thread.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

import gpu
import numpy as np

from ...core.base.wording import UserError
from . import glsl

_WIDTH = 1024  # texels in a row of an array; any number works
_FORMAT = "RGBA32F"
_MOST_ROWS = 16384  # of a texture, which every card for OpenGL 4 has
_BUFFER_STEP = 1 << 20  # floats: step size of the buffer for overlays, 512 x 512 pixels
OVERLAY_CONSTANTS = (("IVEC2", "overlays_corner"), ("INT", "overlays_are_linear"))  # of under_overlays.glsl


# ---------------------------------------------------------------- arrays as textures
def _shape(count: int) -> tuple[int, int]:
    width = min(max(count, 1), _WIDTH)
    return width, -(-max(count, 1) // width)


def upload(values: np.ndarray) -> gpu.types.GPUTexture:
    """(n, k) numbers, k up to 4, as a texture. Unused channels of a texel are zero."""
    values = np.asarray(values, np.float32)
    width, height = _shape(len(values))
    texels = np.zeros((width * height, 4), np.float32)
    texels[:len(values), :values.shape[1]] = values
    data = gpu.types.Buffer("FLOAT", texels.size, texels.ravel())
    return gpu.types.GPUTexture((width, height), format=_FORMAT, data=data)


def empty(count: int) -> gpu.types.GPUTexture:
    """A texture of this number of texels, to be written."""
    return gpu.types.GPUTexture(_shape(count), format=_FORMAT)


def check_size(count: int) -> None:
    """Raises UserError if no texture has this number of texels. (Floats are exact indices of them.)"""
    if count > _WIDTH * _MOST_ROWS:
        raise UserError("GPU Preview of this mesh needs larger textures than graphics cards have: the fine mesh is "
                        "shown")


class Target:
    """An array that passes write: one or more textures of `count` texels."""

    def __init__(self, count: int, textures: int = 1) -> None:
        self.count = count
        self.textures = [empty(count) for _ in range(textures)]
        self.frame_buffer = gpu.types.GPUFrameBuffer(color_slots=tuple(self.textures))

    def read(self, texture: int = 0) -> np.ndarray:
        """Its (count, 4) float32. It waits for the GPU, so it is only for tests."""
        return read(self.textures[texture], self.count)


def read(texture: gpu.types.GPUTexture, count: int) -> np.ndarray:
    """The first (count, 4) float32 of a texture."""
    buffer = texture.read()
    buffer.dimensions = texture.width * texture.height * 4  # 4.3 has wrong strides with more than one dimension
    return np.array(buffer, np.float32).reshape(-1, 4)[:count]


def vertex_buffer(**columns: np.ndarray) -> gpu.types.GPUVertBuf:
    """A buffer from columns by name, (n,) or (n, k), int32 or float32."""
    layout = gpu.types.GPUVertFormat()
    for name, values in columns.items():
        whole = values.dtype == np.int32
        layout.attr_add(id=name, comp_type="I32" if whole else "F32", len=values.shape[1] if values.ndim > 1 else 1,
                        fetch_mode="INT" if whole else "FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(next(iter(columns.values()))))
    for name, values in columns.items():
        buffer.attr_fill(name, np.ascontiguousarray(values))
    return buffer


def whole() -> gpu.types.GPUBatch:
    """A triangle that covers the whole target."""
    return gpu.types.GPUBatch(type="TRIS", buf=vertex_buffer(corner=np.array([(-1, -1), (3, -1), (-1, 3)], np.float32)))


# ---------------------------------------------------------------- passes
class Pass:
    """A fragment shader that runs once for every texel of a target."""

    def __init__(self, source: str, inputs: tuple[str, ...], outputs: tuple[str, ...],
                 constants: tuple[tuple[str, str], ...] = ()) -> None:
        """source: GLSL with main(). inputs: names of its arrays. outputs: names of its vec4s. constants: (type,
        name)."""
        info = gpu.types.GPUShaderCreateInfo()
        for slot, name in enumerate(inputs):
            info.sampler(slot, "FLOAT_2D", name)
        for kind, name in constants:
            info.push_constant(kind, name)
        info.vertex_in(0, "VEC2", "corner")
        for slot, name in enumerate(outputs):
            info.fragment_out(slot, "VEC4", name)
        info.vertex_source(glsl.source("preview/pass_vertex"))
        info.fragment_source(source)
        self._shader = gpu.shader.create_from_info(info)
        self._batch = whole()

    def run(self, target: Target, inputs: dict[str, gpu.types.GPUTexture], **constants: Any) -> None:
        """Write every texel of the target. The caller must switch depth test and blending off."""
        with target.frame_buffer.bind():
            self._shader.bind()
            for name, texture in inputs.items():
                self._shader.uniform_sampler(name, texture)
            for name, value in constants.items():
                if isinstance(value, bool):
                    self._shader.uniform_bool(name, value)
                elif isinstance(value, int):
                    self._shader.uniform_int(name, value)
                else:
                    self._shader.uniform_float(name, value)
            self._batch.draw(self._shader)


def plain_state() -> None:
    """Set the drawing state for passes."""
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")
    gpu.state.depth_mask_set(False)
    gpu.state.face_culling_set("NONE")


# ---------------------------------------------------------------- what all objects share
_kept: dict[str, Any] = {}


def kept(name: str, make: Callable[[], Any]) -> Any:
    """The result of make(), which is called only the first time."""
    if name not in _kept:
        _kept[name] = make()
    return _kept[name]


def forget() -> None:
    """Free all kept data. Call it in the main thread."""
    _kept.clear()


def blank() -> gpu.types.GPUTexture:
    """A white texel, for samplers without data."""
    return kept("blank", lambda: upload(np.ones((1, 4), np.float32)))


@dataclass(frozen=True)
class Overlays:
    """Blender's overlays, which stay visible over the drawing (shaders/preview/under_overlays.glsl)."""

    texture: gpu.types.GPUTexture
    corner: tuple[int, int] = (0, 0)  # viewport pixel of its first texel
    are_linear: bool = False  # otherwise in sRGB

    def bind(self, shader: gpu.types.GPUShader) -> None:
        """Pass it to a bound shader."""
        shader.uniform_sampler("overlays", self.texture)
        shader.uniform_int("overlays_corner", self.corner)
        shader.uniform_int("overlays_are_linear", int(self.are_linear))


def backend() -> str:
    """"OPENGL", "METAL" or "VULKAN". Blender 3.4 has no function for this, and only OpenGL."""
    return gpu.platform.backend_type_get() if hasattr(gpu.platform, "backend_type_get") else "OPENGL"


def no_overlays() -> Overlays:
    """Empty overlays, instead of overlays()."""
    return Overlays(kept("no overlays", lambda: upload(np.zeros((1, 4), np.float32))))


def _read_buffer(count: int) -> gpu.types.Buffer:
    """A buffer for at least this number of floats. It is reused, because allocating memory costs more than reading into
    it."""
    buffer = _kept.get("read buffer")
    if buffer is None or len(buffer) < count:
        buffer = _kept["read buffer"] = gpu.types.Buffer("FLOAT", -(-count // _BUFFER_STEP) * _BUFFER_STEP)
    return buffer


def overlays(box: tuple[int, int, int, int]) -> Overlays:
    """The pixels of the bound frame buffer in a box of its viewport. In a draw handler of a 3D viewport these are
    Blender's overlays over the scene. They must be read, because Blender has no blend mode that puts a colour under
    another one. This copies pixels from the GPU and waits for it. box: left, bottom, width, height, in pixels of the
    viewport."""
    left, bottom, width, height = box
    if width <= 0 or height <= 0:
        return no_overlays()
    from_left, from_bottom, _width, _height = gpu.state.viewport_get()
    colors = gpu.state.active_framebuffer_get().read_color(from_left + left, from_bottom + bottom, width, height, 4, 0,
                                                           "FLOAT", data=_read_buffer(4 * width * height))
    are_linear = backend() == "VULKAN"  # reading converts to linear; the others return the stored value
    form = "RGBA16F" if are_linear else "RGBA8"  # eight bits are too few for dark linear colours
    return Overlays(gpu.types.GPUTexture((width, height), format=form, data=colors), (left, bottom), are_linear)


# ---------------------------------------------------------------- shaders that draw
def drawing_shader(between: gpu.types.GPUStageInterfaceInfo | None, vertex_in: tuple[tuple[str, str], ...],
                   arrays: tuple[str, ...], vertex: tuple[str, ...], fragment: tuple[str, ...],
                   constants: tuple[tuple[str, str], ...] = (),
                   outputs: tuple[tuple[str, str], ...] = (("VEC4", "out_color"),)) -> gpu.types.GPUShader:
    """A shader with the block of shaders/preview/preview_block.glsl.

    vertex_in, constants, outputs: (type, name). vertex, fragment: files of the folder shaders/, appended to those of
    texels, screen positions and light.
    """
    info = gpu.types.GPUShaderCreateInfo()
    info.typedef_source(glsl.text("preview/preview_block"))
    info.uniform_buf(0, "Preview", "preview")
    for slot, name in enumerate(arrays):
        info.sampler(slot, "FLOAT_2D", name)
    for kind, name in constants:
        info.push_constant(kind, name)
    for slot, (kind, name) in enumerate(vertex_in):
        info.vertex_in(slot, kind, name)
    if between is not None:
        info.vertex_out(between)
    for slot, (kind, name) in enumerate(outputs):
        info.fragment_out(slot, kind, name)
    info.vertex_source(glsl.source("preview/texels", "preview/on_screen", *vertex))
    info.fragment_source(glsl.source("preview/texels", "preview/studio_light", *fragment))
    return gpu.shader.create_from_info(info)
