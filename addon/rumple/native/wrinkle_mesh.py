# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Mesh: native/include/rumple/wrinkle_mesh.h. M. Mueller and N. Chentanez, Wrinkle Meshes, SCA 2010."""
from __future__ import annotations

from typing import Any

import numpy as np

from . import c
from .arrays import BYTE, FLOAT, INT, address, checked, fill, given, lent, new
from .handle import Array, Handle, Number
from .library import lib
from .struct import Choice
from .surface import (FramePose, FrameState, ReferenceSettings, ShownFrame, SteppedModel, Surface, fill_reference,
                      fine_plan, reference_arrays, stored_array)

PAINTED = ("radius", "prestretch", "bending", "inside", "worn")
ALONG = "along"  # (n, 3): direction of the folds at rest; its length, 0..1, is the strength


class WrinkleMeshModel(SteppedModel):
    """A fine mesh attached to a base at rest. Made by build_wrinkle_mesh. v solved vertices."""

    __slots__ = ("base",)
    base: Surface
    POINTER, FREE = c.WrinkleMeshPointer, "rumple_wrinkle_mesh_free"
    VIEW, LOOK = c.WrinkleMeshView, "rumple_wrinkle_mesh_get_view"
    SHOWN, LABEL = "rumple_wrinkle_mesh_shown", "rumple_wrinkle_mesh_label_clip"

    solved_vertex_count = Number("v")
    pair_count = Number("distance and bending constraints")
    local_edge = Array("(v,) float32: mean rest length of the edges around a vertex", FLOAT, "solved_vertex_count")
    unattached_distance = Array("own mesh: (vertices,) float32, distance to the base at rest", FLOAT,
                                "unattached_count")
    welded_count = Number("w: welded vertices of the base")

    welded_of = Array("(n,) int32: the welded vertex of every vertex of the base", INT, "base_vertex_count")

    def weld_pose(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions (n, 3) float32 of the base's vertices -> (w, 3) float32 of the welded ones: positions, unit normals
        (or zero), and where the surface that the fine mesh is attached to passes them. Raises ValueError."""
        place, count = given(positions, "positions", FLOAT, 3)
        welded, normals, smooth = (new(FLOAT, self.welded_count, 3) for _ in range(3))
        lib.rumple_wrinkle_mesh_weld_pose(self, place, count, address(welded), address(normals), address(smooth),
                                          self.welded_count)
        return welded, normals, smooth


def build_wrinkle_mesh(base: Surface, source: str = "SUBDIVISION", level: int = 2, segments: int = 4,
                       longest_edge: float = 0.01, most_vertices: int = 4_000_000, own: Surface | None = None,
                       attached: np.ndarray | None = None, farthest: float = 0.0, attachment: str = "LIMIT",
                       display_steps: int = 1, adaptive: bool = False,
                       viewport_steps: int | None = None) -> WrinkleMeshModel:
    """Make the fine mesh and its constraints (Mueller and Chentanez 2010, section 3).

    source: SUBDIVISION (level), REGULAR (segments), EDGE_LENGTH (longest_edge) or OBJECT (own: a Surface at rest in
    the base's space; attached: (vertices of own,) uint8; farthest: refuse a mesh farther away, 0 any). attachment:
    LINEAR, PN or LIMIT. display_steps: unsolved subdivisions of the shown mesh. adaptive: needed for settings whose
    reference is not STATIC_REST. viewport_steps: of the mesh for viewports; None: display_steps. Raises ValueError.
    """
    plan = lib.rumple_wrinkle_mesh_plan_default()
    fine_plan(plan.fine, source, level, segments, longest_edge, most_vertices, attachment, tuple(c.FINE_SOURCE))
    if own is not None and source == "OBJECT":
        plan.own = own._as_parameter_
    fill(plan, "attached", attached, BYTE)
    if own is not None and attached is not None and len(attached) != own.vertex_count:
        raise ValueError(f"attached: expected {own.vertex_count} values, got {len(attached)}")
    plan.farthest, plan.display_steps, plan.adaptive = farthest, display_steps, adaptive
    plan.viewport_steps = display_steps if viewport_steps is None else viewport_steps
    model = WrinkleMeshModel.made(lib.rumple_wrinkle_mesh_build, base, plan)
    model.base = base
    return model


class WrinkleMeshSettings(c.WrinkleMeshSettings, ReferenceSettings):
    """Settings of a solve; see docs/wrinkle_mesh.md. Lengths are relative to the fine edges."""

    __slots__ = ()
    collision: Any = Choice(c.COLLISION)
    offset_space: Any = Choice(c.OFFSET_SPACE)

    def __new__(cls) -> "WrinkleMeshSettings":
        return cls.from_buffer_copy(lib.rumple_wrinkle_mesh_settings_default())


def painted_factors(painted: dict[str, np.ndarray], names: tuple[str, ...] = PAINTED) -> Any:
    """The struct of the painted factors. The arrays must live as long as the struct."""
    values = c.WrinkleMeshPainted()
    for name, array in painted.items():
        if name not in (*names, ALONG):
            raise ValueError(f"paint: expected one of {', '.join(names)}, got {name}")
        if name in PAINTED:
            fill(values, name, checked(array, name, FLOAT), FLOAT)
        elif name == ALONG:
            fill(values, name, array, FLOAT, 3)
    return values


class WrinkleMeshPaint(Handle):
    """Painted factors, carried to the solved vertices."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleMeshPaintPointer, "rumple_wrinkle_mesh_paint_free"

    def __init__(self, model: WrinkleMeshModel, painted: dict[str, np.ndarray] | None = None) -> None:
        """painted: any of radius, prestretch, bending, inside, worn -> (n,) float32 of the base's vertices, 0..1; along
        -> (n, 3), the direction of the folds at rest, with a length of 0..1."""
        self._filled(self, lib.rumple_wrinkle_mesh_paint_build, model, painted_factors(painted or {}))


class WrinkleMeshPose(FramePose):
    """The pose of a model in one frame. Made by WrinkleMeshPose.of(model, positions, ...)."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleMeshPosePointer, "rumple_wrinkle_mesh_pose_free"
    BUILD = "rumple_wrinkle_mesh_pose_build"


class WrinkleMeshState(FrameState):
    """The solver's state, which is kept from frame to frame."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleMeshStatePointer, "rumple_wrinkle_mesh_state_free"
    VIEW, LOOK = c.WrinkleMeshStateView, "rumple_wrinkle_mesh_state_get_view"

    offset = Array("(v, 3) float32", FLOAT, "offset_count", 3)
    solved_length = Array("(pairs,) float32, when it was last solved", FLOAT, "solved_length_count")

    def __init__(self, model: WrinkleMeshModel, offset: np.ndarray, solved_length: np.ndarray,
                 reference: dict[str, Any] | None = None) -> None:
        """From the values of the properties with these names."""
        arrays = c.WrinkleMeshStateView()
        fill(arrays, "offset", offset, FLOAT, 3)
        fill(arrays, "solved_length", solved_length, FLOAT)
        if reference is not None:
            fill_reference(arrays.reference, reference)
        self._filled(self, lib.rumple_wrinkle_mesh_state_build, model, arrays)

    @property
    def reference(self) -> dict[str, Any] | None:
        """The adaptive rest shape as plain arrays, or None."""
        return reference_arrays(self, self.view.reference)

    @property
    def arrays(self) -> dict[str, Any]:
        """The state as plain arrays. of() makes the same state from them, bit for bit."""
        return {"offset": self.offset, "solved_length": self.solved_length, **(self.reference or {})}

    @classmethod
    def of(cls, model: WrinkleMeshModel, arrays: dict[str, Any]) -> "WrinkleMeshState":
        """The state from the plain arrays of `arrays`."""
        return cls(model, stored_array(arrays, "offset"), stored_array(arrays, "solved_length"),
                   arrays if "time" in arrays else None)

    def activated(self) -> "WrinkleMeshState":
        """The same offsets, but no vertex is asleep. Use it before a solve with other settings."""
        return WrinkleMeshState.made(lib.rumple_wrinkle_mesh_state_activated, self)


class WrinkleMeshPasses(Handle):
    """The constraints of a solve as passes, for a solver on the graphics card: v vertices in the order of `vertex`, p
    pairs. Lengths: object units."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleMeshPassesPointer, "rumple_wrinkle_mesh_passes_free"
    VIEW, LOOK = c.WrinkleMeshPassesView, "rumple_wrinkle_mesh_passes_get_view"

    vertex_count = Number("v")
    distance_count = Number("the first pairs keep distances, the others resist bending")
    pass_count = Number("passes of an iteration")
    curved = Number("whether vertices are attached to PN triangles")
    triangles = Array("(t, 3) int32: welded vertices of the base's triangles", INT, "triangle_count", 3)
    vertex = Array("(v,) int32: the solved vertex", INT, "vertex_count")
    base_vertices = Array("(v, 3) int32: welded vertices of the triangle that it is attached to", INT, "vertex_count",
                          3)
    weights = Array("(v, 2) float32: of the second and the third of them", FLOAT, "vertex_count", 2)
    limit_vertex = Array("(m,) int32: welded vertices; empty without limit surface", INT, "limit_count")
    limit_weight = Array("(m,) float32", FLOAT, "limit_count")
    radius = Array("(v,) float32: attachment radius", FLOAT, "vertex_count")
    depth = Array("(v,) float32: how far below its attachment it may be", FLOAT, "vertex_count")
    push = Array("(v,) float32: largest random push of an unbuckled vertex", FLOAT, "vertex_count")
    noise = Array("(v,) float32, -1..1: share and direction of this push", FLOAT, "vertex_count")
    pairs = Array("(p, 2) int32: vertices, in the order of `vertex`", INT, "pair_count", 2)
    of_pass = Array("(p,) int32: its pass", INT, "pair_count")
    rest = Array("(p,) float32: length at rest", FLOAT, "pair_count")
    stretched = Array("(p,) float32: s times it", FLOAT, "pair_count")
    stiffness = Array("(p,) float32, 0..1; of distances 1", FLOAT, "pair_count")

    def __init__(self, model: WrinkleMeshModel, settings: WrinkleMeshSettings, paint: WrinkleMeshPaint | None) -> None:
        """Raises ValueError for a model with an own mesh, collision with the neighbourhood, and painted directions.
        Cost: O(v + p)."""
        self._filled(self, lib.rumple_wrinkle_mesh_passes_build, model, settings, paint)

    @property
    def limit_start(self) -> np.ndarray:
        """(v + 1,) int32: the first entry of every vertex, then m; zeros without limit surface."""
        rows = self.vertex_count if len(self.limit_vertex) else 0
        start = lent(self, self.view.limit_start, INT, (rows + 1,))
        return start if rows else np.zeros(self.vertex_count + 1, INT)


class WrinkleMeshReport(c.WrinkleMeshReport):
    """The report on a solve."""

    __slots__ = ()


class WrinkleMeshMeasures(c.WrinkleMeshMeasures):
    """Measures of the quality of a frame."""

    __slots__ = ("offsets",)
    offsets: np.ndarray  # (v, 3) float32, in the triangle frame


def solve_wrinkle_mesh(model: WrinkleMeshModel, settings: WrinkleMeshSettings, paint: WrinkleMeshPaint | None,
                       positions: np.ndarray | WrinkleMeshPose, state: WrinkleMeshState | None = None,
                       world_from_object: np.ndarray | None = None, time: float = 0.0, labels: np.ndarray | None = None,
                       next_positions: np.ndarray | None = None,
                       next_time: float = 0.0) -> tuple[WrinkleMeshState, WrinkleMeshReport]:
    """Solve one frame; returns (state, report). positions: (n, 3) float32, deformed base, object space; or a pose,
    which then replaces the arguments about the frame.

    state: of the frame before, or None for the canonical start. world_from_object: (3, 3) float32, used if offsets are
    kept in world space. The other arguments are for adaptive rest shapes. time: seconds. labels: (t,) uint8 from
    label_clip. next_positions, next_time: the next frame, which labelling looks ahead to. Raises ValueError. Section 4.
    """
    report = WrinkleMeshReport()
    return WrinkleMeshState.made(
        lib.rumple_wrinkle_mesh_solve, model, settings, paint, WrinkleMeshPose.of(
            model, positions, time, labels, next_positions, next_time, world_from_object), state, report), report


def _in_world(model: WrinkleMeshModel, positions: np.ndarray | WrinkleMeshPose,
              world_from_object: np.ndarray | None) -> WrinkleMeshPose:
    return WrinkleMeshPose.of(model, positions, world_from_object=world_from_object)


def show_wrinkle_mesh(model: WrinkleMeshModel, settings: WrinkleMeshSettings,
                      positions: np.ndarray | WrinkleMeshPose, state: WrinkleMeshState,
                      world_from_object: np.ndarray | None = None, in_viewport: bool = False) -> ShownFrame:
    """The shown mesh for a frame and its state. positions: see solve_wrinkle_mesh(). in_viewport: for
    model.shown_in_viewport."""
    return ShownFrame.made(lib.rumple_wrinkle_mesh_show, model, settings,
                           _in_world(model, positions, world_from_object), state, in_viewport)


def measure_wrinkle_mesh(model: WrinkleMeshModel, settings: WrinkleMeshSettings, paint: WrinkleMeshPaint | None,
                         positions: np.ndarray | WrinkleMeshPose, state: WrinkleMeshState,
                         world_from_object: np.ndarray | None = None) -> WrinkleMeshMeasures:
    """Edge-length errors, areas and attachment violation of a frame."""
    measures = WrinkleMeshMeasures()
    measures.offsets = new(FLOAT, model.solved_vertex_count, 3)
    lib.rumple_wrinkle_mesh_measure(model, settings, paint, _in_world(model, positions, world_from_object),
                                    state, measures, address(measures.offsets), len(measures.offsets))
    return measures


__all__ = ["WrinkleMeshMeasures", "WrinkleMeshModel", "WrinkleMeshPaint", "WrinkleMeshPasses", "WrinkleMeshPose",
           "WrinkleMeshReport", "WrinkleMeshSettings", "WrinkleMeshState", "build_wrinkle_mesh",
           "measure_wrinkle_mesh", "show_wrinkle_mesh", "solve_wrinkle_mesh"]
