# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Paths as curves, and their data for the GPU preview: native/include/rumple/wrinkle_paths.h."""
from __future__ import annotations

from typing import Any

import numpy as np

from . import c
from .arrays import FLOAT, INT, address, given, new, optional
from .handle import Array, Handle
from .library import lib
from .wrinkle_paths import WrinklePathsModel, WrinklePathsPose, WrinklePathsSettings, WrinklePathsState

Positions = np.ndarray | WrinklePathsPose  # (n, 3) float32, deformed base, object space; or its pose


class WrinklePathsCurves(Handle):
    """The paths as curves in object space."""

    __slots__ = ()
    POINTER, FREE = c.CurvesPointer, "rumple_curves_free"
    VIEW, LOOK = c.CurvesView, "rumple_curves_get_view"

    start = Array("(c + 1,) int32: the first point of every curve, then p", INT, "curve_count", more=1)
    id = Array("(c,) int32", INT, "curve_count")
    positions = Array("(p, 3) float32, object space", FLOAT, "point_count", 3)
    width = Array("(p,) float32, object units", FLOAT, "point_count")
    height = Array("(p,) float32, signed, object units", FLOAT, "point_count")


class WrinklePathsRidingCurves(WrinklePathsCurves):
    """The paths on the crests of their folds, relative to the posed base."""

    __slots__ = ()
    corners = Array("(p, 3) int32: the base's vertices as the artist has them, around every point", INT,
                    "riding_count", 3)
    weights = Array("(p, 2) float32: of the second and the third of them", FLOAT, "riding_count", 2)
    local_offset = Array("(p, 3) float32, in the frame of the deformed triangle, object units", FLOAT,
                         "riding_count", 3)


class WrinklePathsLists(Handle):
    """For every triangle the folds that reach it: the three buffers of section 7.2."""

    __slots__ = ()
    POINTER, FREE = c.DrawingPointer, "rumple_drawing_free"
    VIEW, LOOK = c.DrawingView, "rumple_drawing_get_view"

    triangle_start = Array("(t + 1,) int32: where the ranges of every triangle begin", INT, "triangle_count", more=1)
    ranges = Array("(r, 2) int32: first piece and end of the pieces that reach the triangle", INT, "range_count", 2)
    ends = Array("(e, 8) float32: piece i runs from end i to end i + 1; at, width, along, height. For fold_height of "
                 "shaders/shared/wrinkle_paths.glsl", FLOAT, "end_count", 8)


class WrinklePathsDrawing(WrinklePathsLists):
    """The data from which the GPU preview draws a frame."""

    __slots__ = ()
    flat = Array("(w, 3) float32: welded vertices of the deformed base; heights are measured over them", FLOAT,
                 "vertex_count", 3)
    smooth = Array("(w, 3) float32: their places on the surface that the fine mesh is attached to", FLOAT,
                   "vertex_count", 3)
    normal = Array("(w, 3) float32, unit", FLOAT, "vertex_count", 3)
    hem = Array("(w,) float32: factor on the folds", FLOAT, "vertex_count")
    parts = Array("(t, 4) int32: parts that a triangle and its edges (from corners 0, 1, 2) are cut into", INT,
                  "part_count", 4)
    proxy_offset = Array("(n, 3) float32: from every vertex of the base to `smooth`", FLOAT, "base_vertex_count", 3)

    @property
    def curved(self) -> bool:
        """False: straight triangles, for a linear attachment."""
        return self.view.curved

    @property
    def lists(self) -> "WrinklePathsDrawing":
        """The WrinklePathsLists: this drawing has them itself."""
        return self


def wrinkle_path_lists(model: WrinklePathsModel, settings: WrinklePathsSettings, positions: Positions,
                       state: WrinklePathsState) -> WrinklePathsLists:
    """For every triangle the pieces of folds that reach it."""
    return WrinklePathsLists.made(lib.rumple_wrinkle_paths_list, model, settings,
                                  WrinklePathsPose.of(model, positions), state)


def wrinkle_path_curves(model: WrinklePathsModel, settings: WrinklePathsSettings, positions: Positions,
                        state: WrinklePathsState) -> WrinklePathsCurves:
    """The smoothed paths as lines in object space, with width and height at every point."""
    return WrinklePathsCurves.made(lib.rumple_wrinkle_paths_trace, model, settings,
                                   WrinklePathsPose.of(model, positions), state)


def ride_wrinkle_paths(model: WrinklePathsModel, settings: WrinklePathsSettings, positions: Positions,
                       state: WrinklePathsState, animated: np.ndarray | None = None) -> WrinklePathsRidingCurves:
    """The paths as curves along the crests, bound to the base, so that they can follow any pose. positions: (n, 3)
    float32, deformed base, object space. animated: the base that they are bound to, if it is not the one that was
    solved over."""
    return WrinklePathsRidingCurves.made(lib.rumple_wrinkle_paths_ride, model, settings,
                                         WrinklePathsPose.of(model, positions),
                                         *optional(animated, "animated", FLOAT, 3), state)


def wrinkle_path_stretches(model: WrinklePathsModel, positions: Positions, state: WrinklePathsState) -> np.ndarray:
    """(t, 2) float32: compression (1 / lambda_min) and stretch of every triangle relative to its reference triangle."""
    out = new(FLOAT, model.triangle_count, 2)
    lib.rumple_wrinkle_paths_stretches(model, WrinklePathsPose.of(model, positions), state, address(out), len(out))
    return out


def wrinkle_path_ellipses(model: WrinklePathsModel, positions: Positions, state: WrinklePathsState,
                          size: float = 0.8) -> np.ndarray:
    """(t, 9) float32: for every triangle the ellipse that a circle on its reference triangle becomes: centre,
    compressed semi-axis, stretched semi-axis. size: radius of the circle / radius of the inscribed circle. Object
    space."""
    out = new(FLOAT, model.triangle_count, 9)
    lib.rumple_wrinkle_paths_ellipses(model, WrinklePathsPose.of(model, positions), state, size, address(out), len(out))
    return out


def draw_wrinkle_paths(model: WrinklePathsModel, settings: WrinklePathsSettings, positions: Positions,
                       state: WrinklePathsState) -> WrinklePathsDrawing:
    """The data from which the viewport draws a frame."""
    return WrinklePathsDrawing.made(lib.rumple_wrinkle_paths_draw, model, settings,
                                    WrinklePathsPose.of(model, positions), state)


def drawn_wrinkle_paths(model: Any, settings: WrinklePathsSettings, drawing: WrinklePathsDrawing, triangle: np.ndarray,
                        weights: np.ndarray) -> np.ndarray:
    """For tests: (n, 7) float32: position, height and normal as the shaders compute them. triangle: (n,) int32.
    weights: (n, 2) float32, of corners 1 and 2."""
    del model  # of the drawing
    which, count = given(triangle, "triangle", INT)
    where, places = given(weights, "weights", FLOAT, 2)
    if places != count:
        raise ValueError(f"weights: expected {count} rows, got {places}")
    out = new(FLOAT, count, 7)
    lib.rumple_drawing_evaluate(drawing, settings, which, where, count, address(out))
    return out


__all__ = ["WrinklePathsCurves", "WrinklePathsDrawing", "WrinklePathsLists", "WrinklePathsRidingCurves",
           "draw_wrinkle_paths", "drawn_wrinkle_paths", "ride_wrinkle_paths", "wrinkle_path_curves",
           "wrinkle_path_ellipses", "wrinkle_path_lists", "wrinkle_path_stretches"]
