# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Paths as a system of the engine, on plain arrays. Never imports bpy."""
from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ...native import kernels
from ..base.wording import user_error
from ..cloth.base_cloth import bend_radius
from ..cloth.on_cloth import cloth_of
from ..frame.engine import MOST_VERTICES, Wrinkles
from ..frame.frame_input import FrameInput
from ..mesh.base_mesh import BaseMesh
from ..mesh.figure_size import size_of
from ..mesh.frame_result import COMMON_ATTRIBUTES, Attribute, FrameResult, PreviewFrame
from ..paint.paint_maps import WIDTH, fold_width
from ..parts.cloth_surface import checked_surface
from ..settings.system_settings import PathsSettings
from .coarse_mesh import cloth_mesh
from .curve_rows import CurvePoints

# Table 9.1 has 0.5 (and 1 in one clip) for folds of width pi L_min / compression. Ours have pi/2 L_min / compression.
PERCENT_OF_HEIGHT = 1.0


def width_of_height(height: float, percent: float) -> float:
    """Width of the tightest folds for a character of this height, both in metres; three significant digits."""
    return float(f"{0.01 * percent * height:.3g}")


def suggested_width(base: BaseMesh, unit_scale: float) -> float:
    """A width of the tightest folds that suits the mesh, in metres; two significant digits."""
    edge = base.mean_edge() * unit_scale
    return float(f"{0.7 * edge:.2g}") if edge > 0.0 else PathsSettings.width


CLOTH_WIDTH = 0.025  # metres, for a person's garment: folds that are visible at arm's length
# a base cloth distributes the local compression of skinning, so folds must start at less compression
CLOTH_THRESHOLD = 1.1


def cloth_defaults(base: BaseMesh, unit_scale: float) -> dict[str, Any]:
    """Settings for a garment that becomes cloth, in addition to those of the base cloth. Two significant digits."""
    width = max(suggested_width(base, unit_scale), CLOTH_WIDTH * size_of(base, unit_scale))
    return dict(threshold=CLOTH_THRESHOLD, width=float(f"{width:.2g}"))


def crest_heights(drawing: kernels.WrinklePathsDrawing, triangle_vertex: np.ndarray) -> np.ndarray:
    """(w,) float32: for every welded vertex the height of the highest fold that reaches a triangle around it, object
    units. triangle_vertex: (t, 3) int32, welded vertices of the triangles."""
    lists, heights = drawing.lists, np.zeros(len(drawing.hem), np.float32)
    if not len(lists.ranges):
        return heights
    at_ends = np.append(lists.ends[:, -1], np.float32(0.0))  # a range may include the last end
    of_ranges = np.maximum.reduceat(at_ends, (lists.ranges + (0, 1)).ravel())[::2]
    triangles = np.repeat(np.arange(len(triangle_vertex)), np.diff(lists.triangle_start))
    np.maximum.at(heights, triangle_vertex[triangles], of_ranges[:, None])
    return heights


