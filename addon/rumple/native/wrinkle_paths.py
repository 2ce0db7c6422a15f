# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Paths: native/include/rumple/wrinkle_paths.h. R. Gillette, UBC 2015."""
from __future__ import annotations

from typing import Any

import numpy as np

from . import c
from .arrays import FLOAT, INT, fill, lent, lent_all
from .handle import Array, Handle, Number
from .library import lib
from .struct import Choice, chosen
from .surface import (FramePose, FrameState, Model, ReferenceSettings, ShownFrame, Surface, fill_reference, fill_stored,
                      fine_plan, reference_arrays, stored_number)


class WrinklePathsModel(Model):
    """A base and the fine mesh shown on it. Made by build_wrinkle_paths."""

    __slots__ = ("base",)
    base: Surface
    POINTER, FREE = c.WrinklePathsPointer, "rumple_wrinkle_paths_free"
    VIEW, LOOK = c.WrinklePathsView, "rumple_wrinkle_paths_get_view"
    SHOWN, LABEL = "rumple_wrinkle_paths_shown", "rumple_wrinkle_paths_label_clip"

    triangle_count = Number("t")
    triangle_vertex = Array("(t, 3) int32: welded vertices of the base's triangles", INT, "triangle_count", 3)


def build_wrinkle_paths(base: Surface, source: str = "SUBDIVISION", level: int = 3, segments: int = 8,
                        longest_edge: float = 0.005, most_vertices: int = 4_000_000,
                        attachment: str = "LIMIT") -> WrinklePathsModel:
    """Make the fine mesh that folds are shown on.

    source: SUBDIVISION (level), REGULAR (segments) or EDGE_LENGTH (longest_edge). attachment: LINEAR, PN or LIMIT.
    Edges of 3/8 of the width show every fold. Raises ValueError.
    """
    plan = lib.rumple_wrinkle_paths_plan_default()
    fine_plan(plan, source, level, segments, longest_edge, most_vertices, attachment)
    model = WrinklePathsModel.made(lib.rumple_wrinkle_paths_build, base, plan)
    model.base = base
    return model


class WrinklePathsSettings(c.WrinklePathsSettings, ReferenceSettings):
    """Settings of a solve; see docs/wrinkle_paths.md. Lengths in object units."""

    __slots__ = ()
    direction: Any = Choice(c.FOLD_DIRECTION)
    profile: Any = Choice(c.FOLD_PROFILE)

    def __new__(cls) -> "WrinklePathsSettings":
        return cls.from_buffer_copy(lib.rumple_wrinkle_paths_settings_default())


class WrinklePathsPaint(Handle):
    """Painted factors of the base's vertices."""

    __slots__ = ()
    POINTER, FREE = c.WrinklePathsPaintPointer, "rumple_wrinkle_paths_paint_free"

    def __init__(self, model: WrinklePathsModel, painted: dict[str, np.ndarray] | None = None) -> None:
        """painted: mask -> (n,) float32 of the base's vertices, 0..1: where folds may start; width -> (n,), 0.1..1:
        factor on their width; along -> (n, 3): their direction at rest, with a length of 0..1."""
        values = c.WrinklePathsPainted()
        for name, array in (painted or {}).items():
            fill(values, name, array, FLOAT, chosen(name, "paint", {"mask": 0, "width": 0, "along": 3}))
        self._filled(self, lib.rumple_wrinkle_paths_paint_build, model, values)


class WrinklePathsPose(FramePose):
    """The pose of a model in one frame. Made by WrinklePathsPose.of(model, positions, ...)."""

    __slots__ = ()
    POINTER, FREE = c.WrinklePathsPosePointer, "rumple_wrinkle_paths_pose_free"
    BUILD = "rumple_wrinkle_paths_pose_build"


