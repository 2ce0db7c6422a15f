# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Field on the GPU: the passes of Loviscach 2006, figure 2, over RGBA32F textures.

One texel per welded vertex, arrays wrapped by rows (shaders/preview/texels.glsl). Only the deformed positions and
normals cross the bus for a frame. Everything here needs a drawing context: never call it in background mode, nor
outside the main thread.
"""
from __future__ import annotations

from typing import Any

import gpu
import numpy as np

from . import shaders

_WIDTH = 1024  # texels in a row of an array; any number does
_FORMAT = "RGBA32F"
_NEVER = 1e30  # an offset that no link has: as if it had never been relaxed


# ---------------------------------------------------------------- arrays as textures
def _shape(count: int) -> tuple[int, int]:
    width = min(max(count, 1), _WIDTH)
    return width, -(-max(count, 1) // width)


def upload(values: np.ndarray) -> gpu.types.GPUTexture:
    """(n, k) numbers, k up to 4, as a texture; what is left of a texel is zero."""
    values = np.asarray(values, np.float32)
    width, height = _shape(len(values))
    texels = np.zeros((width * height, 4), np.float32)
    texels[:len(values), :values.shape[1]] = values
    data = gpu.types.Buffer("FLOAT", texels.size, texels.ravel())
    return gpu.types.GPUTexture((width, height), format=_FORMAT, data=data)


class Target:
    """An array that passes write: one or more textures of `count` texels."""

    def __init__(self, count: int, textures: int = 1) -> None:
        self.count = count
        self.size = _shape(count)
        self.textures = [gpu.types.GPUTexture(self.size, format=_FORMAT) for _ in range(textures)]
        self.frame_buffer = gpu.types.GPUFrameBuffer(color_slots=tuple(self.textures))

    def read(self, texture: int = 0) -> np.ndarray:
        """Its (count, 4) float32. Waits for the GPU: for tests."""
        return read(self.textures[texture], self.count)


def read(texture: gpu.types.GPUTexture, count: int) -> np.ndarray:
    """The first (count, 4) float32 of a texture."""
    buffer = texture.read()
    buffer.dimensions = texture.width * texture.height * 4  # 4.3 has wrong strides with more dimensions than one
    return np.array(buffer, np.float32).reshape(-1, 4)[:count]


# ---------------------------------------------------------------- passes
class Pass:
    """A fragment shader that runs once for every texel of a target."""

    def __init__(self, source: str, inputs: tuple[str, ...], outputs: tuple[str, ...],
                 constants: tuple[tuple[str, str], ...] = ()) -> None:
        """source: GLSL with main(). inputs: names of its arrays. outputs: of its vec4s. constants: (type, name)."""
        info = gpu.types.GPUShaderCreateInfo()
        for slot, name in enumerate(inputs):
            info.sampler(slot, "FLOAT_2D", name)
        for kind, name in constants:
            info.push_constant(kind, name)
        info.vertex_in(0, "VEC2", "corner")
        for slot, name in enumerate(outputs):
            info.fragment_out(slot, "VEC4", name)
        info.vertex_source(shaders.source("preview/pass_vertex"))
        info.fragment_source(source)
        self._shader = gpu.shader.create_from_info(info)
        layout = gpu.types.GPUVertFormat()
        layout.attr_add(id="corner", comp_type="F32", len=2, fetch_mode="FLOAT")
        corners = gpu.types.GPUVertBuf(layout, 3)
        corners.attr_fill("corner", np.array([(-1, -1), (3, -1), (-1, 3)], np.float32))  # covers all of the target
        self._batch = gpu.types.GPUBatch(type="TRIS", buf=corners)

    def run(self, target: Target, inputs: dict[str, gpu.types.GPUTexture], **constants: Any) -> None:
        """Write every texel of the target. The caller has switched depth test and blending off."""
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


class Passes:
    """The compiled shaders, shared by all objects."""

    def __init__(self) -> None:
        def source(name: str) -> str:
            return shaders.source(*shaders.FORMULAS, "preview/texels", f"preview/{name}")

        self.crush = Pass(source("crush"),
                          ("vertices", "wishes", "neighbours", "positions", "normals", "before", "stretches"),
                          ("out_waves", "out_crushed"),
                          (("FLOAT", "strength"), ("BOOL", "true_lengths"), ("BOOL", "adaptive")))
        self.link = Pass(source("link"), ("neighbours", "waves", "crushed", "positions", "solved"),
                         ("out_link", "out_solved"))
        self.wake = Pass(source("wake"), ("vertices", "solved"), ("out_share",))
        self.relax = Pass(source("relax"), ("vertices", "links", "shares", "phases"), ("out_phase",),
                          (("FLOAT", "rate"),))
        self.unfold = Pass(source("unfold"), ("fans", "fan_corners", "positions"), ("out_u", "out_v"))


def plain_state() -> None:
    """Drawing state in which passes run."""
    gpu.state.blend_set("NONE")
    gpu.state.depth_test_set("NONE")
    gpu.state.depth_mask_set(False)
    gpu.state.face_culling_set("NONE")


# ---------------------------------------------------------------- the field of one object
class GpuField:
    """The textures of one object: what the rest pose, the settings and the paint fix, and the state."""

    def __init__(self, passes: Passes, model: Any, true_lengths: bool = True) -> None:
        """model: WrinkleFieldModel. Cost: O(edges), once."""
        self._passes = passes
        self._true_lengths = true_lengths
        self.vertex_count = model.vertex_count
        start, neighbours = model.neighbour_start, model.neighbours
        self._first, self._counts = start[:-1], np.diff(start)
        self._has_frame = model.tangent_rest.any(axis=1)
        owners = np.repeat(np.arange(self.vertex_count), self._counts)
        self._neighbours = upload(np.column_stack((neighbours, model.gradients, owners)))
        self._links = [Target(len(neighbours), 2) for _ in range(2)]  # ping-pong: link reads what it solved before
        self._shares = Target(self.vertex_count)
        self._waves = [Target(self.vertex_count, 2) for _ in range(2)]  # ping-pong: crush reads the k of before
        self._phases = [Target(self.vertex_count) for _ in range(2)]  # ping-pong, as figure 2 has it
        self._fans = Target(1, 2)
        self._fan_arrays: tuple | None = None
        if len(model.uv_fan):
            self._collect_fans(model)
        self._positions = self._normals = self._stretches = None
        self._start_phase = self._start_direction = self._start_solved = None

    def _collect_fans(self, model: Any) -> None:
        fan, uv = model.uv_fan, model.uv.reshape(-1, 3, 2)
        order = np.argsort(fan, kind="stable")
        counts = np.bincount(fan)
        corners = np.zeros((len(fan), 2, 4), np.float32)
        triangle = order // 3
        corners[:, 0, :3] = model.triangles[triangle]
        corners[:, 1, :2] = (uv[:, 1] - uv[:, 0])[triangle]
        corners[:, 1, 2:] = (uv[:, 2] - uv[:, 0])[triangle]
        self._fans = Target(len(counts), 2)
        self._fan_arrays = (upload(np.column_stack((np.cumsum(counts) - counts, counts))),
                            upload(corners.reshape(-1, 4)))

    def set_wishes(self, settings: Any, wishes: Any, profile: Any) -> None:
        """settings: WrinkleFieldSettings; wishes: WrinkleFieldWishes; profile: WrinkleFieldProfile."""
        self._strength, self._rate = float(settings.strength), float(settings.rate)
        wavelength = np.where(self._has_frame, wishes.wavelength, 0.0)
        self._vertices = upload(np.column_stack((self._first, self._counts, wavelength, wishes.mask)))
        self._wishes = upload(np.column_stack((wishes.rest_wrinkle, wishes.turn)))
        self.profile = upload(np.column_stack((profile.height, profile.slope)))

    def begin(self, phase: np.ndarray, direction: np.ndarray, solved_offset: np.ndarray | None = None) -> None:
        """The state of the frame before, as a WrinkleFieldState has it. Without solved_offset no vertex is held."""
        self._start_phase, self._start_direction = upload(phase[:, None]), upload(direction)
        self.wake()
        if solved_offset is not None:
            self._start_solved = upload(solved_offset[:, None])

    def wake(self) -> None:
        """Let no vertex be held in the next frame."""
        self._start_solved = upload(np.full((self._links[0].count, 1), _NEVER, np.float32))

    def pose(self, positions: np.ndarray, normals: np.ndarray, stretches: np.ndarray | None = None) -> None:
        """Welded vertices of this frame, (w, 3) both. All that a frame uploads, unless the rest shape adapts.

        stretches: (w, 3) of reference_stretches of the native side; empty or None where it does not.
        """
        self._positions, self._normals = upload(positions), upload(normals)
        self._stretches = upload(stretches) if stretches is not None and len(stretches) else None

    def crush(self) -> None:
        """Section 4.2, then what relax() needs of it. Cost: O(edges)."""
        before = self._start_direction or self._waves[0].textures[1]
        self._start_direction = None
        self._waves.reverse()
        self._passes.crush.run(self._waves[0], {
            "vertices": self._vertices, "wishes": self._wishes, "neighbours": self._neighbours, "before": before,
            "positions": self._positions, "normals": self._normals,
            "stretches": self._stretches or self._positions},
            strength=self._strength, true_lengths=self._true_lengths, adaptive=self._stretches is not None)
        waves, crushed = self._waves[0].textures
        solved = self._start_solved or self._links[0].textures[1]
        self._start_solved = None
        self._links.reverse()
        self._passes.link.run(self._links[0], {"neighbours": self._neighbours, "waves": waves, "crushed": crushed,
                                               "positions": self._positions, "solved": solved})
        self._passes.wake.run(self._shares, {"vertices": self._vertices, "solved": self._links[0].textures[1]})

    def relax(self, rounds: int) -> None:
        """So many rounds of equation (6). Cost: O(rounds x edges)."""
        for _ in range(rounds):
            self._passes.relax.run(self._phases[1], {
                "vertices": self._vertices, "links": self._links[0].textures[0], "shares": self._shares.textures[0],
                "phases": self.phases}, rate=self._rate)
            self._phases.reverse()
            self._start_phase = None

    def unfold(self) -> None:
        """Gradients of the texture for parallax; nothing without a UV map. Cost: O(triangles)."""
        if self._fan_arrays is not None:
            fans, corners = self._fan_arrays
            self._passes.unfold.run(self._fans, {"fans": fans, "fan_corners": corners, "positions": self._positions})

    # ------------------------------------------------------------ what was computed
    @property
    def phases(self) -> gpu.types.GPUTexture:
        return self._start_phase or self._phases[0].textures[0]

    def arrays(self) -> dict[str, gpu.types.GPUTexture]:
        """The textures that the render stage reads."""
        u_slopes, v_slopes = self._fans.textures
        return {"positions": self._positions, "normals": self._normals, "waves": self._waves[0].textures[0],
                "phases": self.phases, "profile": self.profile, "u_slopes": u_slopes, "v_slopes": v_slopes}

    def read_phase(self) -> np.ndarray:
        """(w,) radians. For tests and measurements: waits for the GPU."""
        return read(self.phases, self.vertex_count)[:, 0]

    def read_waves(self) -> tuple[np.ndarray, np.ndarray]:
        """(w, 4) wave vector and h; (w, 4) k, fullness, r. As read_phase()."""
        return self._waves[0].read(0), self._waves[0].read(1)

    def read_uv_slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """(fans, 4) du/dx' and dv/dx'. As read_phase()."""
        return self._fans.read(0), self._fans.read(1)
