# SPDX-License-Identifier: GPL-3.0-or-later
"""The steps of a frame of the Wrinkle Field, for the GPU preview and for tests."""
from __future__ import annotations

import ctypes

import numpy as np

from . import c
from .arrays import FLOAT, INT, address, given, new
from .library import lib
from .wrinkle_field import WrinkleFieldModel, WrinkleFieldPaint, WrinkleFieldProfile, WrinkleFieldSettings
from .wrinkle_field import WrinkleFieldState, WrinkleFieldWaves


class WrinkleFieldWaveParameters:
    """The wave parameters that settings and paint give the w welded vertices."""

    def __init__(self, count: int) -> None:
        self.wavelength = new(FLOAT, count)  # (w,) W, object units
        self.mask = new(FLOAT, count)  # (w,) factor on the amplitude
        self.rest_wrinkle = new(FLOAT, count, 2)  # (w, 2) q, rest frame
        self.turn = new(FLOAT, count, 2)  # (w, 2) (cos, sin) of the rotation away from k


def wave_parameters_wrinkle_field(model: WrinkleFieldModel, settings: WrinkleFieldSettings,
                                  paint: WrinkleFieldPaint) -> WrinkleFieldWaveParameters:
    """The wave parameters that settings and paint give every welded vertex. They do not depend on the pose."""
    found = WrinkleFieldWaveParameters(model.vertex_count)
    lib.rumple_wrinkle_field_get_wave_parameters(model, settings, paint.of(model), c.WrinkleFieldWaveParameters(
        *map(address, (found.wavelength, found.mask, found.rest_wrinkle, found.turn)), model.vertex_count))
    return found


def probe_formula(formula: int, arguments: np.ndarray) -> np.ndarray:
    """For tests: evaluates shaders/shared/wrinkle_field_probe.glsl for (n, 16) float32."""
    place, count = given(arguments, "arguments", FLOAT, 16)
    out = new(FLOAT, count, 16)
    lib.rumple_probe_formula(formula, place, count, address(out))
    return out


def estimate_waves_wrinkle_field(model: WrinkleFieldModel, settings: WrinkleFieldSettings, paint: WrinkleFieldPaint,
                                 positions: np.ndarray, state: WrinkleFieldState | None = None) -> WrinkleFieldWaves:
    """Section 4.2: the waves of a frame without their phases."""
    return WrinkleFieldWaves.made(lib.rumple_wrinkle_field_estimate_waves, model, settings, paint.of(model),
                                  *given(positions, "positions", FLOAT, 3), state)


def shown_waves_wrinkle_field(model: WrinkleFieldModel, settings: WrinkleFieldSettings, profile: WrinkleFieldProfile,
                              paint: WrinkleFieldPaint, positions: np.ndarray,
                              state: WrinkleFieldState) -> WrinkleFieldWaves:
    """The waves that show_wrinkle_field draws. positions: (n, 3) float32, deformed base, object space. Its arrays have
    a row for every one of the w welded vertices."""
    return WrinkleFieldWaves.made(lib.rumple_wrinkle_field_shown_waves, model, settings, profile, paint.of(model),
                                  *given(positions, "positions", FLOAT, 3), state)


def reference_stretches(model: WrinkleFieldModel, state: WrinkleFieldState, positions: np.ndarray) -> np.ndarray:
    """(w, 3) float32: the stretch (xx, xy, yy) of every welded vertex from the reference triangles around it, rest
    frame; empty if the rest shape is not adaptive."""
    stretches, adapts = new(FLOAT, model.vertex_count, 3), ctypes.c_bool()
    lib.rumple_wrinkle_field_stretches(model, state, *given(positions, "positions", FLOAT, 3), address(stretches),
                                       len(stretches), ctypes.addressof(adapts))
    return stretches if adapts.value else stretches[:0]


def relax_wrinkle_field(model: WrinkleFieldModel, settings: WrinkleFieldSettings, waves: WrinkleFieldWaves,
                        rounds: int, phase: np.ndarray, align: bool = False) -> np.ndarray:
    """Section 5.2: the phases after `rounds` rounds of equation (6). phase: (w,) float32, at the start."""
    given(phase, "phase", FLOAT)
    phases = phase.copy()
    lib.rumple_wrinkle_field_relax(model, settings, waves, rounds, align, address(phases), len(phases))
    return phases


def misfit_wrinkle_field(model: WrinkleFieldModel, waves: WrinkleFieldWaves, phase: np.ndarray) -> float:
    """RMS phase error over edges, turns."""
    misfit = ctypes.c_float()
    lib.rumple_wrinkle_field_misfit(model, waves, *given(phase, "phase", FLOAT), ctypes.addressof(misfit))
    return misfit.value


def random_phases(model: WrinkleFieldModel, seed: int) -> np.ndarray:
    """(w,) float32: the phases at the start of a clip."""
    phases = new(FLOAT, model.vertex_count)
    lib.rumple_wrinkle_field_random_phases(model, seed, address(phases), len(phases))
    return phases


def evaluate_wrinkle_field(model: WrinkleFieldModel, waves: WrinkleFieldWaves, profile: WrinkleFieldProfile,
                           phase: np.ndarray, triangles: np.ndarray,
                           barycentric: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Equations (5) and (8) at places on the base: triangles (p,) int32, barycentric (p, 2) float32, weights of a
    triangle's corners 1 and 2. Returns heights (p,) and gradients (p, 3), object units and space."""
    which, count = given(triangles, "triangles", INT)
    weights, places = given(barycentric, "barycentric", FLOAT, 2)
    if places != count:
        raise ValueError(f"barycentric: expected {count} places, got {places}")
    heights, gradients = new(FLOAT, count), new(FLOAT, count, 3)
    lib.rumple_wrinkle_field_evaluate(model, waves, profile, *given(phase, "phase", FLOAT), which, weights, count,
                                      address(heights), address(gradients))
    return heights, gradients


__all__ = ["WrinkleFieldWaveParameters", "estimate_waves_wrinkle_field", "evaluate_wrinkle_field",
           "misfit_wrinkle_field", "probe_formula", "random_phases", "reference_stretches", "relax_wrinkle_field",
           "shown_waves_wrinkle_field", "wave_parameters_wrinkle_field"]
