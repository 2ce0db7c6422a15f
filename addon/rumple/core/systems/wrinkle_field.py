# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Field as a system of the engine, on plain arrays. Never imports bpy."""
from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ...native import kernels
from ..base.wording import user_error
from ..cloth.base_cloth import bend_radius
from ..frame.engine import MOST_VERTICES, PROFILE, Wrinkles
from ..frame.frame_input import FrameInput
from ..mesh.base_mesh import BaseMesh
from ..mesh.body import Body
from ..mesh.frame_result import COMMON_ATTRIBUTES, Attribute, FrameResult, PreviewFrame
from ..paint.fold_guides import ALONG
from ..parts.cloth_surface import checked_surface
from ..settings.system_settings import FieldSettings
from .coarse_mesh import cloth_mesh

# Attributes that the shader node group reads (../blender/nodes/field_shader.py).
PHASE, WEIGHT = "rumple_wave_phase", "rumple_wave_weight"
VECTORS = ("rumple_wave_vector_0", "rumple_wave_vector_1", "rumple_wave_vector_2")
U_GRADIENT, V_GRADIENT = "rumple_u_gradient", "rumple_v_gradient"


def suggested_wavelength(base: BaseMesh, unit_scale: float) -> float:
    """A distance between folds that suits the mesh, in metres, with two significant digits.

    It is two edge lengths. The direction of the waves is known only at the vertices, and finer waves would show how it
    changes between them.
    """
    edge = base.mean_edge() * unit_scale
    return float(f"{2.0 * edge:.2g}") if edge > 0.0 else FieldSettings.wavelength


SKIN_WAVELENGTH = 0.012  # metres: from furrow to furrow on a raised forehead
SKIN_OF_HEAD = 0.05  # the same as a share of the diagonal of a head, for small ones


def skin_wavelength(base: BaseMesh, unit_scale: float) -> float:
    """The same for the furrows of skin, which do not become finer on a dense mesh. Metres."""
    furrow = min(SKIN_WAVELENGTH, SKIN_OF_HEAD * base.diagonal() * unit_scale)
    return max(suggested_wavelength(base, unit_scale), furrow)


# The height of waves grows with the square root of the compression. Without a threshold, resting cloth that is a
# hundredth shorter in places would show waves of 3 mm.
CLOTH_DEFAULTS = dict(buckling_threshold=0.02)
SIMULATED_DEFAULTS = dict(buckling_threshold=0.01)


def native_profile(kind: str, drawn: np.ndarray | None) -> Any:
    """The native table of f and df/dphi. drawn: PROFILE_INTERVALS + 1 heights in -1..1 for kind CURVE."""
    return kernels.WrinkleFieldProfile(kind, drawn if kind == "CURVE" else None)


