# SPDX-License-Identifier: GPL-3.0-or-later
"""The native settings for each layer of a Wrinkle Mesh, from the artist's settings. Never imports bpy.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from ...native import kernels
from ..settings.system_settings import MeshSettings
from .base_cloth import hanging, length_over_cotton


def native_settings(settings: MeshSettings) -> Any:
    """The native solver's settings: the fields of the same name."""
    options = kernels.WrinkleMeshSettings()
    for name in ("radius", "prestretch", "bending", "collision", "inside", "stretch_relief", "buckling_threshold",
                 "compression_limit", "hem_rings", "iterations", "start_iterations", "damping", "offset_space", "nudge",
                 "seed"):
        setattr(options, name, getattr(settings, name))
    settings.fill_reference(options)
    return options


def layer_words(count: int, finer: int = 0) -> list[str]:
    """For every layer, coarse first, the name of the setting for its strength. finer: how many of the layers exist only
    where folds are painted narrower."""
    words = ["drape"] * max(count - finer - 2, 0) + ["folds", "detail"]
    return words[finer - count:] + ["detail"] * finer


# Values that differ for layers, found by measurements on shirts, sweaters and trousers (docs/wrinkle_mesh.md, Layers).
WIDEST_RADIUS = 0.6  # radius of the widest layer / radius of the others
LAYER_INSIDE = 1.5  # inward room / inward room of a single layer: larger, because the body limits it
TANGENTIAL_PULL, NORMAL_PULL = 0.2, 0.02
APART = 0.45  # share of the distance to other cloth of the garment that a vertex may move towards it
SLIDE = 0.45  # share of its triangles' heights that a vertex may move along the surface
START_ITERATIONS = 3  # factor on the iterations of a single layer
# Passes of a layer for each layer above it, as a multiple of the finest layer's passes. A pass moves a vertex by its
# neighbours only. With few passes a fold is only a few edges long, and one long fold becomes several short ones.
WIDE_PASSES = 3
# The most length that all layers but the finest gather, relative to the compressed mesh, where they are not made wider.
# For the same gather, a fold of twice the width is twice as high, so strongly compressed cloth would bulge. This is for
# cotton: the excess over 1 goes with the square of the bending length, because stiff cloth has no narrow folds.
WIDE_GATHER = 1.15
# Share of this excess where cloth touches what is worn under it: a wide fold has no room there, and narrow ones take up
# the length. By simulations of trousers, whose hips have more narrow folds than their legs.
CONTACT_GATHER = 1.0 / 3.0
LOOSER = 2.0  # slack of the layers / slack of the base cloth, where it is not taut
FINEST_HEM = 2  # rings over which the finest layer fades at open borders: a hem is double, so narrow folds end there
TAUT_RANGE = 0.03  # range of strain over which a slack base becomes taut: along the pull no length is left for folds
LIMPEST = 0.7  # least bending length / cotton's, about that of silk: softer cloth counts as this soft
LAYER_BENDING = 0.7  # bending / bending of a single layer: lower, because the wider layers make the wide folds


def slack_factor(settings: MeshSettings, number: int) -> float:
    """Excess length of a layer / excess length of the base cloth (its slack - 1). Stiff cloth uses its excess length
    for its widest folds."""
    return LOOSER if number == 0 else LOOSER / max(length_over_cotton(settings.bending_length), LIMPEST)


def wide_gather(bending_length: float) -> float:
    """WIDE_GATHER for cloth of this bending length (metres)."""
    return 1.0 + (WIDE_GATHER - 1.0) * length_over_cotton(bending_length) ** 2


def gather_limit(most: float, wide: float, prestretch: float, share: float) -> float:
    """The most length that a layer gathers, relative to the compressed mesh. most: the limit in the settings. wide:
    wide_gather() of the cloth. prestretch: of the layer. share: wide_share() of the layer."""
    return float(np.interp(share, (0.0, 1.0), (most, min(max(wide, prestretch), most))))


def wide_share(above: int, finest: float) -> float:
    """1 for a wide layer, 0 for the finest one. above: how many layers lie on this one, 0 for the finest, negative for
    layers that exist only where folds are painted narrower. finest: strength of the finest layer, 0 to 1. While it is
    0, the layer below counts as the finest."""
    return min(max(above - 1.0 + finest, 0.0), 1.0)


def layer_settings(settings: MeshSettings, count: int, finest: float = 1.0,
                   world_from_object: np.ndarray | None = None, bend: float = 0.0, finer: int = 0) -> list[Any]:
    """The native settings of every layer, coarse first. finer: see layer_words(). finest: strength of the last layer
    before these finer ones, 0 to 1. world_from_object: (3, 3), for where cloth hangs down; None: the identity. bend:
    bend_radius()."""
    out = []
    hang = hanging(settings.gravity, world_from_object)
    common = native_settings(settings)
    for number, word in enumerate(layer_words(count, finer)):
        options = type(common).from_buffer_copy(common)
        above = count - finer - 1 - number
        # It scales the radius and the layer's extra width alike, because much cloth in little room would crumple.
        share = getattr(settings, word) * (finest if above == 0 else 1.0)
        options.radius = settings.radius * share * (WIDEST_RADIUS if number == 0 else 1.0)
        options.inside = min(LAYER_INSIDE * settings.inside, 1.0)
        options.hem_rings = min(settings.hem_rings, number + 1)
        options.bending = LAYER_BENDING * settings.bending
        options.tangential_pull, options.normal_pull = TANGENTIAL_PULL, NORMAL_PULL
        options.apart, options.slide = APART, SLIDE
        options.start_iterations = START_ITERATIONS * settings.start_iterations
        options.iterations = round(settings.iterations * max(WIDE_PASSES * (above - 1.0 + finest), 1.0))
        if settings.base_cloth != "OFF":
            if number > 0 and above <= 0:
                options.hem_rings = max(options.hem_rings, FINEST_HEM)
            excess = share * slack_factor(settings, number) * (settings.slack - 1.0)
            options.prestretch = settings.prestretch * (1.0 + excess)
            wide = wide_share(above, finest)
            options.compression_limit = gather_limit(settings.compression_limit, wide_gather(settings.bending_length),
                                                     options.prestretch, wide)
            options.contact_gather = 1.0 + wide * (CONTACT_GATHER - 1.0)
            options.slack, options.taut_range = settings.slack, TAUT_RANGE
            options.hang, options.bend_radius = hang, bend
        out.append(options)
    return out
