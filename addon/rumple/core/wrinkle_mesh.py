# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Mesh for whoever has arrays: prepare and evaluate. Never imports bpy."""
from __future__ import annotations

import math
from typing import Any

import numpy as np

from .. import native
from .engine import MOST_VERTICES, BaseMesh, Moment, Picture, Refused, Wrinkles, checked_surface
from .settings import MeshSettings

MOST_LEVEL = 5
MOST_PLAYABLE = 60_000  # solved vertices that still play live on a few cores
EDGES_PER_WAVELENGTH = 5.0  # measured on garments with bend stiffness of 0.7 and more
FARTHEST_OWN = 0.25  # an own mesh farther from the base than this share of the base's diagonal is refused


def level_for(base: BaseMesh, wavelength: float, unit_scale: float) -> int:
    """Subdivisions after which the mean edge is nearest to wavelength / 5 (in powers of two), 0 to 5.

    wavelength: metres; unit_scale: metres per object unit.
    """
    edge = base.mean_edge() * unit_scale
    if edge <= 0.0 or wavelength <= 0.0:
        return 0
    return min(max(round(math.log2(edge * EDGES_PER_WAVELENGTH / wavelength)), 0), MOST_LEVEL)


def wavelength_of(base: BaseMesh, level: int, unit_scale: float) -> float:
    """The fold width, in metres, that `level` subdivisions give: the inverse of level_for."""
    return base.mean_edge() * unit_scale * EDGES_PER_WAVELENGTH / 2**level


def fitting_wavelength(base: BaseMesh, unit_scale: float) -> float:
    """Fold width, in metres, that suits a mesh as it is: level 2, or less where that would be too heavy to play.

    Two significant digits, so that the slider shows a round number. The default of a doll, a giant or a dense mesh.
    """
    level = 2
    while level > 0 and len(base.corner_vertex) / 4 * 4**level > MOST_PLAYABLE:
        level -= 1
    wavelength = wavelength_of(base, level, unit_scale)
    return float(f"{wavelength:.2g}") if wavelength > 0.0 else MeshSettings.wavelength


class WrinkleMesh(Wrinkles):
    """A fine mesh that is solved over the base."""

    fitting_length = staticmethod(fitting_wavelength)

    @classmethod
    def build(cls, base: BaseMesh, settings: MeshSettings, *, unit_scale: float = 1.0, own: BaseMesh | None = None,
              attached: np.ndarray | None = None) -> "WrinkleMesh":
        """Make the fine mesh and bind it.

        unit_scale: metres per object unit. own: the artist's mesh at rest, in the base's object space.
        attached: (n,) bool per vertex of own. Raises Refused.
        """
        if settings.source == "OBJECT" and own is None:
            raise Refused(f"{base.name}: choose your own fine mesh first")
        surface, warnings = checked_surface(base, settings.weld, unit_scale)
        own_surface = own.surface(False) if own is not None and settings.source == "OBJECT" else None
        level = settings.level if settings.density == "LEVEL" else level_for(base, settings.wavelength, unit_scale)
        try:
            model = native.load().build_wrinkle_mesh(
                surface, source=settings.source, level=level, segments=settings.segments,
                longest_edge=settings.edge_length / unit_scale, most_vertices=MOST_VERTICES, own=own_surface,
                attached=None if attached is None else np.ascontiguousarray(attached, np.uint8),
                farthest=FARTHEST_OWN * base.diagonal(), attachment=settings.attachment,
                display_steps=settings.display_steps, adaptive=settings.rest_shape == "ADAPTIVE")
        except ValueError as error:
            raise Refused(f"{base.name}: {error}") from error
        if own_surface is not None:
            warnings += [f"{own.name}: {w}" for w in own_surface.warnings]
            if attached is not None and not attached.all():
                warnings.append(f"{own.name}: {int((~attached.astype(bool)).sum())} vertices are not attached")
        mesh = cls(base, own if own_surface is not None else base, model, warnings, unit_scale)
        mesh.edge_mean, mesh.level = float(model.local_edge.mean()) * unit_scale, level
        return mesh

    @property
    def solve_vertex_count(self) -> int:
        return self.model.solved_vertex_count

    def status(self, picture: Picture) -> list[str]:
        report = picture.report
        before, after = 100.0 * report.error_before, 100.0 * report.error_after
        lines = [f"{self.solve_vertex_count} vertices are solved", f"Fine edge {1000.0 * self.edge_mean:.2f} mm",
                 f"Edge length error {before:.1f} % before, {after:.1f} % after {report.iterations} iterations"]
        if report.collapsed_triangles:
            lines.append(f"{report.collapsed_triangles} coarse triangles have no area in this pose")
        return lines

    def measure_frame(self, frame: float, positions: np.ndarray, settings: MeshSettings) -> Any:
        """Edge errors, areas and violations of a stored frame; None when it is not stored."""
        entry = self.history.get(frame)
        if entry is None or self._paint is None:
            return None
        return native.load().measure_wrinkle_mesh(self.model, native_settings(settings), self._paint, positions,
                                                  entry.state)

    def _reads_world(self, settings: MeshSettings) -> bool:
        return settings.offset_space == "WORLD"

    def _reads_time(self, settings: MeshSettings) -> bool:
        return settings.adapts

    def _native_settings(self, settings: MeshSettings) -> Any:
        return native_settings(settings)

    def _take_paint(self, paint: dict[str, np.ndarray]) -> Any:
        return native.load().WrinkleMeshPaint(self.model, paint)

    def _solve(self, settings: MeshSettings, positions: np.ndarray, before: Any, same_settings: bool,
               moment: Moment) -> tuple[Any, Any]:
        if before is not None and not same_settings:
            before = before.woken()  # under other settings nothing of it may be held
        return native.load().solve_wrinkle_mesh(self.model, native_settings(settings), self._paint, positions, before,
                                                moment.world_from_object, **moment.in_time())

    def _show(self, settings: MeshSettings, positions: np.ndarray, state: Any,
              moment: Moment) -> Picture:
        return Picture.of(native.load().show_wrinkle_mesh(self.model, native_settings(settings), positions, state,
                                                          moment.world_from_object))


def native_settings(settings: MeshSettings) -> Any:
    """The native solver's settings: the fields of the same name."""
    options = native.load().WrinkleMeshSettings()
    for name in ("radius", "prestretch", "bending", "collision", "inside", "stretch_relief", "compression_limit",
                 "hem_rings", "iterations", "start_iterations", "damping", "offset_space", "nudge", "seed"):
        setattr(options, name, getattr(settings, name))
    settings.fill_reference(options)
    return options
