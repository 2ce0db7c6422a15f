# SPDX-License-Identifier: GPL-3.0-or-later
"""Reference poses of bones and shape keys, which Wrinkle Maps compare the current pose with. No bpy here.

The JSON that to_json() writes is what a game engine needs; docs/wrinkle_maps.md describes it field by field, and
poses_json.py reads it.
"""
from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any, Sequence

import numpy as np

from ...native import kernels
from ..base.wording import UserError

FORMAT, FORMAT_VERSION = "rumple-wrinkle-maps", 1
KEYS_VERSION = 2  # of files with shape keys, so that engines that support only bones refuse them
TRACKED = ("HEAD", "TAIL", "BOTH")
MAPS = ("WRINKLES", "WHOLE")
MOST_POSES = kernels.MOST_POSES
_UNTRACKED = dict(HEAD=slice(3, 6), TAIL=slice(0, 3), KEY=slice(1, 6))
PACKED = 3  # masks in one vector attribute: EEVEE allows 14 attributes in a material, but a rig may have 16 poses
ROW = 4  # skin weights in a row of the table for the nodes: most vertices need only one row
LONGEST_NAME = 48  # bytes: Blender allows 63 for attribute names, and ours begin with rumple_pose_
GAINS = (0.1, 100.0)


@dataclass
class TrackedBone:
    """A bone whose position is compared. tracked: HEAD, TAIL or BOTH. group: bones of one group share their
    influences."""

    name: str
    tracked: str = "BOTH"
    group: str = ""


@dataclass
class TrackedKey:
    """A shape key whose value is compared. group: as for bones; a group may have both."""

    name: str
    group: str = ""


def _no_values() -> np.ndarray:
    return np.zeros(0, np.float32)


@dataclass
class ReferencePose:
    """A pose and the wrinkles that belong to it."""

    name: str
    bones: np.ndarray  # (b, 6) float32: head and tail of every tracked bone, space of the root bone
    map: str = ""  # file name of the tangent-space normal map; empty: none yet
    strength: float = 1.0  # 0..1
    muted: bool = False
    solo: bool = False
    keys: np.ndarray = field(default_factory=_no_values)  # (m,) float32: values of the tracked shape keys


def strengths(poses: Sequence[Any]) -> list[float]:
    """The factor on each pose's mask: 0 if the pose is muted, or another one is solo.

    poses: anything with strength, muted and solo.
    """
    solo = any(pose.solo for pose in poses)
    return [pose.strength if (pose.solo if solo else not pose.muted) else 0.0 for pose in poses]


@dataclass
class PoseRig:
    """All reference poses of one character: b tracked bones, in object units of the armature, and m shape keys.

    Both together are called elements, bones first.
    """

    name: str  # of the wrinkled object, for messages
    root: str  # the bone in whose space poses are compared, so its motion has no effect; empty: the armature itself
    bones: list[TrackedBone]
    neutral: np.ndarray  # (b, 6) float32: P_0
    poses: list[ReferencePose] = field(default_factory=list)
    maps: str = "WRINKLES"  # WHOLE: the maps contain the details of the neutral map, too
    neutral_map: str = ""
    gain: float = 1.0  # if larger than 1, wrinkles fade less with the distance from their bones
    keys: list[TrackedKey] = field(default_factory=list)
    neutral_keys: np.ndarray = field(default_factory=_no_values)  # (m,) float32

    @property
    def elements(self) -> list[TrackedBone | TrackedKey]:
        return [*self.bones, *self.keys]

    def check(self) -> None:
        """Raises UserError about the first error. The native library checks the positions of the bones."""
        _refuse_repeated(self.name, "bone", [bone.name for bone in self.bones])
        _refuse_repeated(self.name, "shape key", [key.name for key in self.keys])
        _refuse_repeated(self.name, "pose", [pose.name for pose in self.poses])
        if len(self.poses) > MOST_POSES:
            raise UserError(f"{self.name}: {len(self.poses)} reference poses; there may be {MOST_POSES}")
        for bone in self.bones:
            _refuse_unknown(self.name, f"bone {bone.name}: tracked", bone.tracked, TRACKED)
        _refuse_unknown(self.name, "maps", self.maps, MAPS)
        for pose in self.poses:
            if len(pose.name.encode()) > LONGEST_NAME:
                raise UserError(f"{self.name}: the name of pose {pose.name} is longer than {LONGEST_NAME} bytes: "
                                "shorten it")
            _refuse_outside(self.name, f"strength of pose {pose.name}", pose.strength, 0.0, 1.0)
        _refuse_outside(self.name, "gain", self.gain, *GAINS)

    def group_numbers(self) -> np.ndarray:
        """(b + m,) int32: number of each element's group, -1 for none."""
        numbers: dict[str, int] = {}
        return np.array([numbers.setdefault(element.group, len(numbers)) if element.group else -1
                         for element in self.elements], np.int32)

    def moves(self) -> np.ndarray:
        """(b + m, o) bool: which elements are compared in which pose. Raises UserError, see PoseComparison.build()."""
        return PoseComparison.build(self, SkinWeights.none()).moves

    def to_json(self) -> str:
        """The rig in the documented format. Numbers have enough digits to restore the same bits. Raises UserError."""
        bone_moves, key_moves = np.split(self.moves(), [len(self.bones)])
        poses = [dict(name=pose.name, map=pose.map, strength=strength,
                      bones=[dict(moves=bool(moved), **_points(place)) for moved, place in zip(column, pose.bones)])
                 for pose, strength, column in zip(self.poses, strengths(self.poses), bone_moves.T)]
        data = dict(
            format=FORMAT, version=KEYS_VERSION if self.keys else FORMAT_VERSION, name=self.name, root=self.root,
            maps=self.maps.lower(), neutral_map=self.neutral_map, gain=self.gain,
            bones=[dict(name=bone.name, tracked=bone.tracked.lower(), group=bone.group, **_points(place))
                   for bone, place in zip(self.bones, self.neutral)],
            poses=poses)
        if self.keys:
            data["keys"] = [dict(name=key.name, group=key.group, value=float(value))
                            for key, value in zip(self.keys, self.neutral_keys)]
            for entry, pose, column in zip(poses, self.poses, key_moves.T):
                entry["keys"] = [dict(moves=bool(moved), value=float(value))
                                 for moved, value in zip(column, pose.keys)]
        return json.dumps(data, indent=1) + "\n"