class WrinkleField(Wrinkles):
    """Waves on the base: only in its shading, or as geometry of a fine mesh."""

    ATTRIBUTES = COMMON_ATTRIBUTES + (
        Attribute("rumple_amplitude"), Attribute("rumple_phase", angle=True),
        Attribute("rumple_direction", vector=True, unit=True),
        Attribute(PHASE, True, "CORNER", angle=True), Attribute(WEIGHT, True, "CORNER"),
        *(Attribute(name, True, "CORNER") for name in VECTORS),
        Attribute(U_GRADIENT, True, "CORNER"), Attribute(V_GRADIENT, True, "CORNER"))

    model: kernels.WrinkleFieldModel
    HEIGHT_PAINT = "mask"
    suggested_length = staticmethod(suggested_wavelength)

    @classmethod
    def build(cls, base: BaseMesh, settings: FieldSettings, *, unit_scale: float = 1.0,
              most_vertices: int = MOST_VERTICES) -> "WrinkleField":
        """Bind the waves to the base. See Wrinkles.build()."""
        base, surface, warnings = checked_surface(base, settings.weld, settings.rigid_parts, unit_scale)
        longest = settings.wavelength / settings.detail
        level = base.level_for(longest, unit_scale)
        if settings.output == "GEOMETRY" and settings.source == "SUBDIVISION":
            level, notes = base.level_within(level, 0, most_vertices)
            warnings += notes
        try:
            model = kernels.build_wrinkle_field(
                surface, output=settings.output, uv=base.uv if settings.output == "SHADING" else None,
                source=settings.source, level=level, longest_edge=longest / unit_scale,
                most_vertices=most_vertices, attachment=settings.attachment)
        except ValueError as error:
            raise user_error(base.name, error) from error
        field = cls(base, base, surface, model, warnings, unit_scale)
        field.find_cloth_mesh = functools.partial(cloth_mesh, base, surface, settings.weld, settings.up, unit_scale)
        return field

    def _status(self, report: Any) -> list[str]:
        lines = [f"{report.wrinkled} of {self.model.vertex_count} vertices wrinkle",
                 f"Phases are off by {360.0 * report.misfit_after:.0f} degrees on average"]
        if report.collapsed:
            vertices = "vertex has" if report.collapsed == 1 else "vertices have"
            lines.append(f"{report.collapsed} {vertices} only collapsed triangles around in this pose")
        return lines

    # --- for the GPU preview (../blender/viewport/preview.py)
    def wave_parameters(self, settings: FieldSettings) -> tuple[Any, Any, Any]:
        """(settings, wave parameters, profile), native, with the paint of the last solve."""
        options = self._native_settings(settings)
        wave_parameters = kernels.wave_parameters_wrinkle_field(self.model, options, self._paint)
        return options, wave_parameters, native_profile(settings.profile, self._drawn)

    def reference_stretches(self, state: Any, positions: np.ndarray) -> np.ndarray:
        """(w, 3) stretches of every welded vertex in the pose of a WrinkleFieldState; empty if the rest shape is not
        adaptive."""
        return kernels.reference_stretches(self.model, state, positions)

    def share_with_place(self, settings: FieldSettings, positions: np.ndarray, state: Any) -> np.ndarray | None:
        """(w,) 0..1: factor on the waves of every welded vertex, lower where waves would run along a bent line, because
        the preview's shaders do not test this. None: 1 everywhere, as without a base cloth. positions: (n, 3) under the
        waves. state: of the pose."""
        options = self._native_settings(settings)
        if options.bend_radius == 0.0:
            return None
        straight = kernels.estimate_waves_wrinkle_field(self.model, options, self._paint, positions, state).fullness
        options.bend_radius = 0.0
        whole = kernels.estimate_waves_wrinkle_field(self.model, options, self._paint, positions, state).fullness
        return np.divide(straight, whole, out=np.ones_like(whole), where=whole > 0.0)

    def _take_paint(self, paint: dict[str, np.ndarray]) -> Any:
        # the preview's shaders do not support directions
        self._drawn, self.previewed = paint.get(PROFILE), ALONG not in paint
        return kernels.WrinkleFieldPaint(
            {name: np.ascontiguousarray(values, np.float32) for name, values in paint.items() if name != PROFILE})

    def _pose(self, positions: np.ndarray, frame_input: FrameInput) -> Any:
        return kernels.WrinkleFieldPose.of(self.model, positions, frame_input.seconds, frame_input.labels)

    def _solve(self, settings: FieldSettings, pose: Any, before: Any, same_settings: bool,
               frame_input: FrameInput) -> tuple[Any, Any]:
        if before is not None and not same_settings:
            before = before.activated()  # with other settings no vertex may stay asleep
        return kernels.solve_wrinkle_field(self.model, self._native_settings(settings), self._paint, pose, before)

    def _may_wait(self, settings: FieldSettings, frame_input: FrameInput) -> bool:
        self.model.weld_pose(frame_input.animated)  # raises the errors of a later solve already now
        # In all other cases the preview needs the state.
        return (self.previewed and settings.output == "SHADING" and settings.base_cloth == "OFF"
                and frame_input.body is None and not settings.adapts and not settings.stateless)

    def _preview(self, settings: FieldSettings, positions: np.ndarray, pose: Any, state: Any,
                 frame_input: FrameInput) -> FrameResult | PreviewFrame:
        if self.previewed and settings.output == "SHADING" and frame_input.cloth is None:
            return PreviewFrame()
        return self._show(settings, positions, pose, state, frame_input)

    def _show(self, settings: FieldSettings, positions: np.ndarray, pose: Any, state: Any,
              frame_input: FrameInput) -> FrameResult:
        gap = None if frame_input.cloth is None else frame_input.cloth.gap
        shown = kernels.show_wrinkle_field(self.model, self._native_settings(settings),
                                           native_profile(settings.profile, self._drawn), self._paint, pose, state,
                                           gap, pose.solved)
        own = dict(rumple_amplitude=shown.amplitude, rumple_phase=shown.phase, rumple_direction=shown.direction)
        nothing = np.zeros((len(self.corner_vertex), 3), np.float32)
        corners = {PHASE: shown.corner_phase, WEIGHT: shown.corner_weight,
                   **dict(zip(VECTORS, shown.corner_wave_vector)),
                   U_GRADIENT: shown.corner_u_gradient, V_GRADIENT: shown.corner_v_gradient}
        # With geometry, or without a UV map, there are no such values: the shader has nothing to do.
        own.update({name: self.on_corners(values) if len(values) else nothing for name, values in corners.items()})
        return self._result(shown, frame_input, **own)

    def _worn_cloth(self, frame: float, positions: np.ndarray, settings: Any) -> Body | None:
        if settings.output == "SHADING" and self._cloth_at(frame) is None:
            return None  # only drawn: a frame that waits need not be solved for it
        return super()._worn_cloth(frame, positions, settings)

    def _crests(self, settings: FieldSettings, positions: np.ndarray, pose: Any, state: Any) -> np.ndarray | None:
        if settings.output == "SHADING":
            return None  # these waves have no height
        waves = kernels.shown_waves_wrinkle_field(self.model, self._native_settings(settings),
                                                  native_profile(settings.profile, self._drawn), self._paint, positions,
                                                  state)
        return (waves.height[:, None] * waves.normals)[self.model.welded_of]

    def _native_settings(self, settings: FieldSettings) -> Any:
        options = kernels.WrinkleFieldSettings()
        for name in ("strength", "buckling_threshold", "rate", "rounds", "start_rounds", "irregularity", "seed",
                     "keep_length", "dissolve"):
            setattr(options, name, getattr(settings, name))
        options.aligned_start = settings.start == "ALIGNED"
        options.wavelength = settings.wavelength / self.unit_scale
        options.bend_radius = bend_radius(settings, settings.wavelength, self.unit_scale)
        settings.fill_reference(options)
        return options
