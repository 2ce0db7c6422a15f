# SPDX-License-Identifier: GPL-3.0-or-later
"""The Wrinkle Maps' structural work. The rules that keep Blender alive are those of solve.py.

Nodes compute the masks of a frame (maps_mask_tree.py). Handlers only see to what the nodes cannot: weights, bones or
poses that were edited, and gain, strength, mute and solo where they change.
"""
from __future__ import annotations

import hashlib
from dataclasses import dataclass

import bpy
import numpy as np

from ... import native
from ...core.engine import Refused
from ...core.poses import PoseComparison, PoseRig, SkinWeights, strengths
from .. import compat, scheduler
from ..nodes import maps_shader
from ..nodes.maps_mask_tree import Shape
from ..objects import mesh_reader, messages, modifier, runtimes
from ..scheduler import LOCK
from . import hidden_meshes as maps_meshes, modifier as maps_modifier, rig as maps_rig


@dataclass
class Runtime(runtimes.Messages):
    """One object with Wrinkle Maps, outside the file."""

    comparison: PoseComparison | None = None
    shape: str = ""  # fingerprint of what it was made from
    stale: bool = True
    lifted: tuple | None = None  # gain and strengths that were written ...
    output_key: int = 0  # ... to which skin
    seen: tuple | None = None  # the present bones, and what presence was found for them


_runtimes: dict[int, Runtime] = {}


def runtime(obj: bpy.types.Object) -> Runtime:
    """Of an original object, made where there is none."""
    return _runtimes.setdefault(compat.session_key(obj), Runtime())


def message(obj: bpy.types.Object) -> str:
    """What is wrong with an object, in words; empty when nothing is."""
    entry = _runtimes.get(compat.session_key(obj))
    return "" if entry is None else entry.refusal or entry.message


def presence(obj: bpy.types.Object, pose: str) -> float:
    """How far the present pose has come to a reference pose, 0..1. Computed when a bar is drawn, not in frames."""
    obj = obj.original
    entry = runtime(obj)
    try:
        if entry.comparison is None:
            ensure_comparison(obj, entry)  # linked objects are not prepared
        if entry.comparison is None:
            return 0.0
        rig, armature = entry.comparison.rig, maps_rig.armature_of(obj)
        bones = maps_rig.present_bones(obj, armature, rig)
        if entry.seen is None or entry.seen[0] != bones.tobytes():
            entry.seen = bones.tobytes(), entry.comparison.frame(bones).presence
    except (Refused, native.NativeMissing):  # the panel has the message
        return 0.0
    names = [other.name for other in rig.poses]
    return float(entry.seen[1][names.index(pose)]) if pose in names else 0.0


def forget_all() -> None:
    _runtimes.clear()


def invalidate_output() -> None:
    """The skins may hold something else now: write gain and strengths again, whatever they are."""
    for entry in _runtimes.values():
        entry.lifted, entry.output_key = None, 0


def invalidate_all() -> None:
    """After undo and redo everything in the file may be another version of itself."""
    invalidate_output()
    for entry in _runtimes.values():
        entry.stale = True


# ---------------------------------------------------------------- what changed
def rig_changed(obj: bpy.types.Object) -> None:
    """Poses, bones or weights are others: compare anew when the hand rests."""
    if maps_modifier.find(obj) is not None:
        runtime(obj).stale = True
        scheduler.request(scheduler.DELAY)
        obj.update_tag()


def maps_changed(obj: bpy.types.Object) -> None:
    """The images are others, or how they are blended: the shader's nodes are made anew."""
    group = obj.rumple_maps.group
    if group is not None and compat.is_editable(group):
        maps_shader.fill(group, maps_rig.usable_images(obj), obj.rumple_maps.maps, obj.rumple_maps.uv_map)
    rig_changed(obj)


def note_updates(depsgraph: bpy.types.Depsgraph) -> None:
    """Edited meshes, painted weights and edited armatures are read again."""
    if scheduler.rendering() or not _runtimes:
        return
    touched = {compat.session_key(update.id.original) for update in depsgraph.updates
               if isinstance(update.id, (bpy.types.Mesh, bpy.types.Armature)) and update.is_updated_geometry}
    if not touched:
        return
    with LOCK:
        for obj, _ours in maps_modifier.mapped_objects():
            armature = obj.find_armature()
            if {compat.session_key(data) for data in (obj.data, armature and armature.data) if data} & touched:
                runtime(obj).stale = True
                scheduler.request(scheduler.DELAY)