def _points(place: np.ndarray) -> dict[str, list[float]]:
    return dict(head=place[:3].tolist(), tail=place[3:].tolist())


def _refuse_repeated(owner: str, what: str, names: list[str]) -> None:
    seen: set[str] = set()
    for number, name in enumerate(names, 1):
        if not name:
            raise UserError(f"{owner}: {what} {number} has no name: give it one")
        if name in seen:
            raise UserError(f"{owner}: two {what}s are called {name}: rename one")
        seen.add(name)


def _refuse_unknown(owner: str, what: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise UserError(f"{owner}: {what}: expected one of {', '.join(known)}, got {value}")


def _refuse_outside(owner: str, what: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise UserError(f"{owner}: {what}: expected {low:g} to {high:g}, got {value:g}")


# ---------------------------------------------------------------- a frame
@dataclass
class SkinWeights:
    """Weights of the elements for each of n vertices. Weights of bones need not sum to 1."""

    start: np.ndarray  # (n + 1,) int32
    bone: np.ndarray  # (w,) int32: number of an element of the rig; -1: another bone
    weight: np.ndarray  # (w,) float32; of shape keys 0..1

    @classmethod
    def none(cls) -> "SkinWeights":
        """Weights for no vertices."""
        return cls(np.zeros(1, np.int32), np.zeros(0, np.int32), np.zeros(0, np.float32))


@dataclass
class Masks:
    """The masks of one frame. o poses, b bones, m shape keys, n vertices; all 0..1."""

    pose: np.ndarray  # (o, n) float32: where and how strongly each pose's map is visible
    influence: np.ndarray  # (b + m, o)
    rest: np.ndarray  # (b + m,)
    presence: np.ndarray  # (o,): how much of each pose is present as a whole


def packed(values: np.ndarray) -> list[np.ndarray]:
    """(o, n) as a list of (n, PACKED) float32, one for every PACKED poses."""
    count = len(values)
    packs = []
    for first in range(0, count, PACKED):
        pack = np.zeros((values.shape[1], PACKED), np.float32)
        pack[:, :min(PACKED, count - first)] = values[first:first + PACKED].T
        packs.append(pack)
    return packs


@dataclass
class WeightTable:
    """Skin weights in rows of ROW. Row v belongs to vertex v. If it is too short, further rows are at the end."""

    bone: np.ndarray  # (m, ROW) int32
    weight: np.ndarray  # (m, ROW) float32, 0 where a row ends early
    vertex: np.ndarray  # (m,) int32: the vertex that the row belongs to
    more: np.ndarray  # (d, n) int32: further rows of every vertex; -1: none


class PoseComparison:
    """A rig bound to a skin. Frames do not depend on each other, so nothing is stored."""

    def __init__(self, rig: PoseRig, model: Any) -> None:
        self.rig = rig
        self.model = model
        self.warnings: list[str] = []
        if model.unnormalised:
            self.warnings.append(f"{rig.name}: the skin weights of {model.unnormalised} vertices do not sum to 1 "
                                 "and are normalised")
        if model.unbound and rig.bones:
            self.warnings.append(f"{rig.name}: {model.unbound} vertices have no skin weight: no map shows there")

    @classmethod
    def build(cls, rig: PoseRig, weights: SkinWeights) -> "PoseComparison":
        """Raises UserError: see check(); also for bad positions and for a pose equal to another or to the neutral
        one."""
        rig.check()
        try:
            model = kernels.build_wrinkle_maps(
                [one.name for one in rig.elements], _tracked(rig), rig.group_numbers(),
                _flat(_joined(rig.neutral, rig.neutral_keys)),
                [(pose.name, _flat(_joined(pose.bones, pose.keys))) for pose in rig.poses], weights.start,
                weights.bone, weights.weight)
        except ValueError as error:
            raise UserError(f"{rig.name}: {error}") from error
        return cls(rig, model)

    @property
    def moves(self) -> np.ndarray:
        """(b + m, o) bool: which elements move in which pose."""
        return self.model.moves.astype(bool)

    # --- for the node tree, which computes the masks without Python (blender/nodes/maps_mask_tree.py)
    def neutral(self) -> np.ndarray:
        """(b + m, 6) float32: heads and tails; for shape keys the value, then zeros."""
        return _joined(self.rig.neutral, self.rig.neutral_keys)

    def slopes(self) -> np.ndarray:
        """(o, b + m, 6): displacement / |displacement|^2 of the tracked parts. The dot product of slope and (position -
        neutral), clamped to 0..1, is the influence."""
        displacements = np.array([_joined(pose.bones, pose.keys) for pose in self.rig.poses], float) - self.neutral()
        for number, tracked in enumerate(_tracked(self.rig)):
            if tracked != "BOTH":
                displacements[:, number, _UNTRACKED[tracked]] = 0.0
        squares = (displacements * displacements).sum(2, keepdims=True)
        moving = self.moves.T[:, :, None]
        return np.divide(displacements, squares, out=np.zeros_like(displacements), where=moving).astype(np.float32)

    def shares(self) -> np.ndarray:
        """(o, b + m): factor on the sum over an element's group that gives the mean over the elements that move; 1
        without a group."""
        group = self.rig.group_numbers()
        together = (group[:, None] == group) & (group >= 0) | np.eye(len(group), dtype=bool)
        return (1.0 / np.maximum(together @ self.moves.astype(int), 1)).T.astype(np.float32)

    def lifts(self, gain: float, strength: Sequence[float]) -> np.ndarray:
        """(o, n): the factor of gain and strengths on the weighted sum: reach' / reach of the native gained()."""
        reach = self.model.reach.T
        lifted = gain / (1.0 + (gain - 1.0) * np.minimum(reach, 1.0)) / np.maximum(reach, 1.0)
        return (np.array(strength, np.float32)[:, None] * lifted).astype(np.float32)

    def table(self) -> WeightTable:
        """The weights of the rig's elements, as the library uses them."""
        start, bone, weight = self.model.weights
        counts = np.diff(start)
        further = np.maximum((counts + ROW - 1) // ROW - 1, 0)
        first_further = len(counts) + np.cumsum(further) - further
        vertex = np.repeat(np.arange(len(counts)), counts)
        place = np.arange(len(bone)) - start[:-1][vertex]
        row = np.where(place < ROW, vertex, first_further[vertex] + place // ROW - 1)
        owner = np.concatenate([np.arange(len(counts)), np.repeat(np.arange(len(counts)), further)]).astype(np.int32)
        more = [np.where(further > d, first_further + d, -1) for d in range(further.max(initial=0))]
        table = WeightTable(np.zeros((len(owner), ROW), np.int32), np.zeros((len(owner), ROW), np.float32), owner,
                            np.array(more, np.int32).reshape(len(more), len(counts)))
        table.bone[row, place % ROW], table.weight[row, place % ROW] = bone, weight
        return table

    # --- computed by the library
    def frame(self, bones: np.ndarray, gain: float | None = None, strength: list[float] | None = None,
              keys: np.ndarray | None = None) -> Masks:
        """The masks of a frame. bones: (b, 6) float32, root space. keys: (m,) values. gain, strength (one per pose):
        those of the rig if None. Raises UserError."""
        keys = _no_values() if keys is None else keys
        gain = self.rig.gain if gain is None else gain
        strength = strengths(self.rig.poses) if strength is None else strength
        try:
            at = kernels.evaluate_wrinkle_maps(self.model, _flat(_joined(bones, keys)))
            masks = kernels.masks_of_wrinkle_maps(self.model, at, gain, strength)
        except ValueError as error:
            raise UserError(f"{self.rig.name}: {error}") from error
        return Masks(masks, at.pose, at.rest, kernels.presence_of_wrinkle_maps(self.model, at))


def _joined(bones: np.ndarray, keys: np.ndarray) -> np.ndarray:
    """(b + m, 6) float32: bones and keys in the format of the library."""
    values = np.zeros((len(keys), 6), np.float32)
    values[:, 0] = keys
    return np.concatenate([np.asarray(bones, np.float32).reshape(-1, 6), values])


def _tracked(rig: PoseRig) -> list[str]:
    """The library's name of what is tracked, for every element."""
    return [bone.tracked for bone in rig.bones] + ["KEY"] * len(rig.keys)


def bones_in_root_space(name: str, root: np.ndarray, bones: np.ndarray) -> np.ndarray:
    """(b, 6) float32 heads and tails, transformed into the space of the root bone, (4, 4). Raises UserError."""
    try:
        return kernels.bones_in_root_space(_flat(root), _flat(bones))
    except ValueError as error:
        raise UserError(f"{name}: {error}") from error


def _flat(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(values, np.float32)
