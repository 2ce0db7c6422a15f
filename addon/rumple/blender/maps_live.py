# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Maps' structural work and their frames. The rules that keep Blender alive are those of live.py.

A frame depends on the present bones and on nothing before it: no history, and any order of frames is right.
"""
from __future__ import annotations

import hashlib
from dataclasses import dataclass

import bpy

from .. import native
from ..core.engine import Refused
from ..core.poses import Masks, PoseComparison, PoseRig, SkinWeights, strengths
from . import maps_nodes, maps_rig, maps_tree, modifier, registry, structure, versions
from .registry import LOCK

_BUSY_MODES = frozenset(("EDIT", "SCULPT"))


@dataclass
class Runtime(registry.Messages):
    """One object with Wrinkle Maps, outside the file."""

    comparison: PoseComparison | None = None
    shape: str = ""  # fingerprint of what it was made from
    stale: bool = True
    inputs: tuple | None = None  # what the carrier's masks were made from
    carrier_key: int = 0  # ... which carrier
    masks: Masks | None = None


_runtimes: dict[int, Runtime] = {}


def runtime(obj: bpy.types.Object) -> Runtime:
    """Of an original object, made where there is none."""
    return _runtimes.setdefault(versions.session_key(obj), Runtime())


def message(obj: bpy.types.Object) -> str:
    """What is wrong with an object, in words; empty when nothing is."""
    entry = _runtimes.get(versions.session_key(obj))
    return "" if entry is None else entry.refusal or entry.message


def presence(obj: bpy.types.Object, pose: str) -> float:
    """How far the present pose has come to a reference pose, 0..1."""
    entry = _runtimes.get(versions.session_key(obj.original))
    if entry is None or entry.comparison is None or entry.masks is None:
        return 0.0
    names = [other.name for other in entry.comparison.rig.poses]
    return float(entry.masks.presence[names.index(pose)]) if pose in names else 0.0


def forget_all() -> None:
    _runtimes.clear()


def forget_written() -> None:
    """The carriers may hold something else now: write the next masks whatever they are."""
    for entry in _runtimes.values():
        entry.inputs, entry.carrier_key = None, 0


def doubt_all() -> None:
    """After undo and redo everything in the file may be another version of itself."""
    forget_written()
    for entry in _runtimes.values():
        entry.stale = True


# ---------------------------------------------------------------- what changed
def rig_changed(obj: bpy.types.Object) -> None:
    """Poses, bones or weights are others: compare anew when the hand rests."""
    if maps_tree.find(obj) is not None:
        runtime(obj).stale = True
        structure.request(structure.SETTLE_SECONDS)
        obj.update_tag()


def maps_changed(obj: bpy.types.Object) -> None:
    """The images are others, or how they are blended: the shader's nodes are made anew."""
    group = obj.rumple_maps.group
    if group is not None and versions.is_editable(group):
        maps_nodes.fill(group, maps_rig.usable_images(obj), obj.rumple_maps.maps, obj.rumple_maps.uv_map)
    rig_changed(obj)


def note_updates(depsgraph: bpy.types.Depsgraph) -> None:
    """Edited meshes, painted weights and edited armatures are read again."""
    if structure.rendering() or not _runtimes:
        return
    touched = {versions.session_key(update.id.original) for update in depsgraph.updates
               if isinstance(update.id, (bpy.types.Mesh, bpy.types.Armature)) and update.is_updated_geometry}
    if not touched:
        return
    with LOCK:
        for obj, _ours in maps_tree.mapped_objects():
            armature = obj.find_armature()
            if {versions.session_key(data) for data in (obj.data, armature and armature.data) if data} & touched:
                runtime(obj).stale = True
                structure.request(structure.SETTLE_SECONDS)


# ---------------------------------------------------------------- structural work
def settle() -> None:
    """Bring every object in order: trees, shared carriers and groups, comparisons, leftovers."""
    objects = list(maps_tree.mapped_objects())
    present = {versions.session_key(obj) for obj, _ in objects}
    for key in [key for key in _runtimes if key not in present]:
        del _runtimes[key]
    held = {maps_tree.carrier(ours) for _, ours in objects}
    objects = [(obj, ours) for obj, ours in objects if versions.is_editable(obj)]  # linked ones cannot be written
    _split_shared(objects)
    for obj, ours in objects:
        if runtime(obj).stale:
            prepare(obj, ours)
    _tidy(held | {maps_tree.carrier(ours) for _, ours in objects})


def prepare(obj: bpy.types.Object, ours: bpy.types.NodesModifier) -> None:
    """Make comparison, tree and carrier what they should be. What is wrong becomes the object's message."""
    entry = runtime(obj)
    entry.stale = False
    try:
        _prepare(obj, ours, entry)
        registry.refuse(entry, "")
    except (Refused, native.NativeMissing) as error:
        registry.refuse(entry, str(error))
    except Exception as error:  # a message on the panel, never a traceback
        registry.refuse(entry, structure.unexpected(obj, error))


