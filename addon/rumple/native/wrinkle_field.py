# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Field: native/include/rumple/wrinkle_field.h. J. Loviscach, Wrinkling Coarse Meshes on the GPU, 2006."""
from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from . import c
from .arrays import FLOAT, INT, checked, fill, given, optional
from .handle import Array, Handle, Number
from .library import lib
from .struct import chosen
from .surface import (FramePose, FrameState, Model, ReferenceSettings, ShownFrame, Surface, fill_reference, fine_plan,
                      reference_arrays, stored_array)

PROFILE_INTERVALS = c.PROFILE_INTERVALS


class WrinkleFieldModel(Model):
    """Neighbourhoods of a base at rest, and the shown mesh. Made by build_wrinkle_field. w welded vertices."""

    __slots__ = ("base",)
    base: Surface
    POINTER, FREE = c.WrinkleFieldPointer, "rumple_wrinkle_field_free"
    VIEW, LOOK = c.WrinkleFieldView, "rumple_wrinkle_field_get_view"
    SHOWN, LABEL = "rumple_wrinkle_field_shown", "rumple_wrinkle_field_label_clip"

    vertex_count = Number("w")
    neighbour_start = Array("(w + 1,) int32", INT, "vertex_count", more=1)
    neighbours = Array("(n,) int32 welded vertices", INT, "neighbour_count")
    gradients = Array("(n, 2) float32: M of equation (1) is the sum of v' (x) gradient", FLOAT, "neighbour_count", 2)
    tangent_rest = Array("(w, 3) float32", FLOAT, "vertex_count", 3)
    bitangent_rest = Array("(w, 3) float32", FLOAT, "vertex_count", 3)
    welded_of = Array("(n,) int32: the welded vertex of every vertex of the base", INT, "base_vertex_count")
    triangles = Array("(t, 3) int32 welded vertices of the base's triangles, as they were given", INT,
                      "triangle_count", 3)
    uv = Array("(3 t, 2) float32, per corner of every triangle in turn; or empty", FLOAT, "uv_count", 2)
    uv_fan = Array("(3 t,) int32: corners of one fan share their gradient of uv; or empty", INT, "uv_count")
    first_directions = Array("(w, 2) float32: k that a clip starts from, rest frame", FLOAT, "vertex_count", 2)

    def weld_pose(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 3) float32 of the base's vertices -> positions and unit normals (or zero) of the welded ones,
        two (w, 3) float32."""
        place, count = given(positions, "positions", FLOAT, 3)
        welded, normals = (np.empty((self.vertex_count, 3), FLOAT) for _ in range(2))
        lib.rumple_wrinkle_field_weld_pose(self, place, count, welded.ctypes.data, normals.ctypes.data, len(welded))
        return welded, normals


def build_wrinkle_field(base: Surface, output: str = "SHADING", uv: np.ndarray | None = None,
                        source: str = "SUBDIVISION", level: int = 2, segments: int = 4, longest_edge: float = 0.01,
                        most_vertices: int = 4_000_000, attachment: str = "LIMIT",
                        true_lengths: bool = True) -> WrinkleFieldModel:
    """The model of a base at rest (Loviscach 2006, section 3).

    output: SHADING (the base's triangles; uv: (c, 2) float32 per corner of the base, for parallax) or GEOMETRY (a fine
    mesh, made as in build_wrinkle_mesh). true_lengths: False: projected lengths in equation (1), as in the paper.
    Raises ValueError.
    """
    plan = lib.rumple_wrinkle_field_plan_default()
    plan.output = chosen(output, "output", c.FIELD_OUTPUT)
    fine_plan(plan.fine, source, level, segments, longest_edge, most_vertices, attachment)
    fill(plan, "uv", uv, FLOAT, 2)
    plan.true_lengths = true_lengths
    model = WrinkleFieldModel.made(lib.rumple_wrinkle_field_build, base, plan)
    model.base = base
    return model


class WrinkleFieldSettings(c.WrinkleFieldSettings, ReferenceSettings):
    """Settings of a solve; see docs/wrinkle_field.md."""

    __slots__ = ()

    def __new__(cls) -> "WrinkleFieldSettings":
        return cls.from_buffer_copy(lib.rumple_wrinkle_field_settings_default())


class _Paint(Handle):
    """Painted values, carried to one model."""

    __slots__ = ("model",)
    model: WrinkleFieldModel
    POINTER, FREE = c.WrinkleFieldPaintPointer, "rumple_wrinkle_field_paint_free"


class WrinkleFieldPaint:
    """Painted values of the base's vertices. They belong to the model that they are first used with."""

    COLUMNS = dict(mask=0, wavelength=0, rest_wrinkle=3, along=3)

    def __init__(self, painted: dict[str, np.ndarray] | None = None) -> None:
        """painted: any of mask (n,) 0..1, wavelength (n,) factor > 0, rest_wrinkle (n, 3) shorter than 1, along (n, 3)
        the direction of the crests at rest, with a length of 0..1; float32."""
        for name in painted or {}:
            chosen(name, "paint", {known: 0 for known in self.COLUMNS})
        self._arrays = {name: checked(values, name, FLOAT, self.COLUMNS[name]).copy()
                        for name, values in (painted or {}).items()}
        self._made: _Paint | None = None

    def of(self, model: WrinkleFieldModel) -> _Paint:
        """The library's paint for a model. Raises ValueError if it does not match the model."""
        if self._made is None or self._made.model is not model:
            values = c.WrinkleFieldPainted()
            for name, array in self._arrays.items():
                fill(values, name, array, FLOAT, self.COLUMNS[name])
            made = _Paint.made(lib.rumple_wrinkle_field_paint_build, model, values)
            made.model, self._made = model, made
        return self._made