class WrinklePaths(Wrinkles):
    """Folds traced over the base, on a fine mesh."""

    ATTRIBUTES = (*COMMON_ATTRIBUTES, Attribute("rumple_height"))
    model: kernels.WrinklePathsModel
    SUGGESTED = "width"
    HEIGHTS = ("rumple_height",)
    HAS_CURVES = True

    suggested_length = staticmethod(suggested_width)

    @classmethod
    def build(cls, base: BaseMesh, settings: PathsSettings, *, unit_scale: float = 1.0,
              most_vertices: int = MOST_VERTICES) -> "WrinklePaths":
        """Make the fine mesh and bind it. See Wrinkles.build()."""
        base, surface, warnings = checked_surface(base, settings.weld, settings.rigid_parts, unit_scale)
        longest = base.narrowest * settings.width / settings.detail
        level = base.level_for(longest, unit_scale)
        if settings.source == "SUBDIVISION":
            level, notes = base.level_within(level, 0, most_vertices)
            warnings += notes
        try:
            model = kernels.build_wrinkle_paths(
                surface, source=settings.source, level=level,
                longest_edge=longest / unit_scale, most_vertices=most_vertices, attachment=settings.attachment)
        except ValueError as error:
            raise user_error(base.name, error) from error
        paths = cls(base, base, surface, model, warnings, unit_scale)
        paths.find_cloth_mesh = functools.partial(cloth_mesh, base, surface, settings.weld, settings.up, unit_scale)
        return paths

    def _status(self, report: Any) -> list[str]:
        lines = [f"{report.paths} folds; {report.born} started and {report.died} ended in this frame",
                 f"{report.compressed} of {self.model.triangle_count} triangles are being compressed, "
                 f"{report.stretched} stretched"]
        if report.collapsed_triangles:
            lines.append(f"{report.collapsed_triangles} coarse triangles have no area in this pose")
        return lines

    def curves(self, frame: float, positions: np.ndarray, settings: PathsSettings) -> Any:
        animated = None if cloth_of(self.state_of(frame)) is None else self.base.points(positions)
        riding = kernels.ride_wrinkle_paths(self.model, self._native_settings(settings),
                                            self._pose_at(frame, positions), self.wrinkles_of(frame), animated)
        return CurvePoints.of(riding, self.base.origin)

    def labels_and_ellipses(self, frame: float, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The values that determine the paths of a solved frame: corners (t, 3, 3) of the triangles, labels (t,) uint8
        (0 compressed, 1 at rest, 2 stretched) and ellipses (t, 9): centre and two semi-axes. Object space."""
        state, pose = self.wrinkles_of(frame), self._pose_at(frame, positions)
        corners = self.solved_over(frame, positions)[self.base.triangles]
        return corners, state.labels, kernels.wrinkle_path_ellipses(self.model, pose, state)

    def curve_points(self, settings: PathsSettings) -> float:
        """For folds side by side. A fold has two points in each triangle that it crosses, and two in each width."""
        base = self.base
        a, b, c = (base.positions[base.triangles[:, k]] for k in range(3))
        area = 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) * self.unit_scale**2
        edge = max(base.mean_edge() * self.unit_scale, 1e-6)
        apart = max(settings.spacing, 1.0) * settings.width
        return area / apart * max(4.0 / edge, 2.0 / settings.width)

    def _take_paint(self, paint: dict[str, np.ndarray]) -> Any:
        factors = {name: values for name, values in paint.items() if name != WIDTH}
        if WIDTH in paint:
            factors["width"] = fold_width(paint[WIDTH])
        return kernels.WrinklePathsPaint(self.model, factors)

    def _pose(self, positions: np.ndarray, frame_input: FrameInput) -> Any:
        return kernels.WrinklePathsPose.of(self.model, positions, frame_input.seconds, frame_input.labels)

    def _solve(self, settings: PathsSettings, pose: Any, before: Any, same_settings: bool,
               frame_input: FrameInput) -> tuple[Any, Any]:
        return kernels.solve_wrinkle_paths(self.model, self._native_settings(settings), self._paint, pose,
                                           frame_input.seconds, state=before)

    def _show(self, settings: PathsSettings, positions: np.ndarray, pose: Any, state: Any,
              frame_input: FrameInput) -> FrameResult:
        shown = kernels.show_wrinkle_paths(self.model, self._native_settings(settings), pose, state)
        return self._result(shown, frame_input, rumple_height=shown.height)

    def _preview(self, settings: PathsSettings, positions: np.ndarray, pose: Any, state: Any,
                 frame_input: FrameInput) -> FrameResult | PreviewFrame:
        if self._by_hand:  # the GPU preview cannot draw changes by hand
            return self._show(settings, positions, pose, state, frame_input)
        drawing = kernels.draw_wrinkle_paths(self.model, self._native_settings(settings), pose, state)
        off = positions - frame_input.animated if frame_input.cloth is not None else np.float32(0.0)
        return PreviewFrame(drawing, (drawing.proxy_offset + off)[:self.coarse_count])

    def _crests(self, settings: PathsSettings, positions: np.ndarray, pose: Any, state: Any) -> np.ndarray | None:
        drawing = kernels.draw_wrinkle_paths(self.model, self._native_settings(settings), pose, state)
        welded = self.model.triangle_vertex
        heights = drawing.hem * crest_heights(drawing, welded)
        crests = np.zeros_like(positions)
        crests[self.base.triangles] = (heights[:, None] * drawing.normal)[welded]
        return crests

    def _native_settings(self, settings: PathsSettings) -> Any:
        options = kernels.WrinklePathsSettings()
        for name in ("smoothing", "threshold", "reach", "spacing", "alignment", "hem_rings", "growth_limit", "fade",
                     "seed", "height", "direction", "profile"):
            setattr(options, name, getattr(settings, name))
        settings.fill_reference(options)
        options.width = settings.width / self.unit_scale
        # wavelength: two widths, a fold and the gap to the next
        options.bend_radius = bend_radius(settings, 2.0 * settings.width, self.unit_scale)
        return options
