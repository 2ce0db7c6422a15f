# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Mesh as a system of the engine, on plain arrays. Never imports bpy."""
from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np

from ...native import kernels
from ..base.last_result import LastResult
from ..base.wording import UserError, user_error
from ..cloth.base_cloth import bend_radius
from ..cloth.layers import layer_settings, layer_words, native_settings
from ..cloth.on_cloth import OnCloth
from ..frame.engine import MOST_VERTICES, Wrinkles
from ..frame.frame_input import FrameInput
from ..mesh.base_mesh import BaseMesh
from ..mesh.body import Body
from ..mesh.figure_size import size_of
from ..mesh.frame_result import FrameResult, PreviewFrame
from ..mesh.outer_side import find as find_outer_side
from ..mesh.shown_mesh import ViewportMesh
from ..paint.fold_guides import ALONG
from ..paint.hangs_free import FREE, WORN, with_wide_folds
from ..paint.paint_maps import WIDTH, fold_width
from ..parts.cloth_surface import Checked, checked_surface
from ..parts.flared import has_loose_legs, is_flared
from ..settings.cloth_settings import ClothSettings, nearest_up
from ..settings.system_settings import MeshSettings
from .coarse_mesh import coarse_mesh
from .fold_density import (EDGES_PER_WAVELENGTH, halvings, layers_for, level_for, share_of_layer,
                           suggested_wavelength)

MOST_STEPS = 2  # unsolved subdivisions
MOST_UNDER_PROXY = 100_000  # shown vertices up to which the GPU preview moves its proxy to the smooth surface
FARTHEST_OWN = 0.25  # an own mesh farther from the base than this share of the base's diagonal is refused
# Metres: the finest folds of an adult's cotton garment. Cloth that hangs free has few, wide folds.
CLOTH_WAVELENGTH, SKIRT_WAVELENGTH = 0.04, 0.14
# finest folds of a sheet like a scarf: least width; width / diagonal (at most a skirt's)
SHEET_WAVELENGTH, SHEET_FOLDS = 0.07, 0.1
# Loose legs of trousers are cut this much wider than they are modelled: so they have folds while the figure stands, and
# nearly as high ones as a simulation where it moves (docs/garments.md, Loose trousers).
LOOSE_LEGS_SLACK = 1.05
LEAST_OPENINGS = 2  # least number of openings of a garment; a head has one


def suits_cloth(base: BaseMesh) -> bool:
    """Whether a mesh has the shape of a garment: one of its parts has enough openings."""
    try:
        return kernels.count_openings(base.healed(True).surface(True)) >= LEAST_OPENINGS
    except ValueError:
        return False  # the build reports what is wrong with it


def cloth_defaults(base: BaseMesh, unit_scale: float, world_from_object: np.ndarray,
                   sheet: bool = False) -> dict[str, Any]:
    """Settings for a garment that becomes cloth. The width of folds follows from the fabric and the wearer's size.
    Lengths are in metres, with two significant digits. world_from_object: (3, 3), at rest. sheet: it is a sheet, like a
    cape."""
    scale = size_of(base, unit_scale)
    # The base cloth already holds collars and cuffs. A hem without folds would be a ring, with folds gathered above it.
    finest = SKIRT_WAVELENGTH if sheet or is_flared(base, world_from_object[2]) else CLOTH_WAVELENGTH
    if sheet:
        finest = min(max(SHEET_FOLDS * base.diagonal() * unit_scale / scale, SHEET_WAVELENGTH), finest)
    lengths = dict(wavelength=finest, room=ClothSettings.room, slide_room=ClothSettings.slide_room,
                   free_room=ClothSettings.free_room, thickness=ClothSettings.thickness)
    slack = dict(slack=LOOSE_LEGS_SLACK) if has_loose_legs(base, world_from_object[2]) else {}
    return dict(base_cloth="HANG", layers="CLOTH", hem_rings=0, up=nearest_up(world_from_object[2]), **slack,
                **{name: float(f"{length * scale:.2g}") for name, length in lengths.items()})


