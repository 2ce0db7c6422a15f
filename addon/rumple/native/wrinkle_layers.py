# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Layers, several Wrinkle Meshes on top of each other: native/include/rumple/wrinkle_layers.h."""
from __future__ import annotations

import ctypes
from typing import Any, Sequence

import numpy as np

from . import c
from .arrays import FLOAT, INT, checked, fill, given, lent, lent_all
from .base_cloth import Collider, bodies
from .coarse_mesh import CoarseMesh
from .handle import Array, Handle, Number
from .library import lib
from .surface import FrameState, ShownFrame, SteppedModel, Surface, stored_array
from .wrinkle_mesh import PAINTED, WrinkleMeshReport, WrinkleMeshSettings, painted_factors


class WrinkleMeshLayers(SteppedModel):
    """The model: several Wrinkle Meshes on top of each other. Made by build_wrinkle_layers."""

    __slots__ = ("base",)
    base: Surface
    POINTER, FREE = c.WrinkleLayersPointer, "rumple_wrinkle_layers_free"
    VIEW, LOOK = c.WrinkleLayersView, "rumple_wrinkle_layers_get_view"
    SHOWN = "rumple_wrinkle_layers_shown"

    count = Number("layers", "layer_count")
    solved_vertex_count = Number("of all layers")
    finest_triangles = Array("(t, 3) int32: of the vertices of WrinkleLayersState.solved", INT,
                             "finest_triangle_count", 3)

    def local_edge(self, layer: int) -> np.ndarray:
        """(v,) float32, per solved vertex of a layer: mean rest length of its edges."""
        view = c.WrinkleMeshView()
        lib.rumple_wrinkle_layers_get_layer(self, layer, view)
        return lent(self, view.local_edge, FLOAT, (view.solved_vertex_count,))


def build_wrinkle_layers(base: Surface, levels: int, display_steps: int = 1, most_vertices: int = 4_000_000,
                         viewport_steps: int | None = None) -> WrinkleMeshLayers:
    """The base mesh and `levels` subdivisions of it. Each is a layer that is solved over the one before.
    viewport_steps: display steps of the mesh for viewports; None: display_steps."""
    plan = lib.rumple_wrinkle_layers_plan_default()
    plan.levels, plan.display_steps, plan.most_vertices = levels, display_steps, most_vertices
    plan.viewport_steps = display_steps if viewport_steps is None else viewport_steps
    model = WrinkleMeshLayers.made(lib.rumple_wrinkle_layers_build, base, plan)
    model.base = base
    return model


class WrinkleLayersPaint(Handle):
    """Painted factors, carried to every layer."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleLayersPaintPointer, "rumple_wrinkle_layers_paint_free"

    def __init__(self, model: WrinkleMeshLayers, painted: dict[str, np.ndarray], strength: Sequence[str]) -> None:
        """painted: names -> (n,) float32 of the base's vertices, 0..1: radius, prestretch, bending, inside, worn and
        the names in strength; and along, see WrinkleMeshPaint. strength: for every layer the name of the paint that
        scales its radius."""
        if len(strength) != model.count:
            raise ValueError(f"strength: expected {model.count} names, one per layer, got {len(strength)}")
        values = c.WrinkleLayersPainted()
        values.all = painted_factors(painted, (*PAINTED, *strength))
        for name in set(strength) & painted.keys():
            if len(checked(painted[name], name, FLOAT)) != model.base.vertex_count:
                raise ValueError(f"{name}: expected {model.base.vertex_count} values, got {len(painted[name])}")
        places = [given(painted[name], name, FLOAT)[0] if name in painted and name != "radius" else None
                  for name in strength]
        array = (ctypes.c_void_p * len(places))(*places)
        values.strength, values.strength_count = ctypes.addressof(array), len(places)
        self._filled(self, lib.rumple_wrinkle_layers_paint_build, model, values)


class WrinkleLayersState(FrameState):
    """The solver's state, which is kept from frame to frame."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleLayersStatePointer, "rumple_wrinkle_layers_state_free"
    VIEW, LOOK = c.WrinkleLayersStateView, "rumple_wrinkle_layers_state_get_view"

    OF_A_LAYER = {"offset": (FLOAT, 3), "solved_length": (FLOAT, 0)}

    solved = Array("(v, 3) float32: the finest layer, object space", FLOAT, "solved_count", 3)

    def offset(self, layer: int) -> np.ndarray:
        """(v, 3) float32 of a layer."""
        view = c.WrinkleMeshStateView()
        lib.rumple_wrinkle_layers_state_get_layer(self, layer, view)
        return lent(self, view.offset, FLOAT, (view.offset_count, 3))

    @property
    def arrays(self) -> dict[str, Any]:
        """The state as plain arrays. of() makes the same state from them, bit for bit. Names of a layer's arrays begin
        with its number."""
        out: dict[str, Any] = {"solved": self.solved}
        for layer in range(self.view.layer_count):
            view = c.WrinkleMeshStateView()
            lib.rumple_wrinkle_layers_state_get_layer(self, layer, view)
            out.update({f"{layer}.{name}": values for name, values in lent_all(self, view, self.OF_A_LAYER).items()})
        return out

    @classmethod
    def of(cls, model: WrinkleMeshLayers, arrays: dict[str, Any]) -> "WrinkleLayersState":
        """The state from the plain arrays of `arrays`."""
        views = (c.WrinkleMeshStateView * model.count)()
        for layer, view in enumerate(views):
            for name, (dtype, columns) in cls.OF_A_LAYER.items():
                fill(view, name, stored_array(arrays, f"{layer}.{name}"), dtype, columns)
        return cls.made(lib.rumple_wrinkle_layers_state_build, model, views, len(views),
                        *given(stored_array(arrays, "solved"), "solved", FLOAT, 3))

    def activated(self) -> "WrinkleLayersState":
        """The same offsets, but no vertex is asleep. Use it before a solve with other settings."""
        return WrinkleLayersState.made(lib.rumple_wrinkle_layers_state_activated, self)


