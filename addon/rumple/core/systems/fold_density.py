# SPDX-License-Identifier: GPL-3.0-or-later
"""How dense the fine mesh of a Wrinkle Mesh is for folds of a wavelength. Never imports bpy."""
from __future__ import annotations

import math
from typing import Any

from ..mesh.base_mesh import MOST_LEVEL, BaseMesh
from ..settings.system_settings import MeshSettings

MOST_PLAYABLE = 60_000  # solved vertices that still play live on a few cores
EDGES_PER_WAVELENGTH = 5.0  # measured on garments with bend stiffness of 0.7 and more
FIRST_SHARE = 0.25  # halvings beyond a layer's wavelength from which on there is a finer layer


def halvings(edge: float, wavelength: float) -> float:
    """How often a mean edge must be halved to be wavelength / 5, at most 5. Negative if it is shorter. Both in metres.
    """
    if edge <= 0.0 or wavelength <= 0.0:
        return 0.0
    return min(math.log2(edge * EDGES_PER_WAVELENGTH / wavelength), float(MOST_LEVEL))


def level_for(base: BaseMesh, wavelength: float, unit_scale: float) -> int:
    """Subdivisions after which the mean edge is nearest to wavelength / 5 (in powers of two), 0 to 5.

    wavelength: metres; unit_scale: metres per object unit.
    """
    return max(round(halvings(base.mean_edge() * unit_scale, wavelength)), 0)


def layers_for(count: float) -> tuple[int, float]:
    """Subdivisions of the finest layer if `count` halvings are asked for, and the layer's strength, 0 to 1. For a
    wavelength between two layers, the finer one has a reduced strength, so that any wavelength is possible."""
    count = max(count, 0.0)
    level = math.floor(count)
    share = min(share_of_layer(count, level + 1), 1.0)
    return (level + 1, share) if share > 0.0 else (level, 1.0)


def share_of_layer(count: Any, layer: int) -> Any:
    """Strength of a layer if `count` halvings are asked for: it begins FIRST_SHARE of a halving after the layer before,
    and grows to 1 until its own wavelength. It is not clamped: up to 0 there is no such layer, from 1 on it has full
    strength."""
    return (count - (layer - 1) - FIRST_SHARE) / (1.0 - FIRST_SHARE)


def wavelength_of(base: BaseMesh, level: int, unit_scale: float) -> float:
    """The width of folds, in metres, for `level` subdivisions: the inverse of level_for()."""
    return base.mean_edge() * unit_scale * EDGES_PER_WAVELENGTH / 2**level


def suggested_wavelength(base: BaseMesh, unit_scale: float) -> float:
    """A width of folds that suits the mesh, in metres: that of level 2, or of a lower level if the mesh would play too
    slowly.

    It has two significant digits, so that the slider shows a round number. So dolls, giants and dense meshes get a
    suitable default.
    """
    level = 2
    while level > 0 and len(base.corner_vertex) / 4 * 4**level > MOST_PLAYABLE:
        level -= 1
    wavelength = wavelength_of(base, level, unit_scale)
    return float(f"{wavelength:.2g}") if wavelength > 0.0 else MeshSettings.wavelength
