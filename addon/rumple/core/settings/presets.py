# SPDX-License-Identifier: GPL-3.0-or-later
"""The presets of every system. The tooltips give the reasons for their values.

All presets of a system set the same settings, so that a preset undoes what another preset did. They do not change any
other setting. Never imports bpy.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from .fabrics import FABRICS


@dataclass(frozen=True)
class Preset:
    """One entry of a preset menu."""

    number: int  # stored in files, so it must never change
    label: str
    tip: str
    # values of settings; a setting that only other presets have gets its default
    values: dict[str, Any] = field(default_factory=dict)
    fold_width: float = 1.0  # width of its folds relative to cotton; the length that the artist set is scaled by it
    threshold: float = 1.0  # factor on (threshold - 1) relative to cotton; the artist's threshold is scaled in this way
    # Settings that do not describe cloth. The next preset restores their former values.
    replaced: dict[str, Any] = field(default_factory=dict)
    old_fold_width: float | None = None  # its fold_width in files from before fabrics had weights


def touched(presets: dict[str, Preset]) -> set[str]:
    """Names of the settings that the presets of a menu set."""
    return {name for preset in presets.values() for name in preset.values}


def of_fabric(number: int, label: str, tip: str, name: str, values: dict[str, Any],
              fold_width: float | None = None, old_fold_width: float | None = None, threshold: float = 1.0) -> Preset:
    """A preset with the weight, bending length and slack of a fabric. fold_width: None: that of the fabric."""
    fabric = FABRICS[name]
    width = fabric.fold_width if fold_width is None else fold_width
    return Preset(number, label, tip, {**fabric.values, **values}, width, threshold, old_fold_width=old_fold_width)


MESH_PRESETS = {
    "COTTON": of_fabric(0, "Cotton", "Soft everyday folds: a shirt", "COTTON", {}),
    "JERSEY": of_fabric(6, "Jersey", "Clings to the body, small folds where it is pushed together: a T-shirt",
                        "JERSEY",
                        dict(bending=0.55)),
    "SILK": of_fabric(3, "Silk", "Light and flowing: many soft, deep folds", "SILK",
                      dict(bending=0.35, stretch_relief=0.15), old_fold_width=1.0),
    "WOOL": of_fabric(7, "Wool", "Thick and soft: broad round folds", "WOOL", dict(bending=0.95)),
    "SUIT": of_fabric(9, "Suit", "Wool on canvas: it keeps its shape, with a few broad pulls: jackets, coats", "SUIT",
                      dict(bending=1.0, stretch_relief=0.5)),
    "DENIM": of_fabric(1, "Denim", "Fewer, broader, stiffer folds: jeans", "DENIM",
                       dict(bending=0.6, compression_limit=1.25), old_fold_width=2.0),
    "LEATHER": of_fabric(2, "Leather", "Stiff: few wide rolls, nothing fine", "LEATHER",
                         dict(bending=1.0, stretch_relief=0.6, compression_limit=1.2), old_fold_width=2.0),
    "STRETCH": replace(of_fabric(
        8, "Stretch", "Elastic and worn stretched, so it stays smooth on the body: leggings, sportswear, swimwear.\n"
        "Slack below 1: it is cut narrower than the body, so only strong compression folds it, as in an armpit.\n"
        "Room and Slide are short. The next fabric restores them", "STRETCH",
        dict(bending=0.5, stretch_relief=1.0, compression_limit=1.2)),
        replaced=dict(room=0.008, slide_room=0.02)),
    "SKIN": Preset(4, "Bare Skin", "Low creases that never leave the body", dict(
        bending=0.3, radius=0.35, inside=0.8, prestretch=0.99, stretch_relief=1.0, compression_limit=1.15,
        slack=1.0)),
    "PAPER": Preset(5, "As in the Paper", "Mueller and Chentanez 2010, sections 3 and 4: one layer on the animated "
                    "mesh, for dense or simulated meshes",
                    dict(radius=0.45, bending=0.0, inside=0.0, stretch_relief=0.0, compression_limit=10.0),
                    replaced=dict(base_cloth="OFF", layers="ONE", attachment="PN", hem_rings=0, display_steps=0,
                                  damping=0.0, collision="PLANE")),
}

# For Wrinkle Maps on skin without wrinkle settings of its own, by the system that makes the wrinkles. Skin is held from
# below: a wide open jaw compresses a cheek by a quarter, but the folds are less deep than in cloth.
SKIN_OF_MAPS: dict[str, dict[str, Any]] = {
    "MESH": dict(MESH_PRESETS["SKIN"].values, radius=0.2, base_cloth="OFF"),
    # Round rolls between narrow creases, in long rows that are not even
    "FIELD": dict(profile="PENCIL_PLEATS", irregularity=0.5, strength=0.7, buckling_threshold=0.04, base_cloth="OFF"),
}

# Section 9.1 of the thesis: the compression threshold describes how easily a cloth bends, the width how tightly it can
# be compressed.
PATHS_PRESETS = {
    "COTTON": of_fabric(0, "Cotton", "Everyday folds, the measure of the others.\n"
                        "They start at the Threshold and are as wide as you set", "COTTON", {}),
    "SILK": of_fabric(
        1, "Silk", "Many long, thin folds.\n"
        "Threshold nearer to 1, Reach lower: it has next to no stiffness, so little compression buckles it, and "
        "folds run on far.\n"
        "Width x 0.85, less spacing: thin cloth bends tightly, fold beside fold.\n"
        "More turning, less fade: it is smooth and light, so folds slide and spring",
        "SILK", dict(reach=0.2, spacing=1.05, alignment=0.6, fade=0.1), fold_width=0.85, threshold=0.72),
    "WOOL": of_fabric(
        2, "Wool", "Fewer, broad, soft folds.\n"
        "Width x 1.5, more spacing: thick yarn cannot bend tightly.\n"
        "Height 0.85: its loft takes up some of the compression.\n"
        "Less turning, more fade: it is rough and heavy, so folds stay and move slowly",
        "WOOL", dict(spacing=1.2, height=0.85, alignment=0.25, fade=0.25), fold_width=1.5),
    "LEATHER": of_fabric(
        3, "Leather", "Few thick rolls where it must.\n"
        "Threshold farther from 1, Reach higher: it is stiff, so only strong compression buckles it, and the roll "
        "ends with it.\n"
        "Width x 1.8, circular arcs: it bends as a thick plate, in round rolls with creases between.\n"
        "Turning near 0: a crease that has formed stays in its place",
        "LEATHER", dict(reach=0.4, profile="CIRCULAR_ARCS", alignment=0.05, fade=0.2), fold_width=1.8, threshold=1.28),
}
