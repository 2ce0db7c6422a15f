# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepare and evaluate: from arrays of a base mesh to the wrinkled mesh of a frame. Never imports bpy."""
from __future__ import annotations

import hashlib
import math
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import native
from .history import Entry, History
from .settings import MeshSettings

MOST_VERTICES = 4_000_000
MOST_LEVEL = 5
MOST_PLAYABLE = 60_000  # solved vertices that still play live on a few cores
EDGES_PER_WAVELENGTH = 5.0  # measured on garments with bend stiffness of 0.7 and more
FARTHEST_OWN = 0.25  # an own mesh farther from the base than this share of the base's diagonal is refused


class Refused(ValueError):
    """Bad input, in a sentence for the artist that names the object and the first bad element."""


@dataclass
class BaseMesh:
    """A polygon mesh at rest, object space. float32 and int32, C-contiguous."""

    name: str
    positions: np.ndarray  # (n, 3) float32
    polygon_start: np.ndarray  # (p + 1,) int32
    corner_vertex: np.ndarray  # (c,) int32
    triangle_corner: np.ndarray  # (t, 3) int32, corner indices

    def surface(self, weld: bool) -> Any:
        """The checked native surface. Raises Refused."""
        try:
            return native.load().build_surface(self.positions, self.polygon_start, self.corner_vertex,
                                                 self.triangle_corner, weld)
        except ValueError as error:
            raise Refused(f"{self.name}: {error}") from error

    def mean_edge(self) -> float:
        """Mean length of the polygons' sides, object units."""
        following = np.arange(1, len(self.corner_vertex) + 1)
        following[self.polygon_start[1:] - 1] = self.polygon_start[:-1]
        sides = self.positions[self.corner_vertex[following]] - self.positions[self.corner_vertex]
        return float(np.linalg.norm(sides, axis=1).mean()) if len(sides) else 0.0

    def diagonal(self) -> float:
        """Of the bounding box, object units."""
        return float(np.linalg.norm(np.ptp(self.positions, axis=0))) if len(self.positions) else 0.0


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


@dataclass
class Picture:
    """The shown mesh of one frame. d vertices; object space, object units."""

    local_offset: np.ndarray  # (d, 3) from the linear embedding, in the frame of the deformed base triangle
    positions: np.ndarray  # (d, 3)
    offset: np.ndarray  # (d, 3) from the attachment point
    stretch_min: np.ndarray  # (d,)
    stretch_max: np.ndarray  # (d,)
    stretch_direction: np.ndarray  # (d, 3)
    report: Any
    milliseconds: dict[str, float] = field(default_factory=dict)  # by stage: solve, show
    replayed: bool = False


