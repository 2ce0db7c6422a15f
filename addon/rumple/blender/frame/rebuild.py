# SPDX-License-Identifier: GPL-3.0-or-later
"""Structural work: fine meshes, output objects, duplicates, leftovers.

It creates and removes data-blocks, so it runs outside of handlers: in operators, in a timer of the window, and in
background mode directly while nothing renders. It also runs before a render in the main thread, but never in the thread
of an F12 job. Other modules request it from scheduler.py.
"""
from __future__ import annotations

import bpy

from ...core.mesh.shown_mesh import ShownMesh, ViewportMesh
from .. import compat, scheduler
from ..nodes import field_profile, field_shader, wrinkle_tree
from ..nodes.output_flags import Flag, set_flag
from ..objects import (applied_transforms, bodies, clip_range, duplicates, evaluator, held_by_others, incoming_mesh,
                       kept_lists, mesh_reader, messages, modifier, output_mesh, own_mesh_place, rest_position,
                       runtimes, units, viewport_mesh)
from ..objects.runtimes import Runtime
from . import clip_status, path_curves


def sync_all() -> None:
    """Update every wrinkled object: node groups, shared output objects, outdated meshes, leftovers."""
    kept_lists.forget_all()
    for group in list(bpy.data.node_groups):
        if wrinkle_tree.is_ours(group):
            with messages.console_errors(group.name):
                wrinkle_tree.upgrade(group)
    objects = list(modifier.wrinkled_objects())
    runtimes.forget_all_but(obj for obj, _ in objects)
    _split_shared_outputs(objects)
    for _obj, nodes_mod in objects:
        with messages.console_errors("hidden objects"):
            modifier.take_out_of_scenes((*modifier.outputs(nodes_mod), modifier.cache_object(nodes_mod)))
    with messages.console_errors("bodies"):
        duplicates.split_worn_over([obj for obj, _ in objects])
        bodies.connect_all()
        bodies.forget_removed()
    for obj, _nodes_mod in objects:
        with messages.console_errors("frame range"):
            clip_range.follow(obj)
    for obj, nodes_mod in objects:
        if runtimes.of(obj).stale and not build_in_thread(obj, nodes_mod):
            prepare(obj, nodes_mod)
    with messages.console_errors("what was removed"):
        _tidy_removed({obj.name_full for obj, _ in objects})
    with messages.console_errors("path curves"):
        path_curves.sync([obj for obj, _ in modifier.wrinkled_objects()])