# ---------------------------------------------------------------- structural work
def sync() -> None:
    """Bring every object in order: trees, shared skins and groups, comparisons, leftovers."""
    objects = list(maps_modifier.mapped_objects())
    present = {compat.session_key(obj) for obj, _ in objects}
    for key in [key for key in _runtimes if key not in present]:
        del _runtimes[key]
    held = {hidden for _, ours in objects for hidden in maps_modifier.hidden(ours)}
    objects = [(obj, ours) for obj, ours in objects if compat.is_editable(obj)]  # linked ones cannot be written
    _split_shared(objects)
    for obj, ours in objects:
        if runtime(obj).stale or _is_behind_others(obj, ours):
            prepare(obj, ours)
    for obj in bpy.data.objects:
        note_method(obj)
    _tidy(held | {hidden for _, ours in objects for hidden in maps_modifier.hidden(ours)})


def note_method(obj: bpy.types.Object) -> None:
    """The method is MAPS where there are no other wrinkles."""
    method = obj.rumple.method
    if obj.type != "MESH" or not compat.is_editable(obj) or (method == "NONE" and not len(obj.modifiers)):
        return
    if maps_modifier.find(obj) is not None:
        if method != "MAPS" and modifier.find(obj) is None:
            obj.rumple.method = "MAPS"
    elif method == "MAPS":
        obj.rumple.method = "NONE"


