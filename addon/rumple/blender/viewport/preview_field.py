# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Field on the GPU: the passes of Loviscach 2006, figure 2, over RGBA32F textures.

One texel per welded vertex. Per frame, only the deformed positions and normals are uploaded.
"""
from __future__ import annotations

from typing import Any, Callable

import bpy
import gpu
import numpy as np

from ...core.systems.wrinkle_field import WrinkleField
from ..objects import runtimes
from . import glsl, gpu_arrays
from .gpu_arrays import Pass, Target, upload

_NEVER = 1e30  # an impossible offset: the link counts as never relaxed


class Passes:
    """The compiled shaders, shared by all objects."""

    def __init__(self) -> None:
        def source(name: str) -> str:
            return glsl.source(*glsl.FORMULAS, "preview/texels", f"preview/{name}")

        self.estimate_waves = Pass(
            source("estimate_waves"),
            ("vertices", "wave_parameters", "neighbours", "positions", "normals", "before", "stretches"),
            ("out_waves", "out_estimate"), (("FLOAT", "strength"), ("FLOAT", "buckling_limit"),
                                            ("BOOL", "true_lengths"), ("BOOL", "adaptive")))
        self.edge_offsets = Pass(source("edge_offsets"), ("neighbours", "waves", "estimate", "positions", "solved"),
                                 ("out_link", "out_solved"))
        self.activity = Pass(source("activity"), ("vertices", "solved"), ("out_activity",))
        self.relax = Pass(source("relax"), ("vertices", "links", "activities", "phases"), ("out_phase",),
                          (("FLOAT", "relax_rate"),))
        self.dissolve = Pass(source("dissolve"), ("vertices", "links", "waves", "phases"), ("out_waves",))
        self.unfold = Pass(source("unfold"), ("fans", "fan_corners", "positions"), ("out_u", "out_v"))


# ---------------------------------------------------------------- the field of one object
class GpuField:
    """The textures of one object: values that depend only on rest pose, settings and paint, and the state."""

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
        self._links = [Target(len(neighbours), 2) for _ in range(2)]  # ping-pong: link reads its former result
        self._activities = Target(self.vertex_count)
        self._waves = [Target(self.vertex_count, 2) for _ in range(2)]  # two, because estimate_waves reads the former k
        self._dissolved = Target(self.vertex_count)
        self._phases = [Target(self.vertex_count) for _ in range(2)]  # ping-pong, as in figure 2
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

    def set_wave_parameters(self, settings: Any, wave_parameters: Any, profile: Any) -> None:
        """settings: WrinkleFieldSettings; wave_parameters: WrinkleFieldWaveParameters; profile: WrinkleFieldProfile."""
        self._strength, self._rate = float(settings.strength), float(settings.rate)
        self._threshold = float(settings.buckling_threshold)
        self._dissolves = bool(settings.dissolve)
        self._wavelength = np.where(self._has_frame, wave_parameters.wavelength, 0.0)
        self._mask = wave_parameters.mask
        self._upload_vertices(self._mask)
        self._wave_parameters = upload(np.column_stack((wave_parameters.rest_wrinkle, wave_parameters.turn)))
        self.profile = upload(np.column_stack((profile.height, profile.slope)))

    def _upload_vertices(self, mask: np.ndarray) -> None:
        self._vertices = upload(np.column_stack((self._first, self._counts, self._wavelength, mask)))

    def begin(self, phase: np.ndarray, direction: np.ndarray, solved_offset: np.ndarray | None = None) -> None:
        """Set the state of the frame before, from a WrinkleFieldState. Without solved_offset no vertex sleeps."""
        self._start_phase, self._start_direction = upload(phase[:, None]), upload(direction)
        if solved_offset is None:
            self.hold_none()
        else:
            self._start_solved = upload(solved_offset[:, None])

    def hold_none(self) -> None:
        """Let no vertex sleep in the next frame."""
        self._start_solved = upload(np.full((self._links[0].count, 1), _NEVER, np.float32))

    def pose(self, positions: np.ndarray, normals: np.ndarray, stretches: np.ndarray | None = None,
             place: np.ndarray | None = None) -> None:
        """Upload this frame's welded vertices, both (w, 3). A frame uploads more only if the rest shape adapts or the
        waves are on a base cloth.

        stretches: (w, 3), reference_stretches of the native side; empty or None if the rest shape does not adapt.
        place: (w,) from WrinkleField.share_with_place(); None: 1 everywhere.
        """
        if place is not None:
            self._upload_vertices(self._mask * place)
        self._positions, self._normals = upload(positions), upload(normals)
        self._stretches = upload(stretches) if stretches is not None and len(stretches) else None

    def estimate_waves(self) -> None:
        """Section 4.2, and the inputs of relax(). Cost: O(edges)."""
        before = self._start_direction or self._waves[0].textures[1]
        self._start_direction = None
        self._waves.reverse()
        self._passes.estimate_waves.run(self._waves[0], {
            "vertices": self._vertices, "wave_parameters": self._wave_parameters, "neighbours": self._neighbours,
            "before": before,
            "positions": self._positions, "normals": self._normals,
            "stretches": self._stretches or self._positions},
            strength=self._strength, buckling_limit=self._threshold, true_lengths=self._true_lengths,
            adaptive=self._stretches is not None)
        waves, estimate = self._waves[0].textures
        solved = self._start_solved or self._links[0].textures[1]
        self._start_solved = None
        self._links.reverse()
        self._passes.edge_offsets.run(self._links[0], {
            "neighbours": self._neighbours, "waves": waves, "estimate": estimate, "positions": self._positions,
            "solved": solved})
        self._passes.activity.run(self._activities, {"vertices": self._vertices, "solved": self._links[0].textures[1]})

    def relax(self, rounds: int) -> None:
        """This number of rounds of equation (6). Cost: O(rounds x edges)."""
        for _ in range(rounds):
            self._passes.relax.run(self._phases[1], {
                "vertices": self._vertices, "links": self._links[0].textures[0],
                "activities": self._activities.textures[0], "phases": self.phases}, relax_rate=self._rate)
            self._phases.reverse()
            self._start_phase = None

    def dissolve(self) -> None:
        """Fade drawn waves, if the settings ask for it; after relax(). Cost: O(edges)."""
        if self._dissolves:
            self._passes.dissolve.run(self._dissolved, {
                "vertices": self._vertices, "links": self._links[0].textures[0], "waves": self._waves[0].textures[0],
                "phases": self.phases})

    def unfold(self) -> None:
        """Gradients of the texture coordinates for parallax; nothing without a UV map. Cost: O(triangles)."""
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
        waves = (self._dissolved if self._dissolves else self._waves[0]).textures[0]
        return {"positions": self._positions, "normals": self._normals, "waves": waves,
                "phases": self.phases, "profile": self.profile, "u_slopes": u_slopes, "v_slopes": v_slopes}


# ---------------------------------------------------------------- what is drawn
def _compile() -> gpu.types.GPUShader:
    between = gpu.types.GPUStageInterfaceInfo("rumple_field")
    for name in ("phase", "weight", "normal", "place", "u_slope", "v_slope"):
        between.smooth("VEC3", name)
    between.smooth("VEC2", "image_uv")
    for name in ("vector_a", "vector_b", "vector_c"):
        between.flat("VEC3", name)
    return gpu_arrays.drawing_shader(
        between, (("IVEC3", "triangle"), ("INT", "corner"), ("INT", "fan"), ("VEC2", "uv")),
        ("positions", "normals", "waves", "phases", "u_slopes", "v_slopes", "profile", "image", "overlays"),
        ("preview/field_vertex",), (*glsl.FORMULAS, "preview/under_overlays", "preview/field_fragment"),
        constants=gpu_arrays.OVERLAY_CONSTANTS)


class Drawing:
    """The waves of one object; see preview.Drawing."""

    def __init__(self, model: Any) -> None:
        self._model = model
        self.waves = GpuField(gpu_arrays.kept("field passes", Passes), model)
        self.has_uv = len(model.uv) > 0
        self._slots: np.ndarray | None = None  # material slot of every triangle
        self._batches: dict[int, gpu.types.GPUBatch] = {}

    def update(self, obj: bpy.types.Object, runtime: runtimes.Runtime, before: runtimes.Inputs | None,
               slots: np.ndarray) -> bool:
        """Run all stages except the last.

        If the engine solves a frame from the one before, the GPU does so independently. After a jump, after a change at
        the same frame, and until the clip's first frame it uploads the engine's state.
        """
        inputs, evaluator = runtime.inputs, runtime.evaluator
        assert isinstance(evaluator, WrinkleField)
        if before is None or before.settings != inputs.settings or before.paint is not inputs.paint:
            self.waves.set_wave_parameters(*evaluator.wave_parameters(inputs.settings))
        goes_on = before is not None and before.paint is inputs.paint and inputs.goes_on_from(before)
        if not goes_on:
            state = evaluator.wrinkles_of(inputs.frame)
            if state is None:
                return False
            self.waves.begin(state.phase, state.direction, state.solved_offset)
        elif before.settings != inputs.settings:
            self.waves.hold_none()
        settings = inputs.settings
        state = evaluator.wrinkles_of(inputs.frame) if settings.adapts or settings.base_cloth != "OFF" else None
        positions = evaluator.solved_over(inputs.frame, inputs.positions)
        welded, normals = self._model.weld_pose(positions)
        self.waves.pose(welded, normals, evaluator.reference_stretches(state, positions) if state is not None else None,
                        evaluator.share_with_place(settings, positions, state))
        self.waves.estimate_waves()
        self.waves.relax(inputs.settings.rounds if goes_on else 0)
        self.waves.dissolve()
        self.waves.unfold()
        self._collect_batches(slots)
        return True

    def _collect_batches(self, slots: np.ndarray) -> None:
        """Make a batch of separate triangles for every used material slot, if the slots have changed."""
        if self._slots is not None and np.array_equal(slots, self._slots):
            return
        self._slots = slots
        model = self._model
        corners = np.arange(3 * len(slots), dtype=np.int32).reshape(-1, 3)
        uv = model.uv if self.has_uv else np.zeros((corners.size, 2), np.float32)
        fan = model.uv_fan if len(model.uv_fan) else np.zeros(corners.size, np.int32)
        self._batches = {}
        for slot in np.unique(slots):
            chosen = corners[slots == slot].ravel()
            buffer = gpu_arrays.vertex_buffer(triangle=model.triangles[chosen // 3], corner=chosen % 3,
                                              fan=fan[chosen], uv=uv[chosen])
            self._batches[int(slot)] = gpu.types.GPUBatch(type="TRIS", buf=buffer)

    def shader(self) -> gpu.types.GPUShader:
        return gpu_arrays.kept("field", _compile)

    def arrays(self) -> dict[str, gpu.types.GPUTexture]:
        return self.waves.arrays()

    def slots(self) -> list[int]:
        return list(self._batches)

    def present(self, paint: Callable[[], None], over: gpu_arrays.Overlays, _block: gpu.types.GPUUniformBuf) -> None:
        shader = self.shader()
        shader.bind()
        over.bind(shader)
        paint()

    def draw(self, shader: gpu.types.GPUShader, slot: int) -> None:
        self._batches[slot].draw(shader)