def solve_wrinkle_layers(model: WrinkleMeshLayers, settings: Sequence[WrinkleMeshSettings],
                         paint: WrinkleLayersPaint | None, positions: np.ndarray, gap: np.ndarray | None = None,
                         collider: Collider | None = None, body_positions: np.ndarray | None = None,
                         body_hint: np.ndarray | None = None, thickness: float = 0.0, inner: float = 0.0,
                         state: WrinkleLayersState | None = None) -> tuple[WrinkleLayersState, list[Any]]:
    """Solve one frame; returns (state, [report of each layer]). settings: one for each layer, coarse first.

    positions: (n, 3) float32, deformed base or base cloth, object space. gap: (n,) float32: how far each vertex may
    move inwards, object units. collider, body_positions: bodies in this pose. body_hint: from solve_base_cloth.
    thickness: how far cloth stays off bodies, object units. inner: how far the garment's inner side is below the cloth.
    state: of the frame before, or None. Raises ValueError.
    """
    over = lib.rumple_wrinkle_layers_input_default()
    fill(over, "positions", positions, FLOAT, 3)
    fill(over, "gap", gap, FLOAT)
    over.thickness, over.inner = thickness, inner
    if collider is not None:
        if body_hint is None:
            raise ValueError("body_hint: expected an array, got None")
        over.bodies = bodies(collider, body_positions)
        fill(over, "body_hint", body_hint, INT)
    options = (c.WrinkleMeshSettings * len(settings))(*settings)
    reports = (WrinkleMeshReport * model.count)()
    out = WrinkleLayersState.made(
        lib.rumple_wrinkle_layers_solve, model, options, len(settings), paint, over, state, reports, len(reports))
    return out, list(reports)


def show_wrinkle_layers(model: WrinkleMeshLayers, animated: np.ndarray, positions: np.ndarray,
                        state: WrinkleLayersState, in_viewport: bool = False) -> ShownFrame:
    """The ShownFrame of a solved frame. animated: (n, 3) float32 of the animated base, without base cloth; the shown
    mesh is embedded in it. positions: (n, 3) float32, as in the solve. in_viewport: for model.shown_in_viewport."""
    return ShownFrame.made(lib.rumple_wrinkle_layers_show, model, *given(animated, "animated", FLOAT, 3),
                           *given(positions, "positions", FLOAT, 3), state, in_viewport)


class WrinkleTransfer(SteppedModel):
    """Shows the layers of a coarse mesh on the base mesh. Made by build_wrinkle_transfer."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleTransferPointer, "rumple_wrinkle_transfer_free"
    SHOWN = "rumple_wrinkle_transfer_shown"


def build_wrinkle_transfer(base: Surface, coarse: CoarseMesh, layers: WrinkleMeshLayers, level: int,
                           display_steps: int = 0, most_vertices: int = 4_000_000,
                           viewport_steps: int | None = None) -> WrinkleTransfer:
    """base: the base mesh. level: its subdivisions whose vertices are moved. display_steps: further subdivisions of
    the shown mesh. viewport_steps: the same for viewports; None: display_steps. Raises ValueError."""
    plan = lib.rumple_wrinkle_transfer_plan_default()
    plan.level, plan.display_steps, plan.most_vertices = level, display_steps, most_vertices
    plan.viewport_steps = display_steps if viewport_steps is None else viewport_steps
    return WrinkleTransfer.made(lib.rumple_wrinkle_transfer_build, base, coarse, layers, plan)


def show_wrinkle_transfer(transfer: WrinkleTransfer, animated: np.ndarray, state: WrinkleLayersState,
                          in_viewport: bool = False) -> ShownFrame:
    """The ShownFrame of a solved frame. animated: (n, 3) float32 of the animated base mesh, without base cloth. state:
    of the layers. in_viewport: for transfer.shown_in_viewport. Raises ValueError."""
    return ShownFrame.made(lib.rumple_wrinkle_transfer_show, transfer, *given(animated, "animated", FLOAT, 3), state,
                           in_viewport)


__all__ = ["WrinkleLayersPaint", "WrinkleLayersState", "WrinkleMeshLayers", "WrinkleTransfer",
           "build_wrinkle_layers", "build_wrinkle_transfer", "show_wrinkle_layers", "show_wrinkle_transfer",
           "solve_wrinkle_layers"]
