# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds skin in the mesh of its clothes by the names of the materials, as in characters of games: also skin that is
welded to clothes, or that has no shape that skin_parts.py knows. Hair, shoes and metal count as skin: they are not
cloth either. Never imports bpy.
"""
from __future__ import annotations

import re

import numpy as np

from ..base.vertices import places
from ..mesh.base_mesh import BaseMesh

# Words in the singular, where the plural means the same ("Shorts", but "Hair_Short"). Words that also name a piece of a
# garment (body, arm, leg, neck) say nothing.
SKIN = frozenset((
    "skin", "flesh", "face", "head", "cheek", "chin", "scalp", "hair", "beard", "brow", "eyebrow", "eye", "iris",
    "pupil", "sclera", "cornea", "eyelash", "lash", "ear", "nose", "mouth", "lip", "tooth", "teeth", "tongue", "gum",
    "hand", "finger", "nail", "fingernail", "foot", "feet", "toe", "toenail"))
SHOES = frozenset(("shoe", "boot", "sneaker", "sandal", "slipper", "sole"))
# Of armour over clothes. Colours ("Gold", "Silver") are not among them.
METALS = frozenset((
    "metal", "steel", "iron", "brass", "bronze", "chrome", "armor", "armour", "chestplate", "breastplate"))
SKIN_CHARACTERS = frozenset("肌肤膚顔颜脸臉髪髮靴鞋")
# Of a name with one of these, no other word counts: a head scarf, a hand-knitted sweater, a skin suit.
GARMENTS = frozenset((
    "clothe", "clothing", "garment", "outfit", "suit", "uniform", "costume", "shirt", "tee", "tops", "bottoms",
    "blouse", "pullover", "sweater", "hoodie", "hood", "jacket", "coat", "vest", "tunic", "robe", "dress", "gown",
    "skirt", "trouser", "pant", "jean", "shorts", "legging", "sleeve", "collar", "cuff", "cape", "cloak", "scarf",
    "veil", "hat", "cap", "band", "glove", "sock", "stocking", "tights", "underwear"))
GARMENT_CHARACTERS = ("服", "衣", "袖", "裙", "裤", "褲", "帽", "巾", "袋", "袜", "襪", "靴下")
# What garments and shoes are made of.
FABRICS = frozenset(("cloth", "fabric", "cotton", "wool", "linen", "silk", "denim", "leather", "jersey"))
HAIR, CAP = frozenset(("hair", "scalp")), "cap"  # a cap of hair is the part of it that lies on the head
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")  # also the words of "EyeLash" and "SKIN_head"
LEAST_AREA = 0.02  # least share of skin and of cloth in the area: a face without clothes, clothes with a stain


def names_skin(material: str) -> bool:
    """Whether a material is one of skin, hair, shoes or metal, by the words of its name: English, Chinese or
    Japanese."""
    words = {word.lower() for word in _WORD.findall(material)}
    words |= {word.removesuffix(end) for word in words for end in ("s", "es")}
    if words & HAIR:
        words.discard(CAP)
    if words & GARMENTS or any(character in material for character in GARMENT_CHARACTERS):
        return False
    if words & SHOES or SKIN_CHARACTERS & set(material):
        return True
    return bool(words & (SKIN | METALS)) and not words & FABRICS


def is_beside_cloth(base: BaseMesh, skin: np.ndarray) -> bool:
    """Whether a mesh has both skin and cloth. skin: (p,) bool of its polygons."""
    areas = base.polygon_areas()
    share = areas[skin].sum() / max(areas.sum(), 1e-30)
    return bool(LEAST_AREA < share < 1.0 - LEAST_AREA)


def vertices_of(base: BaseMesh, polygons: np.ndarray) -> np.ndarray:
    """(n,) bool: the vertices of some polygons, and the others at their places. polygons: (p,) bool."""
    place = places(base.positions)
    chosen = np.zeros(len(place), bool)
    chosen[place[base.corner_vertex[np.repeat(polygons, np.diff(base.polygon_start))]]] = True
    return chosen[place]