class WrinklePathsState(FrameState):
    """The solver's state, which is kept from frame to frame."""

    __slots__ = ()
    POINTER, FREE = c.WrinklePathsStatePointer, "rumple_wrinkle_paths_state_free"
    VIEW, LOOK = c.WrinklePathsStateView, "rumple_wrinkle_paths_state_get_view"
    ARRAYS = {"shapes": (FLOAT, 3), "compression": (FLOAT, 0), "width": (FLOAT, 0), "path_id": (INT, 0),
              "path_fade": (FLOAT, 0), "path_start": (INT, 0), "point_triangle_edge": (INT, 2), "point_at": (FLOAT, 2)}

    path_count = Number("paths", "path_id_count")

    def __init__(self, model: WrinklePathsModel, arrays: dict[str, Any]) -> None:
        """The state from the plain arrays of `arrays`."""
        view = c.WrinklePathsStateView()
        fill_reference(view.reference, arrays)
        view.next_id = stored_number(arrays, "next_id", int)
        fill_stored(view, arrays, self.ARRAYS)
        self._filled(self, lib.rumple_wrinkle_paths_state_build, model, view)

    @property
    def arrays(self) -> dict[str, Any]:
        """The state as plain arrays. of() makes the same state from them, bit for bit."""
        view = self.view
        return {**(reference_arrays(self, view.reference) or {}), "next_id": view.next_id,
                **lent_all(self, view, self.ARRAYS)}

    @classmethod
    def of(cls, model: WrinklePathsModel, arrays: dict[str, Any]) -> "WrinklePathsState":
        """The state from the plain arrays of `arrays`."""
        return cls(model, arrays)

    @property
    def time(self) -> float:
        """seconds"""
        return self.view.reference.time

    @property
    def labels(self) -> np.ndarray:
        """(t,) uint8: 0 compress, 1 rest, 2 stretch"""
        return self.arrays["labels"]


class WrinklePathsReport(c.WrinklePathsReport):
    """The report on a solve."""

    __slots__ = ()


class WrinklePathsPicture(ShownFrame):
    """The shown mesh of one frame."""

    __slots__ = ()

    @property
    def height(self) -> np.ndarray:
        """(d,) float32, along the smooth normal, object units"""
        folds = c.FrameFoldsView()
        lib.rumple_frame_get_folds(self, folds)
        return lent(self, folds.height, FLOAT, (folds.vertex_count,))


def solve_wrinkle_paths(model: WrinklePathsModel, settings: WrinklePathsSettings, paint: WrinklePathsPaint | None,
                        positions: np.ndarray | WrinklePathsPose, time: float, state: WrinklePathsState | None = None,
                        labels: np.ndarray | None = None, next_positions: np.ndarray | None = None,
                        next_time: float = 0.0) -> tuple[WrinklePathsState, WrinklePathsReport]:
    """Solve one frame; returns (state, report). positions: (n, 3) float32, deformed base, object space; or a pose,
    which then replaces the arguments about the frame. time: seconds.

    state: of the frame before, or None for the canonical start. labels: (t,) uint8 from label_clip. next_positions,
    next_time: the next frame, which labelling looks ahead to. Raises ValueError. Chapters 4 and 5.
    """
    report = WrinklePathsReport()
    return WrinklePathsState.made(
        lib.rumple_wrinkle_paths_solve, model, settings, paint,
        WrinklePathsPose.of(model, positions, time, labels, next_positions, next_time), state, report), report


def show_wrinkle_paths(model: WrinklePathsModel, settings: WrinklePathsSettings,
                       positions: np.ndarray | WrinklePathsPose, state: WrinklePathsState) -> WrinklePathsPicture:
    """The shown mesh for a frame and its state."""
    return WrinklePathsPicture.made(lib.rumple_wrinkle_paths_show, model, settings,
                                    WrinklePathsPose.of(model, positions), state)


def wrinkle_path_fault(state: WrinklePathsState) -> str:
    """Empty if every path lies on the surface of the state's model; otherwise what is wrong."""
    try:
        lib.rumple_wrinkle_paths_state_check(state)
    except ValueError as error:
        return str(error)
    return ""


__all__ = ["WrinklePathsModel", "WrinklePathsPaint", "WrinklePathsPicture", "WrinklePathsPose", "WrinklePathsReport",
           "WrinklePathsSettings", "WrinklePathsState", "build_wrinkle_paths", "show_wrinkle_paths",
           "solve_wrinkle_paths", "wrinkle_path_fault"]
