# SPDX-License-Identifier: GPL-3.0-or-later
"""What the layers of a Wrinkle Mesh are solved with: its settings as the native solver takes them. Never imports bpy.
"""
from __future__ import annotations

from typing import Any

import numpy as np

from ..native import kernels
from .cloth import hanging, length_over_cotton
from .settings import MeshSettings


def native_settings(settings: MeshSettings) -> Any:
    """The native solver's settings: the fields of the same name."""
    options = kernels.WrinkleMeshSettings()
    for name in ("radius", "prestretch", "bending", "collision", "inside", "stretch_relief", "buckling_threshold",
                 "compression_limit", "hem_rings", "iterations", "start_iterations", "damping", "offset_space", "nudge",
                 "seed"):
        setattr(options, name, getattr(settings, name))
    options.free_compression_limit = settings.compression_limit
    settings.fill_reference(options)
    return options


def layer_words(count: int, finer: int = 0) -> list[str]:
    """For every layer, coarse first, the setting that says how much of it there is. finer: how many of them are there
    for what is painted narrower alone."""
    words = ["drape"] * max(count - finer - 2, 0) + ["folds", "detail"]
    return words[finer - count:] + ["detail"] * finer


# What layers have their own way, measured on shirts, sweaters and trousers (docs/wrinkle_mesh.md, Layers).
WIDEST_RADIUS = 0.6  # of the base mesh itself, over that of the others
LAYER_INSIDE = 1.5  # inward room over that of one layer: the body bounds it
TANGENTIAL_PULL, NORMAL_PULL = 0.2, 0.02
APART = 0.45  # share of the distance to its own cloth that a vertex may go towards it
SLIDE = 0.45  # share of the heights of its triangles that a vertex may go along the surface
START_ITERATIONS = 3  # times those of one layer
# Passes of a layer for each one that lies on it, over those of the finest: a pass moves a vertex by what its neighbours
# do, so with few a fold is no longer than a few edges, and what should be one long fold is several short ones.
WIDE_PASSES = 3
# Most length that all but the finest layer gather, over that of the compressed mesh, where they are not cut wider. A
# fold of twice the width is twice as high for the same gather, so what is pressed together more would bulge; cloth on a
# body has narrow folds there.
WIDE_GATHER = 1.05
FREE_GATHER = 1.15  # the same where cloth hangs free: there is room for wide folds, and narrow ones look crumpled
LOOSER = 2.0  # slack of the layers over that of the base cloth, where that is not taut
FINEST_HEM = 2  # rings over which the finest layer fades at open borders: a hem is sewn double, narrow folds end there
TAUT_RANGE = 0.03  # strain over which a base that is slack becomes taut: along the pull cloth has nothing to spare
LIMPEST = 0.7  # bending length over cotton's, about silk's: limper cloth has no more to spare than that
LAYER_BENDING = 0.7  # over that of one layer: the wider layers make the wide folds


def slack_factor(settings: MeshSettings, number: int) -> float:
    """Excess length of a layer over that of the base cloth, which is its slack less 1. Stiff cloth spends what it has
    to spare on its widest folds."""
    return LOOSER if number == 0 else LOOSER / max(length_over_cotton(settings.bending_length), LIMPEST)


def gather_limit(most: float, prestretch: float, above: int, finest: float) -> float:
    """Most length that a layer gathers, over that of the compressed mesh. most: that is set. prestretch: of the layer.
    above: how many layers lie on this one, 0 for the finest, below 0 for what is painted narrower. finest: how much
    there is of the finest, 0 to 1: as long as it is not there, the one below it counts as the finest."""
    wide = min(max(WIDE_GATHER, prestretch), most)
    return float(np.interp(above - 1.0 + finest, (0.0, 1.0), (most, wide)))


def layer_settings(settings: MeshSettings, count: int, finest: float = 1.0,
                   world_from_object: np.ndarray | None = None, bend: float = 0.0, finer: int = 0) -> list[Any]:
    """The native settings of every layer, coarse first. finer: as layer_words() has it. finest: how much there is of
    the last one before these, 0 to 1.
    world_from_object: (3, 3), for where cloth hangs down; None: the identity. bend: bend_radius()."""
    out = []
    hang = hanging(settings.gravity, world_from_object)
    for number, word in enumerate(layer_words(count, finer)):
        options = native_settings(settings)
        above = count - finer - 1 - number
        # Of the radius and of what the layer is wider alike: much cloth in little room is crumpled.
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
            options.compression_limit = gather_limit(settings.compression_limit, options.prestretch, above, finest)
            options.free_compression_limit = max(min(FREE_GATHER, settings.compression_limit),
                                                 options.compression_limit)
            options.slack, options.taut_range = settings.slack, TAUT_RANGE
            options.hang, options.bend_radius = hang, bend
        out.append(options)
    return out
