# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloths to choose from, for every system that has some. The tooltips give the reasons.

A preset sets what any preset of its system sets, so that one takes back what another did; all other settings are the
artist's. Never imports bpy.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Preset:
    """One entry of a preset menu."""

    label: str
    tip: str
    values: dict[str, Any] = field(default_factory=dict)  # of the settings; defaults where another preset says more
    fold_width: float = 1.0  # of its folds over cotton's: the length that the artist set is scaled by it


def touched(presets: dict[str, Preset]) -> set[str]:
    """Names of the settings that a menu of presets sets."""
    return {name for preset in presets.values() for name in preset.values}


# One level of subdivision is the least step of the fold width: less than twice as wide would round to none.
MESH_PRESETS = {
    "COTTON": Preset("Cotton", "Soft everyday folds: a shirt"),
    "DENIM": Preset("Denim", "Fewer, broader, stiffer folds: jeans", dict(
        bending=1.0, radius=1.1, compression_limit=1.25), fold_width=2.0),
    "LEATHER": Preset("Leather", "Only where it must: few round folds", dict(
        bending=1.0, radius=0.9, prestretch=0.98, stretch_relief=0.6, compression_limit=1.2), fold_width=2.0),
    "SILK": Preset("Silk", "Many fine, sharp folds", dict(
        bending=0.35, radius=1.1, prestretch=1.02, stretch_relief=0.15)),
    "SKIN": Preset("Skin", "Low creases that never leave the body", dict(
        bending=0.3, radius=0.35, inside=0.8, prestretch=0.99, stretch_relief=1.0, compression_limit=1.15)),
    "PAPER": Preset("As in the Paper", "Mueller and Chentanez 2010, sections 3 and 4: for dense or simulated meshes",
                    dict(attachment="PN", radius=0.45, bending=0.0, inside=0.0, stretch_relief=0.0,
                         compression_limit=10.0, hem_rings=0, display_steps=0, damping=0.0, collision="PLANE")),
}

# Section 9.1 of the thesis: the compression sensitivity is how easily a cloth bends, the width how tightly it can be
# squeezed.
PATHS_PRESETS = {
    "COTTON": Preset("Cotton", "Everyday folds, the measure of the others.\n"
                     "They start at a fifth of compression, and are as wide as you set"),
    "SILK": Preset(
        "Silk", "Many long, thin folds.\n"
        "Sensitivity nearer to 1, a longer reach: it has next to no stiffness, so little compression buckles it, and "
        "folds run on far.\n"
        "Width x 0.85, less spacing: thin cloth bends tightly, fold beside fold.\n"
        "More turning, less fade: it is smooth and light, so folds slide and spring",
        dict(threshold=1.18, reach=0.2, spacing=1.05, alignment=0.6, fade=0.1), fold_width=0.85),
    "WOOL": Preset(
        "Wool", "Fewer, broad, soft folds.\n"
        "Width x 1.5, more spacing: thick yarn cannot bend tightly.\n"
        "Height 0.85: its loft takes up some of the compression.\n"
        "Less turning, more fade: it is rough and heavy, so folds stay and move slowly",
        dict(threshold=1.25, spacing=1.2, height=0.85, alignment=0.25, fade=0.25), fold_width=1.5),
    "LEATHER": Preset(
        "Leather", "Few thick rolls where it must.\n"
        "Sensitivity away from 1, a shorter reach: it is stiff, so only strong compression buckles it, and the roll "
        "ends with it.\n"
        "Width x 1.8, circular arcs: it bends as a thick plate, in round rolls with creases between.\n"
        "Turning near 0: a crease that has formed stays in its place",
        dict(threshold=1.32, reach=0.4, profile="CIRCULAR_ARCS", alignment=0.05, fade=0.2), fold_width=1.8),
}
