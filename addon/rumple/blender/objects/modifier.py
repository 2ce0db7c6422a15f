# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier, "Wrinkle Mesh" or another system: adding, finding and removing it, and its output object."""
from __future__ import annotations

from typing import Iterable, Iterator

import bpy

from ...core.clip_manifest import Manifest
from ...core.systems import SYSTEMS, System
from .. import compat
from ..nodes import wrinkle_tree
from ..nodes.modifier_inputs import get_input, set_input
from ..nodes.output_flags import Flag, change_flag, is_set
from .kept_lists import ModifiedObjects

CACHE_NAME = "Rumple Bake"  # the MESH_CACHE modifier on the cache object of a baked clip

# Modifiers that move points and keep their number: the wrinkles stand behind the last of them.
DEFORMING = frozenset((
    "ARMATURE", "CAST", "CLOTH", "CORRECTIVE_SMOOTH", "CURVE", "DISPLACE", "HOOK", "LAPLACIANDEFORM", "LAPLACIANSMOOTH",
    "LATTICE", "MESH_CACHE", "MESH_DEFORM", "MESH_SEQUENCE_CACHE", "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "SOFT_BODY",
    "SURFACE_DEFORM", "WARP", "WAVE"))
# Those of them that only smooth a posed mesh, or move it a little: behind a Subdivision they are for what it makes.
FINISHING = frozenset(("CORRECTIVE_SMOOTH", "DISPLACE", "LAPLACIANSMOOTH", "SHRINKWRAP", "SMOOTH"))
# Modifiers that leave the number of points alone, wherever they stand.
NEUTRAL = DEFORMING | frozenset((
    "COLLISION", "DATA_TRANSFER", "DYNAMIC_PAINT", "NORMAL_EDIT", "PARTICLE_SYSTEM", "SURFACE", "UV_PROJECT", "UV_WARP",
    "VERTEX_WEIGHT_EDIT", "VERTEX_WEIGHT_MIX", "VERTEX_WEIGHT_PROXIMITY", "WEIGHTED_NORMAL"))


SIMULATION_NODE = "GeometryNodeSimulationInput"  # the start of a simulation zone, from Blender 3.6 on

_HIDDEN = (wrinkle_tree.OUTPUT, wrinkle_tree.VIEWPORT_OUTPUT, wrinkle_tree.CACHE)
_WRINKLED = ModifiedObjects(wrinkle_tree.is_ours, _HIDDEN)