class WrinkleMesh:
    """A fine mesh bound to a base, and the frames that were solved for it."""

    def __init__(self, base: BaseMesh, model: Any, warnings: list[str], edge_mean: float, level: int) -> None:
        self.name = base.name
        self.base = base
        self.model = model
        self.warnings = warnings
        self.edge_mean = edge_mean
        self.level = level
        self.history = History()
        self._painted = self._chosen = b""  # digests of the paint and the settings of the last solve ...
        self._frame = math.nan  # ... and its frame
        self._source_vertices = 0
        self._source_corners = 0
        self._paint: Any = None

    @classmethod
    def build(cls, base: BaseMesh, settings: MeshSettings, *, unit_scale: float = 1.0, own: BaseMesh | None = None,
              attached: np.ndarray | None = None) -> "WrinkleMesh":
        """Make the fine mesh and bind it.

        unit_scale: metres per object unit. own: the artist's mesh at rest, in the base's object space.
        attached: (n,) bool per vertex of own. Raises Refused.
        """
        if not math.isfinite(unit_scale) or unit_scale <= 0.0:
            raise Refused(f"{base.name}: its scale is zero, so lengths in metres have no meaning")
        if settings.source == "OBJECT" and own is None:
            raise Refused(f"{base.name}: choose your own fine mesh first")
        surface = base.surface(settings.weld)
        own_surface = own.surface(False) if own is not None and settings.source == "OBJECT" else None
        level = settings.level if settings.density == "LEVEL" else level_for(base, settings.wavelength, unit_scale)
        try:
            model = native.load().build_wrinkle_mesh(
                surface, source=settings.source, level=level, segments=settings.segments,
                longest_edge=settings.edge_length / unit_scale, most_vertices=MOST_VERTICES, own=own_surface,
                attached=None if attached is None else np.ascontiguousarray(attached, np.uint8),
                farthest=FARTHEST_OWN * base.diagonal(), attachment=settings.attachment,
                display_steps=settings.display_steps)
        except ValueError as error:
            raise Refused(f"{base.name}: {error}") from error
        warnings = [f"{base.name}: {w}" for w in surface.warnings]
        if own_surface is not None:
            warnings += [f"{own.name}: {w}" for w in own_surface.warnings]
            if attached is not None and not attached.all():
                warnings.append(f"{own.name}: {int((~attached.astype(bool)).sum())} vertices are not attached")
        mesh = cls(base, model, warnings, float(model.local_edge.mean()) * unit_scale, level)
        source = own if own_surface is not None else base
        mesh._source_vertices, mesh._source_corners = len(source.positions), len(source.corner_vertex)
        return mesh

    # --- the shown mesh, for whoever makes the carrier
    @property
    def vertex_count(self) -> int:
        return self.model.shown.vertex_count

    @property
    def solve_vertex_count(self) -> int:
        return self.model.solved_vertex_count

    @property
    def polygon_start(self) -> np.ndarray:
        return self.model.shown.polygon_start

    @property
    def corner_vertex(self) -> np.ndarray:
        return self.model.shown.corner_vertex

    @property
    def positions_rest(self) -> np.ndarray:
        return self.model.shown.positions_rest

    @property
    def polygon_parent(self) -> np.ndarray:
        """(q,) polygon of the source (base or own mesh) of every shown polygon."""
        return self.model.shown.polygon_source

    @property
    def edges(self) -> np.ndarray:
        """(e, 2) shown edges that lie on an edge of the source."""
        return self.model.shown.edges

    @property
    def edge_parent(self) -> np.ndarray:
        """(e, 2) vertices of that edge, ascending."""
        return self.model.shown.edge_sources

    @property
    def triangle_vertex(self) -> np.ndarray:
        return self.model.shown.triangle_vertex

    @property
    def barycentric(self) -> np.ndarray:
        return self.model.shown.barycentric

    def carry_points(self, values: np.ndarray) -> np.ndarray:
        """(n, k) float32 values of the source's vertices -> (d, k)."""
        return self.model.shown.carry_points(np.ascontiguousarray(values, np.float32), self._source_vertices)

    def carry_corners(self, values: np.ndarray) -> np.ndarray:
        """(c, k) float32 values of the source's corners -> corners of the shown mesh. Seams stay sharp."""
        return self.model.shown.carry_corners(np.ascontiguousarray(values, np.float32), self._source_corners)

    # --- frames
    def solve_frame(self, frame: float, positions: np.ndarray, settings: MeshSettings,
                    paint: dict[str, np.ndarray], *, start: int, world_from_object: np.ndarray | None = None
                    ) -> Picture:
        """The picture of a frame: replayed when it is stored for the same input, else solved and stored.

        positions: (n, 3) float32, deformed base, object space. paint: factors 0..1 per base vertex.
        start: first frame of the clip; it needs no frame before it. Raises Refused.
        """
        try:
            return self._solve_frame(frame, positions, settings, paint, start, world_from_object)
        except ValueError as error:
            raise Refused(f"{self.name}: {error}") from error

    def _solve_frame(self, frame: float, positions: np.ndarray, settings: MeshSettings, paint: dict[str, np.ndarray],
                     start: int, world_from_object: np.ndarray | None) -> Picture:
        kernels = native.load()
        chosen = self._take_inputs(frame, settings, paint, start)
        options = native_settings(settings)
        world = settings.offset_space == "WORLD" and world_from_object is not None
        matrix = np.ascontiguousarray(world_from_object, np.float32) if world else None
        digest = _digest(chosen, positions, matrix)
        before = None if settings.stateless or frame <= start else self._frame_before(frame)
        final = settings.stateless or frame <= start or (before is not None and before.final)
        entry = self.history.get(frame)
        began = time.perf_counter()
        replayed = entry is not None and entry.inputs == digest and (entry.final or not final)
        if not replayed:
            state, report = kernels.solve_wrinkle_mesh(self.model, options, self._paint, positions,
                                                      _state_for(before, chosen), matrix)
            entry = Entry(state, digest, chosen, final, report)
            self.history.put(frame, entry)
        solved = time.perf_counter()
        shown = kernels.show_wrinkle_mesh(self.model, options, positions, entry.state, matrix)
        times = dict(solve=1e3 * (solved - began), show=1e3 * (time.perf_counter() - solved))
        return Picture(shown.local_offset, shown.positions, shown.offset, shown.stretch_min, shown.stretch_max,
                       shown.stretch_direction, entry.report, times, replayed)

    def measure_frame(self, frame: float, positions: np.ndarray, settings: MeshSettings) -> Any:
        """Edge errors, areas and violations of a stored frame; None when it is not stored."""
        entry = self.history.get(frame)
        if entry is None or self._paint is None:
            return None
        return native.load().measure_wrinkle_mesh(self.model, native_settings(settings), self._paint, positions,
                                                    entry.state)

    def _frame_before(self, frame: float) -> Entry | None:
        """The stored whole frame that a frame goes on from: the one before it, or the one a subframe is in."""
        return self.history.get(float(math.ceil(frame) - 1))

    def _take_inputs(self, frame: float, settings: MeshSettings, paint: dict[str, np.ndarray], start: int) -> bytes:
        """A digest of the settings. Forgets stored frames when the artist changed them, or the paint.

        Settings that differ at another frame are animated: then every frame has its own, and stays stored.
        """
        painted = hashlib.blake2b(digest_size=16)
        for key in sorted(paint):
            painted.update(key.encode())
            painted.update(np.ascontiguousarray(paint[key], np.float32))
        chosen = hashlib.blake2b(repr((settings, start)).encode(), digest_size=16).digest()
        repainted = self._paint is None or painted.digest() != self._painted
        if repainted:
            self._paint = native.load().WrinkleMeshPaint(self.model, paint)
        if repainted or (chosen != self._chosen and frame == self._frame):
            self.history.clear()
        self._painted, self._chosen, self._frame = painted.digest(), chosen, frame
        return chosen


def native_settings(settings: MeshSettings) -> Any:
    """The native solver's settings: the fields of the same name."""
    options = native.load().WrinkleMeshSettings()
    for name in ("radius", "prestretch", "bending", "collision", "inside", "stretch_relief", "compression_limit",
                 "hem_rings", "iterations", "start_iterations", "damping", "offset_space", "nudge", "seed"):
        setattr(options, name, getattr(settings, name))
    return options


def _state_for(before: Entry | None, chosen: bytes) -> Any:
    """The state to go on from. Under other settings nothing of it may be held."""
    if before is None:
        return None
    return before.state if before.chosen == chosen else before.state.woken()


def _digest(chosen: bytes, positions: np.ndarray, matrix: np.ndarray | None) -> bytes:
    digest = hashlib.blake2b(chosen, digest_size=16)
    digest.update(positions)
    if matrix is not None:
        digest.update(matrix)
    return digest.digest()