def _prepare(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime) -> None:
    if versions.is_editable(ours.node_group):
        maps_tree.fill(ours.node_group, [pose.name for pose in obj.rumple_maps.poses])
    held, count = maps_tree.carrier(ours), len(obj.data.vertices)
    if held is None or not versions.is_editable(held) or len(held.data.vertices) != count \
            or maps_tree.vertices(ours) != count:
        maps_tree.give_carrier(obj, ours, count)
        entry.inputs = None
    ensure_comparison(obj, entry)


def ensure_comparison(obj: bpy.types.Object, entry: Runtime) -> None:
    """Make entry.comparison for the object as it is. Reads only: allowed in any handler. Raises Refused."""
    if not obj.rumple_maps.poses:
        entry.comparison, entry.shape, entry.masks = None, "", None
        entry.notes = [f"{obj.name}: pose its armature and add a reference pose"]
        return
    rig, notes = maps_rig.rig_of(obj)
    weights = maps_rig.weights_of(obj, rig)
    shape = _fingerprint(rig, weights)
    if entry.comparison is None or entry.shape != shape:
        entry.comparison, entry.shape, entry.inputs = PoseComparison.build(rig, weights), shape, None
    entry.notes = notes + entry.comparison.warnings + maps_rig.image_notes(obj)


def _fingerprint(rig: PoseRig, weights: SkinWeights) -> str:
    digest = hashlib.sha1(rig.to_json().encode())
    for values in (weights.start, weights.bone, weights.weight):
        digest.update(values.tobytes())
    return digest.hexdigest()


def _split_shared(objects: list[tuple[bpy.types.Object, bpy.types.NodesModifier]]) -> None:
    """Duplicates share tree, carrier and shader group with their original until they get their own."""
    seen: set[bpy.types.ID] = set()
    for obj, ours in objects:
        if ours.node_group in seen:
            ours.node_group = ours.node_group.copy()
        held = maps_tree.carrier(ours)
        if held is not None and held in seen:
            maps_tree.give_carrier(obj, ours, len(obj.data.vertices))
            runtime(obj).stale = True
        group = obj.rumple_maps.group
        if group is not None and group in seen:
            obj.rumple_maps.group = group.copy()  # its materials show the original's maps until it has its own
        seen |= {ours.node_group, maps_tree.carrier(ours), obj.rumple_maps.group}


def _tidy(held: set[bpy.types.Object | None]) -> None:
    """Carriers whose modifier was removed or applied by Blender's own buttons."""
    candidates = {o for o in bpy.data.objects if maps_tree.CARRIER_KEY in o} - held
    if candidates:
        for candidate, users in bpy.data.user_map(subset=candidates).items():
            if not users:
                modifier.delete_hidden(candidate)


# ---------------------------------------------------------------- the frame
def process(depsgraph: bpy.types.Depsgraph) -> None:
    """The masks of what this depsgraph shows. Never raises."""
    if structure.rendering() and depsgraph.mode == "VIEWPORT":
        return
    if structure.is_half_done():
        return
    with LOCK:
        objects = list(maps_tree.mapped_objects())
        if structure.allowed_now() and any(runtime(obj).stale and versions.is_editable(obj) for obj, _ in objects):
            settle()
        for obj, ours in objects:
            _process_guarded(obj, ours, depsgraph)


def _process_guarded(obj: bpy.types.Object, ours: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph) -> None:
    entry = runtime(obj)
    try:
        _process(obj, ours, entry, depsgraph)
        registry.say(entry, "")
    except (Refused, native.NativeMissing) as error:
        registry.say(entry, str(error))
    except Exception as error:  # handlers must not throw: the last good masks stay, the panel says why
        registry.say(entry, structure.unexpected(obj, error))


def _process(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime, depsgraph: bpy.types.Depsgraph
             ) -> None:
    held = maps_tree.carrier(ours)
    armature = obj.find_armature()
    if held is None or not versions.is_editable(held) or entry.refusal or obj.mode in _BUSY_MODES:
        return
    if entry.comparison is None or entry.stale:  # the timer's turn comes later; reading is allowed here
        ensure_comparison(obj, entry)
    if entry.comparison is None or armature is None:
        return
    if len(obj.data.vertices) != entry.comparison.model.vertex_count:
        entry.stale = True
        structure.request()  # the topology was edited
        return
    evaluated, settings = armature.evaluated_get(depsgraph), obj.evaluated_get(depsgraph).rumple_maps
    bones = maps_rig.present_bones(obj, evaluated, entry.comparison.rig)
    # The evaluated copy: animated settings are right there, in renders too.
    inputs = (bones.tobytes(), settings.gain, tuple(strengths(settings.poses)))
    key = versions.session_key(held.data)
    if inputs == entry.inputs and key == entry.carrier_key:
        return
    entry.masks = entry.comparison.frame(bones, inputs[1], list(inputs[2]))
    if ours.show_render if depsgraph.mode == "RENDER" else ours.show_viewport:  # else for the bars only
        maps_tree.write(held, entry.masks.packed())
        entry.inputs, entry.carrier_key = inputs, key
