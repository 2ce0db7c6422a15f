# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the comparison of an object's bones and shape keys with its reference poses."""
from __future__ import annotations

import hashlib

import bpy
import numpy as np

from ...core.base.wording import UserError
from ...core.systems.poses import PoseComparison, PoseRig, SkinWeights
from ...native import NativeMissing
from ..objects import modifier
from . import materials, modifier as maps_modifier, rig as maps_rig, runtimes as maps_runtimes
from .runtimes import Runtime


def ensure(obj: bpy.types.Object, runtime: Runtime) -> None:
    """Build runtime.comparison for the current state of the object. It only reads, so it is allowed in any handler.
    Raises UserError."""
    if not obj.rumple_maps.poses:
        runtime.comparison, runtime.shape = None, ""
        runtime.notes = [f"{obj.name}: pose its armature and add a reference pose" if obj.find_armature() is not None
                         else f"{obj.name}: set its shape keys to a pose and add a reference pose"]
        return
    rig, notes = maps_rig.rig_of(obj)
    weights = maps_rig.weights_of(obj, rig)
    shape = _fingerprint(rig, weights, maps_rig.at_rest(obj, rig))
    if runtime.comparison is None or runtime.shape != shape:
        runtime.comparison, runtime.shape, runtime.seen = PoseComparison.build(rig, weights), shape, None
    runtime.notes = notes + runtime.comparison.warnings + (
        maps_rig.image_notes(obj) + materials.notes(obj) + _order_notes(obj))


def _fingerprint(rig: PoseRig, weights: SkinWeights, at_rest: np.ndarray) -> str:
    """Digest of the inputs of skin, skeleton and comparison, without gain, strengths and images."""
    digest = hashlib.sha1(repr((rig.root, rig.bones, rig.keys, [pose.name for pose in rig.poses])).encode())
    for values in (weights.start, weights.bone, weights.weight, at_rest, rig.neutral, rig.neutral_keys,
                   *(p.bones for p in rig.poses), *(p.keys for p in rig.poses)):
        digest.update(values.tobytes())
    return digest.hexdigest()


def _order_notes(obj: bpy.types.Object) -> list[str]:
    """Warnings if modifiers before or after ours change the mesh that the masks are for."""
    nodes_mod, stack = maps_modifier.find(obj), list(obj.modifiers)
    if nodes_mod is None:
        return []  # the poses stay when the modifier is removed, and a list may still draw their bars
    wrinkles = modifier.find(obj)
    if wrinkles is not None and stack.index(nodes_mod) < stack.index(wrinkles):
        return [f"{obj.name}: {wrinkles.name} is below {nodes_mod.name} in the stack, so the masks are lost: move it "
                f"above {nodes_mod.name}"]
    changer = next((m for m in stack[:stack.index(nodes_mod)] if m != wrinkles and modifier.changes_topology(m)), None)
    if changer is not None:
        return [f"{obj.name}: the modifier \"{changer.name}\" above {nodes_mod.name} changes the number of vertices, "
                f"so no map shows: move it below {nodes_mod.name}"]
    return []


def presence(obj: bpy.types.Object, pose: str) -> float:
    """How close the current pose is to a reference pose, 0..1. It is computed when a bar is drawn, not in every
    frame."""
    obj = obj.original
    runtime = maps_runtimes.of(obj)
    try:
        if runtime.comparison is None:
            ensure(obj, runtime)  # linked objects are not prepared by a rebuild
        if runtime.comparison is None:
            return 0.0
        rig = runtime.comparison.rig
        bones, keys = maps_rig.present(obj, rig)
        seen = bones.tobytes() + keys.tobytes()
        if runtime.seen is None or runtime.seen[0] != seen:
            runtime.seen = seen, runtime.comparison.frame(bones, keys=keys).presence
    except (UserError, NativeMissing):  # the panel has the message
        return 0.0
    names = [other.name for other in rig.poses]
    return float(runtime.seen[1][names.index(pose)]) if pose in names else 0.0
