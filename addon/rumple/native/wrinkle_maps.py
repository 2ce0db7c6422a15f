# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrinkle Maps: native/include/rumple/wrinkle_maps.h. L. Dutreve, A. Meyer and S. Bouakaz, ISVC 2009."""
from __future__ import annotations

import ctypes
from typing import Sequence

import numpy as np

from . import c
from .arrays import BYTE, FLOAT, INT, address, checked, fill, given, new
from .handle import Array, Handle, Number
from .library import lib
from .struct import chosen

MOST_POSES = c.MOST_POSES


class WrinkleMapsModel(Handle):
    """Reference poses and skin weights. Made by build_wrinkle_maps. b bones, o poses, n vertices."""

    __slots__ = ()
    POINTER, FREE = c.WrinkleMapsPointer, "rumple_wrinkle_maps_free"
    VIEW, LOOK = c.WrinkleMapsView, "rumple_wrinkle_maps_get_view"

    vertex_count = Number("n")
    pose_count = Number("o")
    bone_count = Number("b")
    unnormalised = Number("vertices whose weights did not sum to 1")
    unbound = Number("vertices without any weight")
    moves = Array("(b, o) uint8: 1 where a bone moves in a pose; elsewhere its influence is 0, alone", BYTE,
                  "bone_count", "pose_count")
    reach = Array("(n, o) float32: sum of the weights of what moves in a pose, 0 or more; above 1 with shape keys only",
                  FLOAT, "vertex_count", "pose_count")
    weight_start = Array("(n + 1,) int32", INT, "vertex_count", more=1)
    weight_bone = Array("int32", INT, "weight_count")
    weight = Array("float32", FLOAT, "weight_count")

    @property
    def weights(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(start, bone, weight) as given, but summing to 1 and without the bones that are not listed"""
        return self.weight_start, self.weight_bone, self.weight


def build_wrinkle_maps(names: Sequence[str], tracked: Sequence[str], group: np.ndarray, neutral: np.ndarray,
                       poses: Sequence[tuple[str, np.ndarray]], weight_start: np.ndarray, weight_bone: np.ndarray,
                       weight: np.ndarray) -> WrinkleMapsModel:
    """Reference poses and skin weights (Dutreve et al. 2009, section 5).

    names: of the b bones. tracked: HEAD, TAIL, BOTH or KEY for each. group: (b,) int32, -1: none. neutral: (b, 6)
    float32, heads and tails in root space; for a shape key (KEY) the first number is its value. poses: at most
    MOST_POSES of (name, (b, 6) float32). Weights of n vertices: weight_start (n + 1,) int32, rows of weight_bone int32
    (-1: a bone that is not listed) and of weight float32. Raises ValueError.
    """
    plan = c.WrinkleMapsPlan()
    called = (ctypes.c_char_p * len(names))(*(name.encode() for name in names))
    plan.names, plan.names_count = ctypes.addressof(called), len(names)
    follows = np.array([chosen(name, "tracked", c.TRACKED) for name in tracked], INT)
    fill(plan, "tracked", follows, INT)
    fill(plan, "group", group, INT)
    fill(plan, "neutral", neutral, FLOAT, 6)
    shapes = (c.WrinkleMapsPose * len(poses))()
    for shape, (name, bones) in zip(shapes, poses):
        shape.name = name.encode()
        shape.bones, shape.bones_count = given(bones, name, FLOAT, 6)
    plan.poses, plan.poses_count = ctypes.pointer(shapes[0]) if len(poses) else None, len(poses)
    fill(plan, "weight_start", weight_start, INT)
    fill(plan, "weight_bone", weight_bone, INT)
    fill(plan, "weight", weight, FLOAT)
    return WrinkleMapsModel.made(lib.rumple_wrinkle_maps_build, plan)


class WrinkleMapsInfluences:
    """The influences of the reference poses on every bone, in one frame."""

    def __init__(self, pose: np.ndarray, rest: np.ndarray) -> None:
        self.pose = pose  # (b, o) float32, 0..1
        self.rest = rest  # (b,) float32, 0..1

    def _arguments(self) -> tuple[int, int, int, int]:
        return self.pose.ctypes.data, self.pose.size, self.rest.ctypes.data, self.rest.size


def bones_in_root_space(root: np.ndarray, bones: np.ndarray) -> np.ndarray:
    """Bones, (b, 6) float32, transformed into root space. root: (4, 4) float32, from root space to the bones' space."""
    place, rows = given(root, "root", FLOAT, 4)
    if rows != 4:
        raise ValueError(f"root: expected shape (4, 4), got {root.shape}")
    where, count = given(bones, "bones", FLOAT, 6)
    out = new(FLOAT, count, 6)
    lib.rumple_bones_in_root_space(place, where, count, address(out), count)
    return out


def evaluate_wrinkle_maps(model: WrinkleMapsModel, bones: np.ndarray) -> WrinkleMapsInfluences:
    """Section 5.1. bones: (b, 6) float32, root space."""
    at = WrinkleMapsInfluences(new(FLOAT, model.bone_count, model.pose_count), new(FLOAT, model.bone_count))
    lib.rumple_wrinkle_maps_evaluate(model, *given(bones, "bones", FLOAT, 6), *at._arguments())
    return at


def presence_of_wrinkle_maps(model: WrinkleMapsModel, influences: WrinkleMapsInfluences) -> np.ndarray:
    """(o,) float32: how much of each pose is present as a whole."""
    out = new(FLOAT, model.pose_count)
    lib.rumple_wrinkle_maps_presence(model, *influences._arguments(), address(out), len(out))
    return out


def masks_of_wrinkle_maps(model: WrinkleMapsModel, influences: WrinkleMapsInfluences, gain: float = 1.0,
                          strength: Sequence[float] = ()) -> np.ndarray:
    """Section 5.2: (o, n) float32, 0..1. gain: 0.1..100; strength: 0..1 for each pose, empty: 1."""
    settings = lib.rumple_wrinkle_maps_settings_default()
    settings.gain = gain
    strengths = np.array(strength, np.float32)
    fill(settings, "strength", strengths, FLOAT)
    out = new(FLOAT, model.pose_count, model.vertex_count)
    lib.rumple_wrinkle_maps_masks(model, settings, *influences._arguments(), address(out), out.size)
    return out


def blend_wrinkle_maps(neutral: np.ndarray, wrinkles: Sequence[np.ndarray], masks: Sequence[np.ndarray],
                       maps: str = "WRINKLES") -> np.ndarray:
    """Section 5.3: blended unit normals in tangent space, (n, 3) float32, for n pixels. neutral: (n, 3) float32. For
    each of o poses: wrinkles (n, 3) and masks (n,). maps: WHOLE or WRINKLES."""
    place, count = given(neutral, "neutral", FLOAT, 3)
    if len(masks) != len(wrinkles):
        raise ValueError(f"masks: expected {len(wrinkles)} arrays, got {len(masks)}")
    for number, (normals, mask) in enumerate(zip(wrinkles, masks)):
        if len(checked(normals, "wrinkles", FLOAT, 3)) != count or len(checked(mask, "masks", FLOAT)) != count:
            raise ValueError(f"pose {number}: expected {count} normals and masks, got {len(normals)} and {len(mask)}")
    places = [(ctypes.c_void_p * len(arrays))(*map(address, arrays)) for arrays in (wrinkles, masks)]
    out = new(FLOAT, count, 3)
    lib.rumple_wrinkle_maps_blend(chosen(maps, "maps", c.MAPS_KIND), place, count, ctypes.addressof(places[0]),
                                  ctypes.addressof(places[1]), len(wrinkles), address(out), count)
    return out


__all__ = ["MOST_POSES", "WrinkleMapsInfluences", "WrinkleMapsModel", "blend_wrinkle_maps", "bones_in_root_space",
           "build_wrinkle_maps", "evaluate_wrinkle_maps", "masks_of_wrinkle_maps", "presence_of_wrinkle_maps"]
