# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of an object's bones with its reference poses, built from armature, poses and skin weights."""
from __future__ import annotations

import hashlib

import bpy
import numpy as np

from ...core.engine import Refused
from ...core.poses import PoseComparison, PoseRig, SkinWeights
from ...native import NativeMissing
from ..objects import modifier
from . import modifier as maps_modifier, rig as maps_rig, runtimes as maps_runtimes
from .runtimes import Runtime


def ensure(obj: bpy.types.Object, entry: Runtime) -> None:
    """Make entry.comparison for the object as it is. Reads only: allowed in any handler. Raises Refused."""
    if not obj.rumple_maps.poses:
        entry.comparison, entry.shape = None, ""
        entry.notes = [f"{obj.name}: pose its armature and add a reference pose"]
        return
    rig, notes = maps_rig.rig_of(obj)
    weights = maps_rig.weights_of(obj, rig)
    shape = _fingerprint(rig, weights, maps_rig.bone_lengths(obj, rig))
    if entry.comparison is None or entry.shape != shape:
        entry.comparison, entry.shape, entry.seen = PoseComparison.build(rig, weights), shape, None
    entry.notes = notes + entry.comparison.warnings + maps_rig.image_notes(obj) + _order_notes(obj)


def _fingerprint(rig: PoseRig, weights: SkinWeights, lengths: np.ndarray) -> str:
    """Of what skin, skeleton and comparison are made from: no gain, strengths and images."""
    digest = hashlib.sha1(repr((rig.root, rig.bones, [pose.name for pose in rig.poses])).encode())
    for values in (weights.start, weights.bone, weights.weight, lengths, rig.neutral, *(p.bones for p in rig.poses)):
        digest.update(values.tobytes())
    return digest.hexdigest()


def _order_notes(obj: bpy.types.Object) -> list[str]:
    """Where the mesh that the masks are for is not the one that comes in, or does not come out."""
    ours, stack = maps_modifier.find(obj), list(obj.modifiers)
    wrinkles = modifier.find(obj)
    if wrinkles is not None and stack.index(ours) < stack.index(wrinkles):
        return [f"{obj.name}: {wrinkles.name} stands behind {ours.name} and drops the masks: move it in front"]
    changer = next((m for m in stack[:stack.index(ours)] if m != wrinkles and modifier.changes_topology(m)), None)
    if changer is not None:
        return [f"{obj.name}: the modifier \"{changer.name}\" in front of {ours.name} changes the number of vertices: "
                "no map shows. Move it behind"]
    return []


def presence(obj: bpy.types.Object, pose: str) -> float:
    """How far the present pose has come to a reference pose, 0..1. Computed when a bar is drawn, not in frames."""
    obj = obj.original
    entry = maps_runtimes.of(obj)
    try:
        if entry.comparison is None:
            ensure(obj, entry)  # linked objects are not prepared
        if entry.comparison is None:
            return 0.0
        rig, armature = entry.comparison.rig, maps_rig.armature_of(obj)
        bones = maps_rig.present_bones(obj, armature, rig)
        if entry.seen is None or entry.seen[0] != bones.tobytes():
            entry.seen = bones.tobytes(), entry.comparison.frame(bones).presence
    except (Refused, NativeMissing):  # the panel has the message
        return 0.0
    names = [other.name for other in rig.poses]
    return float(entry.seen[1][names.index(pose)]) if pose in names else 0.0