def _wrinkles_in_front(obj: bpy.types.Object, ours: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The output object of a Wrinkle Mesh, Field or Paths in front of the maps."""
    wrinkles, stack = modifier.find(obj), list(obj.modifiers)
    if wrinkles is None or stack.index(wrinkles) > stack.index(ours):
        return None
    return modifier.output_object(wrinkles)


def _is_behind_others(obj: bpy.types.Object, ours: bpy.types.NodesModifier) -> bool:
    """Other wrinkles came, went or were made anew since the modifier was prepared."""
    return _wrinkles_in_front(obj, ours) != maps_modifier.wrinkles(ours)


def prepare(obj: bpy.types.Object, ours: bpy.types.NodesModifier) -> None:
    """Make comparison, tree, skin and skeleton what they should be. What is wrong becomes the object's message."""
    entry = runtime(obj)
    entry.stale = False
    try:
        _prepare(obj, ours, entry)
        messages.set_build_error(entry, "")
    except Refused as error:
        messages.set_build_error(entry, str(error))
        maps_modifier.connect(obj, ours, None, None, _wrinkles_in_front(obj, ours))  # no masks rather than wrong ones
    except native.NativeMissing as error:  # the nodes go on without
        messages.set_build_error(entry, str(error))
    except Exception as error:  # a message on the panel, never a traceback
        messages.set_build_error(entry, messages.unexpected(obj, error))


def _prepare(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime) -> None:
    ensure_comparison(obj, entry)
    comparison, front = entry.comparison, _wrinkles_in_front(obj, ours)
    if comparison is None:
        maps_modifier.fill(ours.node_group, Shape())
        maps_modifier.connect(obj, ours, None, None, front)
        return
    table = comparison.table()
    maps_modifier.fill(ours.node_group, Shape(
        tuple(pose.name for pose in comparison.rig.poses), len(comparison.rig.bones), 1 + len(table.more),
        bool((comparison.rig.group_numbers() >= 0).any()), front is not None))
    armature = maps_rig.armature_of(obj)
    skin, skeleton = maps_modifier.skin(ours), maps_modifier.skeleton(ours)
    if not maps_meshes.made_from(skin, entry.shape):
        skin = maps_meshes.new_skin(obj.name, comparison, entry.shape)
        entry.lifted = None  # whatever its key: in 3.4 that is an address, which the former skin may have had
    if not maps_meshes.made_from(skeleton, entry.shape) or \
            maps_meshes.armature_of(skeleton) != armature:
        skeleton = maps_meshes.new_skeleton(obj.name, comparison, armature, entry.shape)
    _lift(obj, skin, entry, obj.rumple_maps)
    maps_modifier.connect(obj, ours, skin, skeleton, front)


def _lift(obj: bpy.types.Object, skin: bpy.types.Object, entry: Runtime, settings: bpy.types.PropertyGroup) -> None:
    """Gain, strengths, mute and solo, where the skin has others. A write costs another evaluation."""
    wanted, key = (settings.gain, tuple(strengths(settings.poses))), compat.session_key(skin.data)
    if wanted != entry.lifted or key != entry.output_key:
        maps_meshes.write_weights(skin, entry.comparison, *wanted)
        entry.lifted, entry.output_key = wanted, key


def ensure_comparison(obj: bpy.types.Object, entry: Runtime) -> None:
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


def _split_shared(objects: list[tuple[bpy.types.Object, bpy.types.NodesModifier]]) -> None:
    """Duplicates share tree, skin and shader group with their original until they get their own; overrides, with the
    linked file. A skeleton is never written to: it may be shared until the poses differ."""
    seen: set[bpy.types.ID] = set()
    for obj, ours in objects:
        if ours.node_group in seen or not compat.is_editable(ours.node_group):
            ours.node_group = ours.node_group.copy()
        skin = maps_modifier.skin(ours)
        if skin is not None and skin in seen:
            maps_modifier.connect(obj, ours, None, maps_modifier.skeleton(ours), maps_modifier.wrinkles(ours))
            runtime(obj).stale = True
        group = obj.rumple_maps.group
        if group is not None and group in seen:
            obj.rumple_maps.group = group.copy()  # its materials show the original's maps until it has its own
        seen |= {ours.node_group, maps_modifier.skin(ours), obj.rumple_maps.group}


def _tidy(held: set[bpy.types.Object | None]) -> None:
    """Skins and skeletons whose modifier was removed or applied by Blender's own buttons."""
    candidates = {o for o in bpy.data.objects if maps_meshes.KEY in o} - held
    if candidates:
        for candidate, users in bpy.data.user_map(subset=candidates).items():
            if not users:
                modifier.delete_hidden(candidate)


# ---------------------------------------------------------------- the frame
def process(depsgraph: bpy.types.Depsgraph) -> None:
    """Gain and strengths of what this depsgraph shows. Never raises."""
    if scheduler.rendering() and depsgraph.mode == "VIEWPORT":
        return
    if scheduler.is_suspended():
        return
    with LOCK:
        objects = list(maps_modifier.mapped_objects())
        for obj, ours in objects:
            if compat.is_editable(obj) and not runtime(obj).stale and _is_behind_others(obj, ours):
                runtime(obj).stale = True
                scheduler.request()
        if scheduler.allowed_now() and any(runtime(obj).stale and compat.is_editable(obj) for obj, _ in objects):
            sync()
        for obj, ours in objects:
            _process_guarded(obj, ours, depsgraph)


def _process_guarded(obj: bpy.types.Object, ours: bpy.types.NodesModifier, depsgraph: bpy.types.Depsgraph) -> None:
    entry = runtime(obj)
    try:
        _process(obj, ours, entry, depsgraph)
        messages.set_frame_error(entry, "")
    except (Refused, native.NativeMissing) as error:
        messages.set_frame_error(entry, str(error))
    except Exception as error:  # handlers must not throw: the last good masks stay, the panel says why
        messages.set_frame_error(entry, messages.unexpected(obj, error))


def _process(obj: bpy.types.Object, ours: bpy.types.NodesModifier, entry: Runtime, depsgraph: bpy.types.Depsgraph
             ) -> None:
    if entry.comparison is None or entry.refusal or obj.mode in mesh_reader.BUSY_MODES:
        return
    if len(obj.data.vertices) != entry.comparison.model.vertex_count:
        entry.stale = True
        scheduler.request()  # the topology was edited
        return
    skin = maps_modifier.skin(ours)
    if maps_meshes.made_from(skin, entry.shape):
        # The evaluated copy: animated settings are right there, in renders too.
        _lift(obj, skin, entry, obj.evaluated_get(depsgraph).rumple_maps)