# The fields of ctypes, which the properties with the same names below hide.
_HEIGHT: Any = c.WrinkleFieldProfile.height
_SLOPE: Any = c.WrinkleFieldProfile.slope


class WrinkleFieldProfile(c.WrinkleFieldProfile):
    """f and df/dphi of the wave, section 6.3."""

    __slots__ = ()

    def __init__(self, kind: str, height: np.ndarray | None = None) -> None:
        """kind: SINE, ACCORDION, PENCIL_PLEATS or CURVE (height: PROFILE_INTERVALS + 1 float32 in -1..1 from crest to
        valley)."""
        if kind == "CURVE" and height is None:
            raise ValueError("height: expected the values of the drawn curve, got None")
        lib.rumple_wrinkle_field_profile_build(chosen(kind, "profile", c.PROFILE),
                                               *optional(height, "height", FLOAT), self)

    @property
    def height(self) -> np.ndarray:  # type: ignore[override]
        """(PROFILE_INTERVALS + 1,) float32"""
        return np.array(_HEIGHT.__get__(self), FLOAT)

    @property
    def slope(self) -> np.ndarray:  # type: ignore[override]
        """(PROFILE_INTERVALS + 1,) float32"""
        return np.array(_SLOPE.__get__(self), FLOAT)


class WrinkleFieldWaves(Handle):
    """The waves of a frame without their phases; w welded vertices."""

    __slots__ = ()
    POINTER, FREE = c.WavesPointer, "rumple_waves_free"
    VIEW, LOOK = c.WavesView, "rumple_waves_get_view"

    positions = Array("(w, 3) float32, deformed, object space", FLOAT, "vertex_count", 3)
    normals = Array("(w, 3) float32, unit or zero", FLOAT, "vertex_count", 3)
    wave_vector = Array("(w, 3) float32, radians per object unit", FLOAT, "vertex_count", 3)
    height = Array("(w,) float32, h, object units", FLOAT, "vertex_count")
    fullness = Array("(w,) float32, h over W/4 before strength", FLOAT, "vertex_count")
    compression = Array("(w,) float32, r", FLOAT, "vertex_count")
    gather = Array("(w,) float32, rest length over length along the wave", FLOAT, "vertex_count")
    direction = Array("(w, 2) float32, k in the rest frame", FLOAT, "vertex_count", 2)