# For a simulated garment: folds of several sizes, and no folds from the small compression of the simulation's noise.
SIMULATED_DEFAULTS = dict(layers="CLOTH", buckling_threshold=0.01)


class WrinkleMesh(Wrinkles):
    """A fine mesh, or several layers of them, solved over the base cloth or the animated mesh."""

    suggested_length = staticmethod(suggested_wavelength)

    model: Any  # native: of one mesh, or of layers
    edge_mean: float  # of the fine mesh, metres
    level: int  # its subdivisions
    finest_share: float  # strength of the last layer, not counting finer_layers
    layer_count = 0  # 0: one mesh, as in the paper
    finer_layers = 0  # how many of the last layers are only for folds that are painted narrower
    _halvings = 0.0  # halvings of the mean edge for the wavelength in the settings
    coarse: Any = None  # native: in place of the base, where its edges do not suit, or for its outer side
    transfer: Any = None  # native: shows the layers on the base mesh, if `coarse` is set
    _finest: np.ndarray | None = None

    @classmethod
    def build(cls, base: BaseMesh, settings: MeshSettings, *, unit_scale: float = 1.0, own: BaseMesh | None = None,
              attached: np.ndarray | None = None, most_vertices: int = MOST_VERTICES,
              viewport_steps: int = MOST_STEPS) -> "WrinkleMesh":
        """Make the fine mesh and bind it: see Wrinkles.build().

        own: the artist's mesh at rest, in the base's object space.
        attached: (n,) bool per vertex of own. viewport_steps: of the mesh `in_viewport`, which is only made if they are
        fewer than the display steps. Raises UserError.
        """
        if settings.source == "OBJECT" and own is None:
            raise UserError(f"{base.name}: choose your own fine mesh first")
        rigid_parts = settings.rigid_parts and settings.source != "OBJECT"
        # with an own mesh, patches are painted on that mesh
        base = replace(base, painted_rigid=None) if settings.source == "OBJECT" else base
        checked = checked_surface(base, settings.weld, rigid_parts, unit_scale)
        if settings.layered:
            return cls._build_layers(checked, settings, unit_scale, most_vertices, viewport_steps)
        base, surface, warnings = checked
        own = own.healed(False) if own is not None and settings.source == "OBJECT" else None
        own_surface = own.surface(False) if own is not None else None
        attached = attached if attached is None or own is None else own.points(attached)
        level = settings.level
        if settings.density == "WAVELENGTH" and settings.source == "SUBDIVISION":
            level, notes = base.level_within(level_for(base, settings.wavelength, unit_scale), settings.display_steps,
                                             most_vertices)
            warnings += notes
        try:
            model = kernels.build_wrinkle_mesh(
                surface, source=settings.source, level=level, segments=settings.segments,
                longest_edge=settings.edge_length / unit_scale, most_vertices=most_vertices, own=own_surface,
                attached=None if attached is None else np.ascontiguousarray(attached, np.uint8),
                farthest=FARTHEST_OWN * base.diagonal(), attachment=settings.attachment,
                display_steps=settings.display_steps, adaptive=settings.rest_shape == "ADAPTIVE",
                viewport_steps=viewport_steps)
        except ValueError as error:
            raise user_error(base.name, error) from error
        if own is not None and own_surface is not None:
            warnings += [] if own.origin is None else own.origin.notes(own.name)
            warnings += [f"{own.name}: {w}" for w in own_surface.warnings]
            if attached is not None and not attached.all():
                warnings.append(f"{own.name}: {int((~attached.astype(bool)).sum())} vertices are not attached")
        mesh = cls(base, base if own is None else own, surface, model, warnings, unit_scale)
        mesh.edge_mean, mesh.level = float(model.local_edge.mean()) * unit_scale, level
        mesh._take_viewport_mesh(model)
        return mesh

    @classmethod
    def _build_layers(cls, checked: Checked, settings: MeshSettings, unit_scale: float, most_vertices: int,
                      viewport_steps: int) -> "WrinkleMesh":
        """Build layers on the base, or on a coarse mesh in its place."""
        base, surface, warnings = checked
        outer = find_outer_side(base, surface, settings.weld)
        coarse = coarse_mesh(base, settings, surface, unit_scale, outer)
        edge = (base.mean_edge() if coarse is None else coarse.mean_edge) * unit_scale
        count = halvings(edge, settings.wavelength)
        if coarse is not None and coarse.spacing:
            count = float(round(count))  # its edges were made for this wavelength
        level, share, whole = settings.level, 1.0, settings.level
        if settings.density == "WAVELENGTH":
            whole, share = layers_for(count)
            asked, _ = layers_for(count - math.log2(base.narrowest))
            corners = None if coarse is None else 3 * coarse.surface.triangle_count
            level, notes = base.level_within(asked, settings.display_steps if coarse is None else 0, most_vertices,
                                             corners)
            warnings += notes
            share = share if level >= whole else 1.0
        try:
            model = kernels.build_wrinkle_layers(surface if coarse is None else coarse.surface, level,
                                                 settings.display_steps if coarse is None else 0, most_vertices,
                                                 viewport_steps)
            mesh = cls(base, base, surface, model, warnings, unit_scale)
            if coarse is not None:
                mesh.outer = outer
                mesh._show_on_base(coarse, settings, most_vertices, viewport_steps)
        except ValueError as error:
            raise user_error(base.name, error) from error
        mesh.layer_count, mesh.level, mesh.finest_share = level + 1, level, share
        mesh.finer_layers, mesh._halvings = max(level - whole, 0), count
        mesh.edge_mean = float(model.local_edge(level).mean()) * unit_scale
        mesh._take_viewport_mesh(model if coarse is None else mesh.transfer)
        return mesh

    def _take_viewport_mesh(self, model: Any) -> None:
        """Use a mesh for viewports if it has fewer vertices. It needs at least as many as the coarse mesh, because it
        also carries the coarse positions."""
        mesh = ViewportMesh(self.base, self.source, model.shown_in_viewport, self.ATTRIBUTES)
        if self.coarse_count <= mesh.vertex_count < self.vertex_count:
            self.in_viewport = mesh

    def _show_on_base(self, coarse: Any, settings: MeshSettings, most_vertices: int, viewport_steps: int) -> None:
        """Show the layers of the coarse mesh on the base, which is subdivided as far as its folds need."""
        steps = settings.level
        if settings.density == "WAVELENGTH":
            edge = (self.base if self.outer is None else self.outer.mesh).mean_edge_by_area() * self.unit_scale
            steps = round(halvings(edge, settings.wavelength * self.base.narrowest))
        steps += settings.display_steps
        steps, notes = self.base.level_within(max(steps, 0), 0, most_vertices)
        self.warnings += [note for note in notes if note not in self.warnings]
        level = max(steps - settings.display_steps, 0)
        self.coarse, self.solved_surface = coarse, coarse.surface
        build = functools.partial(kernels.build_wrinkle_transfer, self.surface, coarse, self.model, level,
                                  most_vertices=most_vertices, viewport_steps=viewport_steps)
        for steps in (max(steps - level, 0), 1):
            self.transfer = build(steps)
            self.shown = self.transfer.shown
            if self.vertex_count >= len(self.base.positions):
                break  # the shown mesh lacks loose vertices, but must have at least as many vertices as the base

    def _where_solved(self, values: np.ndarray) -> np.ndarray:
        if self.coarse is None:
            return values
        if values.ndim > 1:  # directions, of which v and -v mean the same
            return np.ascontiguousarray(values[self.coarse.base_vertex])
        return self.coarse.paint(np.ascontiguousarray(values, np.float32))

    def _positions_solved(self, positions: np.ndarray) -> np.ndarray:
        return positions if self.coarse is None else self.coarse.positions(positions)

    @property
    def solve_vertex_count(self) -> int:
        return self.model.solved_vertex_count

    def _status(self, report: Any) -> list[str]:
        lines = [f"{self.solve_vertex_count} vertices are solved", f"Fine edge {1000.0 * self.edge_mean:.2f} mm"]
        layers = report if isinstance(report, list) else [report]
        kept = sum(layer.kept_apart for layer in layers)
        if kept:
            lines.append(f"{kept} {'vertex' if kept == 1 else 'vertices'} kept from crossing the garment or a body in "
                         "front of it")
        report = layers[-1]
        before, after = 100.0 * report.error_before, 100.0 * report.error_after
        lines.append(f"Edge length error {before:.1f} % before, {after:.1f} % after {report.iterations} iterations")
        if report.collapsed_triangles:
            lines.append(f"{report.collapsed_triangles} coarse triangles have no area in this pose")
        return lines

    def measure_frame(self, frame: float, positions: np.ndarray, settings: MeshSettings) -> Any:
        """Edge errors, areas and violations of a stored frame. None if it is not stored, or with a base cloth or
        layers."""
        cached = self.frame_cache.get(frame)
        if cached is None or self._paint is None or isinstance(cached.state, OnCloth) or self.layer_count:
            return None
        return kernels.measure_wrinkle_mesh(self.model, native_settings(settings), self._paint,
                                            self.base.points(positions), cached.state)

    def _worn_cloth(self, frame: float, positions: np.ndarray, settings: Any) -> Body | None:
        state = self.wrinkles_of(frame) if self.layer_count else None
        if state is None:
            return super()._worn_cloth(frame, positions, settings)
        if self._finest is None:
            self._finest = self.model.finest_triangles
        return Body(state.solved, self._finest)

    def _crests(self, settings: MeshSettings, positions: np.ndarray, pose: Any, state: Any) -> np.ndarray | None:
        if self.layer_count:
            return None  # _worn_cloth() has the folds themselves
        shown = kernels.show_wrinkle_mesh(self.model, native_settings(settings), pose, state)
        normals = self.model.weld_pose(positions)[1][self.model.welded_of]
        heights, around = np.zeros(len(positions), np.float32), self.model.shown.triangle_vertex
        for corner in around.T:
            x, y, z = (shown.offset * normals[corner]).T
            np.maximum.at(heights, corner, x + y + z)
        return heights[:, None] * normals

    def _keeps_off_bodies(self) -> bool:
        return self.layer_count > 0

    def _reads_world(self, settings: MeshSettings) -> bool:
        return settings.offset_space == "WORLD"

    def _native_settings(self, settings: MeshSettings) -> Any:
        return native_settings(settings)

    # --- for the GPU preview (../blender/viewport/preview_mesh.py)
    def passes(self, settings: MeshSettings) -> tuple[Any, Any]:
        """(constraints, settings), native, with the paint of the last solve."""
        options = native_settings(settings)
        return kernels.WrinkleMeshPasses(self.model, options, self._paint), options

    def is_previewed(self, settings: Any, has_body: bool) -> bool:
        return (self.previewed and settings.source != "OBJECT" and settings.base_cloth == "OFF" and not has_body
                and (settings.rest_shape != "ADAPTIVE" or settings.stateless) and settings.offset_space == "TRIANGLE"
                and settings.collision != "NEIGHBOURHOOD" and not self._by_hand)

    def _may_wait(self, settings: MeshSettings, frame_input: FrameInput) -> bool:
        if settings.stateless or not self.is_previewed(settings, frame_input.body is not None):
            return False
        self.model.weld_pose(frame_input.animated)  # raises the errors of a later solve already now
        return True

    def _proxy_offset(self, positions: np.ndarray) -> np.ndarray:
        """From the coarse vertices to the surface that the fine mesh is attached to. Nothing for a very fine mesh: to
        write the offsets lets Blender look at all its vertices."""
        if self.vertex_count > MOST_UNDER_PROXY:
            return np.zeros((0, 3), np.float32)
        smooth = self.model.weld_pose(positions)[2]
        return (smooth[self.model.welded_of] - positions)[:self.coarse_count]

    def _preview(self, settings: MeshSettings, positions: np.ndarray, pose: Any, state: Any,
                 frame_input: FrameInput) -> FrameResult | PreviewFrame:
        if self.is_previewed(settings, frame_input.body is not None):
            return PreviewFrame(proxy_offset=self._proxy_offset(positions))
        return self._show(settings, positions, pose, state, frame_input)

    def _take_paint(self, paint: dict[str, np.ndarray]) -> Any:
        self.previewed = not self.layer_count and self.base.rigid is None and ALONG not in paint
        words = layer_words(self.layer_count, self.finer_layers) if self.layer_count else []
        paint = with_wide_folds(paint, self._cloth_paint.get(FREE), words)
        factors = {name: values for name, values in paint.items()
                   if name in ("radius", "prestretch", "bending", "inside", WORN, ALONG, *words)}
        for number in range(self.layer_count - self.finer_layers, self.layer_count):
            words[number] = f"finer {number}"
            factors[words[number]] = self._narrower(number, paint)
        if self.layer_count:
            return kernels.WrinkleLayersPaint(self.model, factors, words)
        return kernels.WrinkleMeshPaint(self.model, factors)

    def _narrower(self, layer: int, paint: dict[str, np.ndarray]) -> np.ndarray:
        """(n,) strength of a layer for folds that are painted narrower, at the solved vertices."""
        if WIDTH not in paint:
            return np.zeros(self.solved_surface.vertex_count, np.float32)
        asked = self._halvings - np.log2(fold_width(paint[WIDTH]))
        share = np.clip(share_of_layer(asked, layer), 0.0, 1.0).astype(np.float32)
        return share * paint["detail"] if "detail" in paint else share

    def _pose(self, positions: np.ndarray, frame_input: FrameInput) -> Any:
        if self.layer_count:
            return positions  # every layer makes its own pose from the layer before
        return kernels.WrinkleMeshPose.of(self.model, positions, frame_input.seconds, frame_input.labels,
                                          world_from_object=frame_input.world_from_object)

    def _solve(self, settings: MeshSettings, pose: Any, before: Any, same_settings: bool,
               frame_input: FrameInput) -> tuple[Any, Any]:
        if before is not None and not same_settings:
            before = before.activated()  # with other settings no vertex may stay asleep
        if not self.layer_count:
            return kernels.solve_wrinkle_mesh(self.model, native_settings(settings), self._paint, pose, before)
        by_wavelength = settings.density == "WAVELENGTH"
        wavelength = settings.wavelength if by_wavelength else EDGES_PER_WAVELENGTH * self.edge_mean
        layers = self._layer_settings(settings, self.layer_count, self.finest_share, frame_input.world_from_object,
                                      bend_radius(settings, wavelength, self.unit_scale), self.finer_layers)
        return kernels.solve_wrinkle_layers(self.model, layers, self._paint, pose, state=before,
                                            **self._contact(settings, frame_input))

    @functools.cached_property
    def _layer_settings(self) -> LastResult[list[Any]]:
        return LastResult(layer_settings)

    def _contact(self, settings: MeshSettings, frame_input: FrameInput) -> dict[str, Any]:
        """The collision arguments that keep layers off bodies under the base cloth."""
        cloth = frame_input.cloth
        return {} if cloth is None else self.draped_cloth().contact(cloth, settings, frame_input.body)

    def _show(self, settings: MeshSettings, positions: np.ndarray, pose: Any, state: Any,
              frame_input: FrameInput) -> FrameResult:
        if self.coarse is not None:
            return FrameResult.of(kernels.show_wrinkle_transfer(self.transfer, frame_input.animated, state,
                                                                frame_input.in_viewport))
        if self.layer_count:
            return FrameResult.of(kernels.show_wrinkle_layers(self.model, frame_input.animated, positions, state,
                                                              frame_input.in_viewport))
        shown = kernels.show_wrinkle_mesh(self.model, native_settings(settings), pose, state,
                                          in_viewport=frame_input.in_viewport)
        return self._result(shown, frame_input)