def find(obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """The wrinkles of an object."""
    return _WRINKLED.find(obj)


def system(modifier: bpy.types.NodesModifier) -> System:
    """What makes the wrinkles that a modifier shows."""
    return wrinkle_tree.system(modifier.node_group)


def wrinkled_objects() -> Iterator[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """Every object with the modifier, in the order of their names. The list is kept: see kept_lists.py."""
    return iter(_WRINKLED)


def is_simulation_nodes(modifier: bpy.types.Modifier) -> bool:
    """Whether a simulation zone is in its nodes, as in Blender's own Cloth Dynamics."""
    return modifier.type == "NODES" and _simulates(modifier.node_group)


def _simulates(group: bpy.types.NodeTree | None) -> bool:
    """Also where the zone is in a group that it uses."""
    return group is not None and any(node.bl_idname == SIMULATION_NODE or _simulates(getattr(node, "node_tree", None))
                                     for node in group.nodes)


def deforms(modifier: bpy.types.Modifier) -> bool:
    """Whether it poses the points that it is given."""
    return modifier.type in DEFORMING or is_simulation_nodes(modifier)


def changes_topology(modifier: bpy.types.Modifier) -> bool:
    """True where a modifier may add or remove points. Node groups may do anything; ours does not count."""
    if not (modifier.show_viewport or modifier.show_render):
        return False
    return modifier.type not in NEUTRAL and not is_simulation_nodes(modifier)


def in_front(obj: bpy.types.Object) -> list[bpy.types.Modifier]:
    """The modifiers in front of the wrinkles, or of where they would stand."""
    ours = next((index for index, m in enumerate(obj.modifiers)
                 if wrinkle_tree.is_ours(getattr(m, "node_group", None))), None)
    return list(obj.modifiers)[:_place(obj) if ours is None else ours]


def topology_changer_before(obj: bpy.types.Object) -> bpy.types.Modifier | None:
    """The first modifier in front of the wrinkles (or of where they would stand) that changes the topology."""
    return next((m for m in in_front(obj) if changes_topology(m)), None)


def deforming_and_behind(obj: bpy.types.Object) -> list[bpy.types.Modifier]:
    """All but those in front of the wrinkles that do not deform."""
    front = [m for m in in_front(obj) if not deforms(m)]
    return [m for m in obj.modifiers if m not in front]


def depends_on(obj: bpy.types.Object, others: list[bpy.types.Object]) -> bpy.types.Object | None:
    """Which of the others a modifier in front of the wrinkles follows (Shrinkwrap, Surface Deform, ...)."""
    for modifier in obj.modifiers:
        if wrinkle_tree.is_ours(getattr(modifier, "node_group", None)):
            return None
        for target in (getattr(modifier, name, None) for name in ("target", "object")):
            if target is not None and target in others:
                return target
    return None


def depends_on_wrinkled(obj: bpy.types.Object) -> bpy.types.Object | None:
    """The other wrinkled object that a wrinkled one follows."""
    return depends_on(obj, [other for other, _ in wrinkled_objects() if other != obj])


def keep_parent_without_deforming(obj: bpy.types.Object) -> None:
    """Of an object whose mesh has been made what its parent, an armature or a lattice, makes of it."""
    if obj.parent_type in ("ARMATURE", "LATTICE"):
        obj.parent_type = "OBJECT"


def place_behind_deforming(obj: bpy.types.Object) -> int:
    """Index behind the last modifier that deforms or simulates: in front of Subdivision and Solidify, and of what
    finishes a posed mesh behind these. Behind Multires, which Blender from 4.3 on lets nothing be put in front of; and
    behind particles on the coarse mesh, which would not find their roots on another one."""
    place, other_points = 0, False
    for index, modifier in enumerate(obj.modifiers):
        if (deforms(modifier) and not (place and other_points and _only_finishes(modifier))
                or modifier.type == "MULTIRES" or modifier.type == "PARTICLE_SYSTEM" and not other_points):
            place, other_points = index + 1, False
        other_points = other_points or changes_topology(modifier)
    return place


def _place(obj: bpy.types.Object) -> int:
    """Index at which wrinkles are added: behind a Mirror too. What was modelled as half is worn whole, also where an
    armature as parent poses it before all modifiers."""
    mirrors = [index for index, m in enumerate(obj.modifiers) if m.type == "MIRROR" and changes_topology(m)]
    return max(place_behind_deforming(obj), mirrors[-1] + 1 if mirrors else 0)


def _only_finishes(modifier: bpy.types.Modifier) -> bool:
    """Not where it is bound to the points that it gets now."""
    return modifier.type in FINISHING and getattr(modifier, "rest_source", "") != "BIND"


def add(obj: bpy.types.Object, method: str) -> bpy.types.NodesModifier:
    """Put the modifier behind the last deforming one. It has no output object yet and shows the coarse mesh."""
    place = _place(obj)
    modifier = obj.modifiers.new(SYSTEMS[method].label, "NODES")
    modifier.node_group = wrinkle_tree.ensure(method)
    modifier.show_in_editmode = False  # as Cloth: the folds of a pose would hide the vertices of the mesh at rest
    _WRINKLED.forget()
    last = len(obj.modifiers) - 1
    if place != last:
        compat.move_modifier(obj, last, place)
    return find(obj)


def output_object(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object whose mesh the modifier shows."""
    found = get_input(modifier, wrinkle_tree.OUTPUT)
    return found if isinstance(found, bpy.types.Object) else None


def set_output_object(modifier: bpy.types.NodesModifier, new: bpy.types.Object | None, coarse_vertices: int) -> None:
    """Point the modifier to an output object for a coarse mesh of that many vertices."""
    set_input(modifier, wrinkle_tree.OUTPUT, new)
    set_input(modifier, wrinkle_tree.COUNT, coarse_vertices)
    # An input set from Python does not tell the dependency graph about the new relation; setting the group does.
    modifier.node_group = modifier.node_group
    modifier.id_data.update_tag()


def viewport_output(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object whose mesh the modifier shows in viewports, where that is another one."""
    found = get_input(modifier, wrinkle_tree.VIEWPORT_OUTPUT)
    return found if isinstance(found, bpy.types.Object) else None


def can_show_in_viewport(modifier: bpy.types.NodesModifier) -> bool:
    """Not with a node group of an older version that is linked from another file."""
    return wrinkle_tree.VIEWPORT_OUTPUT in compat.group_sockets(modifier.node_group, "INPUT")


def set_viewport_output(modifier: bpy.types.NodesModifier, new: bpy.types.Object | None) -> None:
    """None: viewports show what renders show."""
    if new == viewport_output(modifier):
        return
    set_input(modifier, wrinkle_tree.VIEWPORT_OUTPUT, new)
    modifier.node_group = modifier.node_group  # as in set_output_object()
    modifier.id_data.update_tag()


def outputs(modifier: bpy.types.NodesModifier) -> list[bpy.types.Object]:
    """Both of them, as far as they are there."""
    return [found for found in (output_object(modifier), viewport_output(modifier)) if found is not None]


def coarse_vertices(modifier: bpy.types.NodesModifier) -> int:
    """The number of incoming vertices that the output object was made for."""
    return int(get_input(modifier, wrinkle_tree.COUNT) or 0)


def cache_object(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object whose points play the baked clip."""
    found = get_input(modifier, wrinkle_tree.CACHE)
    return found if isinstance(found, bpy.types.Object) else None


def set_cache_object(modifier: bpy.types.NodesModifier, new: bpy.types.Object | None) -> None:
    set_input(modifier, wrinkle_tree.CACHE, new)
    modifier.node_group = modifier.node_group  # as in set_output_object()
    modifier.id_data.update_tag()


def set_baked(modifier: bpy.types.NodesModifier, baked: bool) -> None:
    """Show what the cache object has instead of embedding the output object."""
    set_input(modifier, wrinkle_tree.BAKED, baked)
    modifier.id_data.update_tag()


def is_baked(modifier: bpy.types.NodesModifier) -> bool:
    return bool(get_input(modifier, wrinkle_tree.BAKED))


def play_clip(modifier: bpy.types.NodesModifier, playing: bool) -> bool:
    """Show the clip of a baked object, or live folds in place of one that is damaged. True when that changed."""
    output = output_object(modifier)
    return output is not None and change_flag(output, Flag.LIVE_FOLDS, not playing)


def plays_clip(modifier: bpy.types.NodesModifier) -> bool:
    """Whether it is baked and shows its clip."""
    output = output_object(modifier)
    return is_baked(modifier) and (output is None or not is_set(output, Flag.LIVE_FOLDS))


def bodies(modifier: bpy.types.NodesModifier) -> tuple[bpy.types.Object | None, bpy.types.Collection | None]:
    """What Blender evaluates before the garment."""
    return get_input(modifier, wrinkle_tree.BODY) or None, get_input(modifier, wrinkle_tree.BODIES) or None


def can_name_bodies(modifier: bpy.types.NodesModifier) -> bool:
    """Not with a node group of an older version that is linked from another file."""
    return wrinkle_tree.BODIES in compat.group_sockets(modifier.node_group, "INPUT")


def set_bodies(modifier: bpy.types.NodesModifier, body: bpy.types.Object | None,
               collection: bpy.types.Collection | None) -> None:
    """Let Blender evaluate these before the garment."""
    set_input(modifier, wrinkle_tree.BODY, body)
    set_input(modifier, wrinkle_tree.BODIES, collection)
    modifier.node_group = modifier.node_group  # as in set_output_object()
    modifier.id_data.update_tag()


def add_mesh_cache(cache_obj: bpy.types.Object, manifest: Manifest,
                   path: str) -> bpy.types.MeshCacheModifier:
    """Let the points of a cache object be those of a clip. path: as a blend file names it."""
    cache = cache_obj.modifiers.new(CACHE_NAME, "MESH_CACHE")
    cache.cache_format, cache.play_mode, cache.time_mode = "PC2", "SCENE", "FRAME"
    cache.deform_mode, cache.interpolation = "OVERWRITE", "LINEAR"
    # Mesh Cache takes sample number frame * scale - start.
    cache.frame_start, cache.frame_scale = float(manifest.start * manifest.samples), float(manifest.samples)
    cache.filepath = path
    return cache


def mesh_cache(cache_obj: bpy.types.Object) -> bpy.types.MeshCacheModifier | None:
    """The Mesh Cache modifier of a cache object."""
    return next((m for m in cache_obj.modifiers if m.type == "MESH_CACHE"), None)


def take_out_of_scenes(hidden: Iterable[bpy.types.Object | None]) -> None:
    """Hidden objects are in no collection. What is appended or pasted, and is in none, Blender puts into the scene."""
    for obj in hidden:
        for collection in obj.users_collection if obj is not None and compat.is_editable(obj) else ():
            if compat.is_editable(collection):
                collection.objects.unlink(obj)


def drop_unused_groups() -> None:
    """Node groups of wrinkles that Blender's own buttons removed."""
    _WRINKLED.drop_unused_groups()


def delete_hidden(hidden: bpy.types.Object) -> None:
    """Remove an output or cache object that nothing refers to, and its mesh."""
    if not compat.is_editable(hidden):
        return
    mesh = hidden.data
    bpy.data.objects.remove(hidden)
    if mesh is not None and mesh.users == 0 and compat.is_editable(mesh):
        bpy.data.meshes.remove(mesh)


def remove(obj: bpy.types.Object) -> None:
    """Take the modifier away, and the node group when it was the last. Hidden objects are left to the caller."""
    modifier = find(obj)
    if modifier is None:
        return
    _WRINKLED.remove(obj, modifier, (*_HIDDEN, wrinkle_tree.BODY, wrinkle_tree.BODIES))
