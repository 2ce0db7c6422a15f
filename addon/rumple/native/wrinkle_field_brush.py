# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting of rest-pose wrinkles: native/include/rumple/wrinkle_field_brush.h. Loviscach 2006, section 7."""
from __future__ import annotations

import ctypes
from typing import Sequence

import numpy as np

from . import c
from .arrays import FLOAT, address, checked, given, new
from .handle import Array, Handle
from .library import lib
from .struct import chosen
from .wrinkle_field import WrinkleFieldModel

LONGEST_PAINTED = float(np.float32(c.LONGEST_PAINTED))


class WrinkleFieldCanvas(Handle):
    """A pose that is painted on. Made by lay_out_canvas."""

    __slots__ = ("model",)
    model: WrinkleFieldModel
    POINTER, FREE = c.CanvasPointer, "rumple_canvas_free"


class WrinkleFieldTwins(Handle):
    """Mirror images in x = 0. Made by find_twins."""

    __slots__ = ("found",)
    POINTER, FREE = c.TwinsPointer, "rumple_twins_free"
    found: int  # number of welded vertices that have a mirror image


class _Lines(Handle):
    __slots__ = ()
    POINTER, FREE = c.LinesPointer, "rumple_lines_free"
    VIEW, LOOK = c.LinesView, "rumple_lines_get_view"

    ends = Array("(m, 6) float32: two of every line", FLOAT, "line_count", 6)
    strength = Array("(m,) float32", FLOAT, "line_count")


def lay_out_canvas(model: WrinkleFieldModel, positions: np.ndarray) -> WrinkleFieldCanvas:
    """positions: (n, 3) float32, deformed base, in any space. Dabs must be in the same space."""
    canvas = WrinkleFieldCanvas.made(lib.rumple_canvas_build, model, *given(positions, "positions", FLOAT, 3))
    canvas.model = model
    return canvas


def find_twins(model: WrinkleFieldModel) -> WrinkleFieldTwins:
    """For every vertex, the place on the rest surface of its mirror image in x = 0."""
    found = ctypes.c_int32()
    twins = WrinkleFieldTwins.made(lib.rumple_twins_build, model, ctypes.addressof(found))
    twins.found = found.value
    return twins


def apply_dab(model: WrinkleFieldModel, canvas: WrinkleFieldCanvas, painted: np.ndarray, *, touch: str = "PAINT",
              centre: Sequence[float], normal: Sequence[float], view: Sequence[float],
              direction: Sequence[float] = (1.0, 0.0, 0.0), across: bool = False, radius: float, strength: float = 1.0,
              length: float = 0.7, falloff: str = "SMOOTH", twins: WrinkleFieldTwins | None = None) -> np.ndarray:
    """Section 7: the painted values after one dab of the brush.

    painted: (n, 3) float32 of the base's vertices, rest space, shorter than 1. touch: PAINT, ERASE or SMOOTH. centre,
    radius: the sphere that is touched. normal: of the surface at the centre. view: from the viewer to it. direction:
    of the stroke, parallel to the screen; the folds run along it or, with across, at right angles. strength 0..1,
    length 0..LONGEST_PAINTED, falloff: SMOOTH, SHARP, LINEAR or CONSTANT. twins: of find_twins() to paint the mirror
    image too.
    """
    if canvas.model is not model:
        raise ValueError("canvas: it was made for another model")
    dab = lib.rumple_dab_default()
    dab.touch, dab.falloff = chosen(touch, "touch", c.TOUCH), chosen(falloff, "falloff", c.FALLOFF)
    for name, vector in (("centre", centre), ("normal", normal), ("view", view), ("direction", direction)):
        if len(vector) != 3:
            raise ValueError(f"{name}: expected three floats, got {len(vector)}")
        setattr(dab, name, tuple(map(float, vector)))
    dab.across, dab.radius, dab.strength, dab.length = across, radius, strength, length
    after = checked(painted, "painted", FLOAT, 3).copy()
    lib.rumple_dab_apply(canvas, dab, twins, address(after), len(after))
    return after


def scatter_rest_wrinkles(model: WrinkleFieldModel, seed: int = 0, density: float = 0.5, size: float = 0.1,
                          length: float = 0.7) -> np.ndarray:
    """Random rest-pose wrinkles, (n, 3) float32. They depend only on the arguments and the rest positions.

    density: share of the vertices with wrinkles, 0..1. size: distance over which they change, object units. length: of
    the longest vectors.
    """
    scatter = lib.rumple_scatter_default()
    scatter.seed, scatter.density, scatter.size, scatter.length = seed, density, size, length
    painted = new(FLOAT, model.base.vertex_count, 3)
    lib.rumple_scatter_paint(model, scatter, address(painted), len(painted))
    return painted


def draw_rest_wrinkles(model: WrinkleFieldModel, canvas: WrinkleFieldCanvas, painted: np.ndarray,
                       across: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Lines along the folds (or across them) for an overlay: ends (2 m, 3) and strengths (m,)."""
    if canvas.model is not model:
        raise ValueError("canvas: it was made for another model")
    lines = _Lines.made(lib.rumple_canvas_draw, canvas, *given(painted, "painted", FLOAT, 3), across)
    return lines.ends.reshape(-1, 3), lines.strength


__all__ = ["LONGEST_PAINTED", "WrinkleFieldCanvas", "WrinkleFieldTwins", "apply_dab", "draw_rest_wrinkles",
           "find_twins", "lay_out_canvas", "scatter_rest_wrinkles"]