def build_in_thread(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Let a thread build its fine mesh while the window shows the former one or the coarse mesh. Returns whether a
    thread builds it: not if this is not allowed now."""
    if not scheduler.may_build_in_thread() or modifier.is_baked(nodes_mod) or mesh_reader.is_busy(obj):
        return False
    try:
        building = evaluator.begin(obj, runtimes.of(obj))
    except Exception:  # prepare() reports this error
        return False
    if building is not None:
        scheduler.add_build(building)
    return building is not None


def prepare(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Rebuild the fine mesh and the output object if necessary. Returns whether something was rebuilt.

    Never raises: errors become the object's message, and the last valid mesh stays.
    """
    if mesh_reader.is_busy(obj):
        return False
    runtime = runtimes.of(obj)
    runtime.stale = False
    runtime.seen.groups = [group.name for group in obj.vertex_groups]
    with messages.build_errors(obj, runtime):
        changed = _prepare(obj, nodes_mod, runtime)
        rest_position.carry(obj, nodes_mod)
        messages.set_build_error(runtime, runtime.bake_note)
        return changed
    return False


def _prepare(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, runtime: Runtime) -> bool:
    method = modifier.system(nodes_mod).method
    if compat.is_editable(obj) and obj.rumple.method != method:
        obj.rumple.method = method  # the modifier is from Copy Modifiers or an older file
    own_mesh_place.keep(obj)
    baked = modifier.is_baked(nodes_mod) and modifier.output_object(nodes_mod) is not None
    changed = _take_incoming(obj, runtime) if not baked or _is_seen_edited(obj, runtime) else ""
    runtime.bake_note = ""
    if baked:
        runtime.bake_note = clip_status.check(obj, modifier.output_object(nodes_mod))
        if not _is_edited(obj, nodes_mod):
            return False  # the clip depends on the unchanged output object
    if method == "FIELD":
        _update_profile(obj, runtime)
    applied_transforms.follow(obj)
    former = runtime.evaluator
    inherited = output_mesh.Inherited(obj, evaluator.source_of(obj))
    evaluator.ensure(obj, runtime, meanwhile=inherited.read)
    if changed:
        runtime.notes.append(changed)
    if runtime.evaluator is not former:
        for one in modifier.to_tag(obj):
            one.update_tag()  # it may be unchanged, but this evaluator has solved nothing yet
    former_output, former_viewport = modifier.output_object(nodes_mod), modifier.viewport_output(nodes_mod)
    count = len(incoming_mesh.of(obj).vertices)
    shown = count if former_output is None else len(former_output.data.vertices)
    filled = [_filled(former, fine, inherited) for former, fine in zip(
        (former_output, former_viewport), viewport_mesh.solved_for(nodes_mod, runtime.evaluator))]
    viewport_output = filled[1][0] if len(filled) == 2 else None
    if (not any(changed for _, changed in filled) and modifier.coarse_vertices(nodes_mod) == count
            and viewport_output == former_viewport):
        return False
    modifier.set_output_object(nodes_mod, filled[0][0], count)
    modifier.set_viewport_output(nodes_mod, viewport_output)
    runtime.invalidate_output()
    if len(filled[0][0].data.vertices) != shown:
        held_by_others.note_other_points(obj)
    return True


def _is_seen_edited(obj: bpy.types.Object, runtime: Runtime) -> bool:
    """Whether its mesh or the modifiers in front are others than at the last look. At the first look this is not known:
    while a file with many clips is opened, nothing is evaluated for them."""
    seen, now = runtime.seen, (incoming_mesh.stack_fingerprint(obj), len(obj.data.vertices))
    if seen.own_vertices < 0:
        seen.stack, seen.own_vertices = now
    return (seen.stack, seen.own_vertices) != now


def _is_edited(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier) -> bool:
    """Whether another number of vertices arrives than its output object was made for, so that nothing but live folds
    can be shown."""
    return len(incoming_mesh.of(obj).vertices) != modifier.coarse_vertices(nodes_mod)


def _filled(output_obj: bpy.types.Object | None, fine: ShownMesh,
            inherited: output_mesh.Inherited) -> tuple[bpy.types.Object, bool]:
    """An output object with the fine mesh, and whether it was created or changed."""
    if output_obj is None or output_obj.type != "MESH" or not _is_local(output_obj):
        output_obj = output_mesh.make(fine, inherited)
        output_obj[output_mesh.KEY] = True
        if isinstance(fine, ViewportMesh):
            set_flag(output_obj, Flag.RENDER_MESH, True)  # until it is known that nothing depends on it
        return output_obj, True
    if not output_mesh.is_embedding_of(output_obj.data, fine):
        output_mesh.fill(output_obj, fine, inherited)
        return output_obj, True
    return output_obj, output_mesh.carry_changes(output_obj, fine, inherited)


def _take_incoming(obj: bpy.types.Object, runtime: Runtime) -> str:
    """Update the incoming mesh. Returns a message if it has other vertices although nobody edited it."""
    before, stack = len(incoming_mesh.of(obj).vertices), incoming_mesh.stack_fingerprint(obj)
    incoming_mesh.update(obj)
    count, own, seen = len(incoming_mesh.of(obj).vertices), len(obj.data.vertices), runtime.seen
    edited = seen.stack != stack or seen.own_vertices != own
    seen.stack, seen.own_vertices = stack, own
    if count == before or edited or incoming_mesh.is_own(obj):
        return ""
    return (f"{obj.name}: the modifier \"{modifier.topology_changer_before(obj).name}\" above the wrinkles makes "
            f"{count} vertices in frame {units.scene_of(obj).frame_current}, {before} before: the wrinkles start again "
            "there")


def _update_profile(obj: bpy.types.Object, runtime: Runtime) -> None:
    """Give the materials and the fine mesh the chosen or drawn profile."""
    if obj.rumple.field.profile == "CURVE":
        field_profile.ensure(obj)
        runtime.paint.values = None
        for one in modifier.to_tag(obj):
            one.update_tag()
    for material in field_shader.materials_of(obj):
        field_shader.set_profile(material, obj)
    field_shader.drop_orphans()


def _is_local(output_obj: bpy.types.Object) -> bool:
    return compat.is_editable(output_obj) and compat.is_editable(output_obj.data)


# ---------------------------------------------------------------- duplicates and leftovers
def _split_shared_outputs(objects: list[tuple[bpy.types.Object, bpy.types.NodesModifier]]) -> None:
    """Give every object its own local output object: duplicates share one, and linked ones cannot be written."""
    seen: set[int] = set()
    for obj, nodes_mod in objects:
        with messages.build_errors(obj, runtimes.of(obj)):
            _split_shared_output(obj, nodes_mod, seen)


def _split_shared_output(obj: bpy.types.Object, nodes_mod: bpy.types.NodesModifier, seen: set[int]) -> None:
    output_obj = modifier.output_object(nodes_mod)
    if output_obj is None or output_obj.type != "MESH":
        runtimes.of(obj).stale = True
        return
    if any(compat.session_key(output) in seen or not _is_local(output) for output in modifier.outputs(nodes_mod)):
        output_obj = output_mesh.copy_for(obj, output_obj)
        output_obj[output_mesh.KEY] = True
        modifier.set_output_object(nodes_mod, output_obj, modifier.coarse_vertices(nodes_mod))
        modifier.set_viewport_output(nodes_mod, None)  # it is rebuilt
        runtimes.of(obj).stale = True
        runtimes.of(obj).invalidate_output()
    seen.update(compat.session_key(output) for output in modifier.outputs(nodes_mod))


def _tidy_removed(wrinkled: set[str]) -> None:
    """Clean up after modifiers that were applied or removed with Blender's own buttons."""
    for obj in bpy.data.objects:
        if obj.type != "MESH" or obj.name_full in wrinkled or not compat.is_editable(obj):
            continue
        if obj.rumple.method not in ("NONE", "MAPS"):  # maps/rebuild.py handles those
            drop_traces(obj)
    modifier.drop_unused_groups()
    drop_orphan_outputs()
    field_profile.drop_orphans()


def drop_orphan_outputs() -> None:
    """Remove output and cache objects without an owner, also those that Blender has linked to a scene: Make Local does
    so with objects that it left without users. The user map is used, because 5.2 still counts applied modifiers as
    users."""
    hidden = (modifier.output_object, modifier.viewport_output, modifier.cache_object)
    in_use = {of(nodes_mod) for _, nodes_mod in modifier.wrinkled_objects() for of in hidden}
    candidates = {o for o in bpy.data.objects if output_mesh.KEY in o} - in_use
    if not candidates:
        return  # the user map visits the whole file
    modifier.take_out_of_scenes(candidates)
    for candidate, users in bpy.data.user_map(subset=candidates).items():
        if not users:
            modifier.delete_hidden(candidate)


def drop_traces(obj: bpy.types.Object) -> None:
    """Remove what the wrinkles of an object leave when their modifier is removed. Settings and paint stay."""
    if obj.rumple.method == "FIELD":
        field_shader.unshade_object(obj, [o for o, _ in modifier.wrinkled_objects() if o.rumple.method == "FIELD"])
    obj.rumple.method = "NONE"
    incoming_mesh.forget(obj)
    drop_internal_attributes(obj)


def drop_internal_attributes(obj: bpy.types.Object) -> None:
    """Remove Rumple's internal attributes from a coarse (or applied) mesh. Attributes for shaders stay on applied
    meshes."""
    mesh = obj.data
    if not compat.is_editable(mesh) or obj.mode == "EDIT":
        return
    shared = any(other != obj and other.data == mesh for other, _ in modifier.wrinkled_objects())
    internal = (*wrinkle_tree.OUTPUT_ONLY, wrinkle_tree.BASE_POSITION, wrinkle_tree.BASE_INDEX,
                wrinkle_tree.REST_POSITION, wrinkle_tree.REST_BASIS)
    for name in internal:
        if name in mesh.attributes and not shared:
            mesh.attributes.remove(mesh.attributes[name])


def remove_all(obj: bpy.types.Object) -> None:
    """Remove modifier, output object, node group (if it was the last one), attributes and stored frames. The settings
    stay."""
    with scheduler.LOCK:
        for child in path_curves.of(obj):
            path_curves.remove(child)
        modifier.remove(obj)
        drop_traces(obj)
        drop_orphan_outputs()
        runtimes.forget(obj)