class WrinkleFieldPose(FramePose):
    """The pose of a model in one frame. Made by WrinkleFieldPose.of(model, positions, ...).

    solved: the waves of the last frame that was solved in this pose, for show_wrinkle_field; or None.
    """

    __slots__ = ("solved",)
    solved: WrinkleFieldWaves | None
    POINTER, FREE = c.WrinkleFieldPosePointer, "rumple_wrinkle_field_pose_free"
    BUILD = "rumple_wrinkle_field_pose_build"

    @classmethod
    def of(cls, model: WrinkleFieldModel, positions: "np.ndarray | FramePose", *others: Any, **named: Any) -> Any:
        made = super().of(model, positions, *others, **named)
        if made is not positions:
            made.solved = None
        return made


class WrinkleFieldState(FrameState):
    """The solver's state, which is kept from frame to frame."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleFieldStatePointer, "rumple_wrinkle_field_state_free"
    VIEW, LOOK = c.WrinkleFieldStateView, "rumple_wrinkle_field_state_get_view"

    phase = Array("(w,) float32, radians", FLOAT, "phase_count")
    direction = Array("(w, 2) float32, rest frame", FLOAT, "direction_count", 2)
    solved_offset = Array("(neighbours,) float32, radians: when it was last relaxed", FLOAT, "solved_offset_count")

    def __init__(self, model: WrinkleFieldModel, phase: np.ndarray, direction: np.ndarray, solved_offset: np.ndarray,
                 reference: dict[str, Any] | None = None) -> None:
        """From the values of the properties with these names."""
        arrays = c.WrinkleFieldStateView()
        fill(arrays, "phase", phase, FLOAT)
        fill(arrays, "direction", direction, FLOAT, 2)
        fill(arrays, "solved_offset", solved_offset, FLOAT)
        if reference is not None:
            fill_reference(arrays.reference, reference)
        self._filled(self, lib.rumple_wrinkle_field_state_build, model, arrays)

    @property
    def reference(self) -> dict[str, Any] | None:
        """The adaptive rest shape as plain arrays, or None."""
        return reference_arrays(self, self.view.reference)

    @property
    def arrays(self) -> dict[str, Any]:
        """The state as plain arrays. of() makes the same state from them, bit for bit."""
        return {"phase": self.phase, "direction": self.direction, "solved_offset": self.solved_offset,
                **(self.reference or {})}

    @classmethod
    def of(cls, model: WrinkleFieldModel, arrays: dict[str, Any]) -> "WrinkleFieldState":
        """The state from the plain arrays of `arrays`."""
        phase, direction, offset = (stored_array(arrays, name) for name in ("phase", "direction", "solved_offset"))
        return cls(model, phase, direction, offset, arrays if "time" in arrays else None)

    def activated(self) -> "WrinkleFieldState":
        """The same phases, but no vertex is asleep. Use it before a solve with other settings."""
        return WrinkleFieldState.made(lib.rumple_wrinkle_field_state_activated, self)


class WrinkleFieldReport(c.WrinkleFieldReport):
    """The report on a solve."""

    __slots__ = ()


class WrinkleFieldPicture(ShownFrame):
    """The shown mesh of one frame (d vertices) and its waves (corners of its triangles)."""

    __slots__ = ("_waves",)

    amplitude = Array("(d,) float32, object units", FLOAT, "vertex_count", view="waves")
    direction = Array("(d, 3) float32, unit, rest space", FLOAT, "vertex_count", 3, view="waves")
    phase = Array("(d,) float32, radians", FLOAT, "vertex_count", view="waves")
    corner_phase = Array("(3 t, 3) float32, radians", FLOAT, "corner_count", 3, view="waves")
    corner_weight = Array("(3 t, 3) float32, object units", FLOAT, "corner_count", 3, view="waves")
    corner_wave_vector_0 = Array("(3 t, 3) float32, radians per object unit, of the first corner", FLOAT,
                                 "corner_count", 3, view="waves")
    corner_wave_vector_1 = Array("of the second", FLOAT, "corner_count", 3, view="waves")
    corner_wave_vector_2 = Array("of the third", FLOAT, "corner_count", 3, view="waves")
    corner_u_gradient = Array("(3 t, 3) float32 or empty", FLOAT, "uv_count", 3, view="waves")
    corner_v_gradient = Array("(3 t, 3) float32 or empty", FLOAT, "uv_count", 3, view="waves")

    @property
    def waves(self) -> Any:
        """The struct of the view of the waves."""
        if not hasattr(self, "_waves"):
            waves = c.FrameWavesView()
            lib.rumple_frame_get_waves(self, waves)
            self._waves = waves
        return self._waves

    @property
    def corner_wave_vector(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """three (3 t, 3) float32, radians per object unit"""
        return self.corner_wave_vector_0, self.corner_wave_vector_1, self.corner_wave_vector_2


def solve_wrinkle_field(model: WrinkleFieldModel, settings: WrinkleFieldSettings, paint: WrinkleFieldPaint,
                        positions: np.ndarray | WrinkleFieldPose, state: WrinkleFieldState | None = None,
                        time: float = 0.0, labels: np.ndarray | None = None, next_positions: np.ndarray | None = None,
                        next_time: float = 0.0) -> tuple[WrinkleFieldState, WrinkleFieldReport]:
    """Solve one frame; returns (state, report). positions: (n, 3) float32, deformed base, object space; or a pose. With
    a pose, the arguments after state are not used.

    state: of the frame before, or None for the canonical start. The other arguments are for adaptive rest shapes. time:
    seconds. labels: (t,) uint8 from label_clip. next_positions, next_time: the next frame, which labelling looks ahead
    to. Raises ValueError. Sections 4.2 and 5.2.
    """
    pose = WrinkleFieldPose.of(model, positions, time, labels, next_positions, next_time)
    report, waves = WrinkleFieldReport(), WrinkleFieldWaves.POINTER()
    after = WrinkleFieldState.made(lib.rumple_wrinkle_field_solve, model, settings, paint.of(model), pose, state,
                                   report, ctypes.byref(waves))
    pose.solved = WrinkleFieldWaves.owning(waves) if waves else None
    return after, report


def show_wrinkle_field(model: WrinkleFieldModel, settings: WrinkleFieldSettings, profile: WrinkleFieldProfile,
                       paint: WrinkleFieldPaint, positions: np.ndarray | WrinkleFieldPose, state: WrinkleFieldState,
                       gap: np.ndarray | None = None, waves: WrinkleFieldWaves | None = None) -> WrinkleFieldPicture:
    """The shown mesh for a frame and its state, and the waves for shaders. gap: (n,) float32, how far the waves of a
    fine mesh may move inwards, object units; None: as far as outwards. waves: `solved` of the pose, if the state was
    solved in it with the same settings; None: they are estimated again, with the same bits."""
    return WrinkleFieldPicture.made(lib.rumple_wrinkle_field_show, model, settings, profile, paint.of(model),
                                    WrinkleFieldPose.of(model, positions), *optional(gap, "gap", FLOAT), waves, state)


__all__ = ["PROFILE_INTERVALS", "WrinkleFieldModel", "WrinkleFieldPaint", "WrinkleFieldPicture", "WrinkleFieldPose",
           "WrinkleFieldProfile", "WrinkleFieldReport", "WrinkleFieldSettings", "WrinkleFieldState",
           "WrinkleFieldWaves", "build_wrinkle_field", "show_wrinkle_field", "solve_wrinkle_field"]
