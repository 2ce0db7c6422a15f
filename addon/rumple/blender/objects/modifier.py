# SPDX-License-Identifier: GPL-3.0-or-later
"""The modifier, "Wrinkle Mesh" or another system: adding, finding and removing it, and its output object."""
from __future__ import annotations

from typing import Iterable, Iterator

import bpy

from ...core.files.clip_manifest import Manifest
from ...core.systems.all_systems import SYSTEMS, System
from .. import compat, scheduler
from ..nodes import wrinkle_tree
from ..nodes.modifier_inputs import get_input, get_object, objects_read, set_input, set_relations
from ..nodes.output_flags import Flag, change_flag, is_set
from .kept_lists import ModifiedObjects

CACHE_NAME = "Rumple Bake"  # name of the MESH_CACHE modifier on the cache object of a baked clip

# Modifiers that move points and keep their number. The wrinkles are placed behind the last of them.
DEFORMING = frozenset((
    "ARMATURE", "CAST", "CLOTH", "CORRECTIVE_SMOOTH", "CURVE", "DISPLACE", "HOOK", "LAPLACIANDEFORM", "LAPLACIANSMOOTH",
    "LATTICE", "MESH_CACHE", "MESH_DEFORM", "MESH_SEQUENCE_CACHE", "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "SOFT_BODY",
    "SURFACE_DEFORM", "WARP", "WAVE"))
# Those that only smooth a posed mesh, or move it a little. Behind a Subdivision they work on the subdivided mesh.
FINISHING = frozenset(("CORRECTIVE_SMOOTH", "DISPLACE", "LAPLACIANSMOOTH", "SHRINKWRAP", "SMOOTH"))
# Modifiers that do not change the number of points, anywhere in the stack.
NEUTRAL = DEFORMING | frozenset((
    "COLLISION", "DATA_TRANSFER", "DYNAMIC_PAINT", "NORMAL_EDIT", "PARTICLE_SYSTEM", "SURFACE", "UV_PROJECT", "UV_WARP",
    "VERTEX_WEIGHT_EDIT", "VERTEX_WEIGHT_MIX", "VERTEX_WEIGHT_PROXIMITY", "WEIGHTED_NORMAL"))


SIMULATION_NODE = "GeometryNodeSimulationInput"  # the start of a simulation zone (Blender 3.6 and later)

_HIDDEN = (wrinkle_tree.OUTPUT, wrinkle_tree.VIEWPORT_OUTPUT, wrinkle_tree.CACHE)
_WRINKLED = ModifiedObjects(wrinkle_tree.is_ours, _HIDDEN)


def find(obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """The wrinkles modifier of an object."""
    return _WRINKLED.find(obj)


def system(modifier: bpy.types.NodesModifier) -> System:
    """The system of a modifier."""
    return wrinkle_tree.system(modifier.node_group)


def wrinkled_objects() -> Iterator[tuple[bpy.types.Object, bpy.types.NodesModifier]]:
    """Every object with the modifier, ordered by name. The list is cached: see kept_lists.py."""
    return iter(_WRINKLED)


def is_on(modifier: bpy.types.Modifier, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether a depsgraph evaluates it."""
    return modifier.show_render if depsgraph.mode == "RENDER" else modifier.show_viewport


def is_simulation_nodes(modifier: bpy.types.Modifier) -> bool:
    """Whether its nodes have a simulation zone, as in Blender's own Cloth Dynamics."""
    return modifier.type == "NODES" and _simulates(modifier.node_group)


def _simulates(group: bpy.types.NodeTree | None) -> bool:
    """Whether there is a simulation zone in the group or in a group that it uses."""
    return group is not None and any(node.bl_idname == SIMULATION_NODE or _simulates(getattr(node, "node_tree", None))
                                     for node in group.nodes)


def deforms(modifier: bpy.types.Modifier) -> bool:
    """Whether it moves the points that it gets, without changing their number."""
    return modifier.type in DEFORMING or is_simulation_nodes(modifier)


def changes_topology(modifier: bpy.types.Modifier) -> bool:
    """Whether a modifier may add or remove points. Node groups may do so, but ours does not count."""
    if not (modifier.show_viewport or modifier.show_render):
        return False
    return modifier.type not in NEUTRAL and not is_simulation_nodes(modifier)


def in_front(obj: bpy.types.Object) -> list[bpy.types.Modifier]:
    """The modifiers in front of the wrinkles, or of the place where they would be added."""
    ours = next((index for index, m in enumerate(obj.modifiers)
                 if wrinkle_tree.is_ours(getattr(m, "node_group", None))), None)
    return list(obj.modifiers)[:_place(obj) if ours is None else ours]


def topology_changer_before(obj: bpy.types.Object) -> bpy.types.Modifier | None:
    """The first modifier in front of the wrinkles (or of their future place) that changes the topology."""
    return next((m for m in in_front(obj) if changes_topology(m)), None)


def deforming_and_behind(obj: bpy.types.Object) -> list[bpy.types.Modifier]:
    """All modifiers except the non-deforming ones in front of the wrinkles."""
    front = [m for m in in_front(obj) if not deforms(m)]
    return [m for m in obj.modifiers if m not in front]


def depends_on(obj: bpy.types.Object, others: list[bpy.types.Object]) -> bpy.types.Object | None:
    """The first of the others that a modifier in front of the wrinkles depends on: Shrinkwrap, Surface Deform, nodes
    with such an input, ..."""
    for modifier in obj.modifiers if others else ():
        if wrinkle_tree.is_ours(getattr(modifier, "node_group", None)):
            return None
        for target in _read_by(modifier):
            if target is not None and target in others:
                return target
    return None


def _read_by(modifier: bpy.types.Modifier) -> Iterator[bpy.types.Object | None]:
    yield from (getattr(modifier, name, None) for name in ("target", "object"))
    if modifier.type == "NODES":
        yield from objects_read(modifier)


def depends_on_wrinkled(obj: bpy.types.Object) -> bpy.types.Object | None:
    """The other wrinkled object that the modifiers in front of a wrinkled one depend on."""
    return depends_on(obj, [other for other, _ in wrinkled_objects() if other != obj])


def keep_parent_without_deforming(obj: bpy.types.Object) -> None:
    """Stop the parent (an armature or a lattice) from deforming the object, after its deformation was applied to the
    mesh."""
    if obj.parent_type in ("ARMATURE", "LATTICE"):
        obj.parent_type = "OBJECT"


def place_behind_deforming(obj: bpy.types.Object) -> int:
    """The index behind the last modifier that deforms or simulates. It is in front of Subdivision and Solidify, and of
    modifiers that finish a posed mesh behind these. It is behind Multires, because Blender 4.3 and later allow nothing
    in front of it. It is behind particles on the coarse mesh, because they would not find their roots on another
    mesh."""
    place, other_points = 0, False
    for index, modifier in enumerate(obj.modifiers):
        if (deforms(modifier) and not (place and other_points and _only_finishes(modifier))
                or modifier.type == "MULTIRES" or modifier.type == "PARTICLE_SYSTEM" and not other_points):
            place, other_points = index + 1, False
        other_points = other_points or changes_topology(modifier)
    return place


def _place(obj: bpy.types.Object) -> int:
    """The index at which wrinkles are added: also behind a Mirror. A garment that was modelled as one half is then
    wrinkled as a whole, also if an armature as its parent poses it before all modifiers."""
    mirrors = [index for index, m in enumerate(obj.modifiers) if m.type == "MIRROR" and changes_topology(m)]
    return max(place_behind_deforming(obj), mirrors[-1] + 1 if mirrors else 0)


def _only_finishes(modifier: bpy.types.Modifier) -> bool:
    """Whether it only finishes the mesh. It does not if it is bound to the points that it gets now."""
    return modifier.type in FINISHING and getattr(modifier, "rest_source", "") != "BIND"


def add(obj: bpy.types.Object, method: str) -> bpy.types.NodesModifier:
    """Add the modifier behind the last deforming one. Without an output object it shows the coarse mesh."""
    place = _place(obj)
    modifier = obj.modifiers.new(SYSTEMS[method].label, "NODES")
    modifier.node_group = wrinkle_tree.ensure(method)
    modifier.show_in_editmode = False  # as Cloth, because posed folds would hide the vertices of the rest mesh
    _WRINKLED.forget()
    move_new(modifier, place)
    return find(obj)


def move_new(new: bpy.types.Modifier, place: int) -> None:
    """Move a modifier that was just added to its place. It is not always the last one: from 4.2 on, Blender adds in
    front of modifiers that are pinned to the end, as Shade Auto Smooth pins its own."""
    obj = new.id_data
    made_at = list(obj.modifiers).index(new)
    if made_at != place:
        compat.move_modifier(obj, made_at, place)


def output_object(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object with the mesh that the modifier shows."""
    return get_object(modifier, wrinkle_tree.OUTPUT)


def set_output_object(modifier: bpy.types.NodesModifier, new: bpy.types.Object | None, coarse_vertices: int) -> None:
    """Connect the modifier to an output object for a coarse mesh with this number of vertices."""
    set_relations(modifier, {wrinkle_tree.OUTPUT: new, wrinkle_tree.COUNT: coarse_vertices})


def viewport_output(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object with the mesh that the modifier shows in viewports, if this is a different one."""
    return get_object(modifier, wrinkle_tree.VIEWPORT_OUTPUT)


def can_show_in_viewport(modifier: bpy.types.NodesModifier) -> bool:
    """Whether viewports can show a different mesh. They cannot if the node group is of an older version and linked."""
    return compat.socket_identifier(modifier.node_group, wrinkle_tree.VIEWPORT_OUTPUT) is not None


def set_viewport_output(modifier: bpy.types.NodesModifier, new: bpy.types.Object | None) -> None:
    """None: viewports show the same mesh as renders."""
    if new != viewport_output(modifier):
        set_relations(modifier, {wrinkle_tree.VIEWPORT_OUTPUT: new})


def outputs(modifier: bpy.types.NodesModifier) -> list[bpy.types.Object]:
    """Both output objects, as far as they exist."""
    return [found for found in (output_object(modifier), viewport_output(modifier)) if found is not None]


def to_tag(garment: bpy.types.Object) -> list[bpy.types.Object]:
    """The objects whose tag lets Blender evaluate a garment again: its output objects. A tag of the garment itself
    counts as an edit, which empties the caches of simulations on it that are not baked."""
    nodes_mod = find(garment)
    return (outputs(nodes_mod) if nodes_mod is not None else []) or [garment]


def tag_soon(garments: Iterable[bpy.types.Object]) -> None:
    """Let Blender evaluate garments again soon: scheduler.tag_soon()."""
    scheduler.tag_soon(one for garment in garments for one in to_tag(garment))


def coarse_vertices(modifier: bpy.types.NodesModifier) -> int:
    """The number of incoming vertices that the output object was made for."""
    return int(get_input(modifier, wrinkle_tree.COUNT) or 0)


def cache_object(modifier: bpy.types.NodesModifier) -> bpy.types.Object | None:
    """The hidden object that plays the baked clip."""
    return get_object(modifier, wrinkle_tree.CACHE)


def set_cache_object(modifier: bpy.types.NodesModifier, new: bpy.types.Object | None) -> None:
    set_relations(modifier, {wrinkle_tree.CACHE: new})


def set_baked(modifier: bpy.types.NodesModifier, baked: bool) -> None:
    """Show the mesh of the cache object instead of embedding the output object."""
    set_input(modifier, wrinkle_tree.BAKED, baked)
    modifier.id_data.update_tag()


def is_baked(modifier: bpy.types.NodesModifier) -> bool:
    return bool(get_input(modifier, wrinkle_tree.BAKED))


def play_clip(modifier: bpy.types.NodesModifier, playing: bool) -> bool:
    """Show the clip of a baked object, or live folds if the clip is damaged. Returns whether this changed something."""
    output = output_object(modifier)
    return output is not None and change_flag(output, Flag.LIVE_FOLDS, not playing)


def plays_clip(modifier: bpy.types.NodesModifier) -> bool:
    """Whether the object is baked and shows its clip."""
    output = output_object(modifier)
    return is_baked(modifier) and (output is None or not is_set(output, Flag.LIVE_FOLDS))


def bodies(modifier: bpy.types.NodesModifier) -> tuple[bpy.types.Object | None, bpy.types.Collection | None]:
    """The body and the collection that Blender evaluates before the garment."""
    return get_input(modifier, wrinkle_tree.BODY) or None, get_input(modifier, wrinkle_tree.BODIES) or None


def can_name_bodies(modifier: bpy.types.NodesModifier) -> bool:
    """Whether the modifier has the inputs for bodies. A linked node group of an older version does not."""
    return compat.socket_identifier(modifier.node_group, wrinkle_tree.BODIES) is not None


def set_bodies(modifier: bpy.types.NodesModifier, body: bpy.types.Object | None,
               collection: bpy.types.Collection | None) -> None:
    """Let Blender evaluate this body and this collection before the garment."""
    set_relations(modifier, {wrinkle_tree.BODY: body, wrinkle_tree.BODIES: collection})


def add_mesh_cache(cache_obj: bpy.types.Object, manifest: Manifest,
                   path: str) -> bpy.types.MeshCacheModifier:
    """Let a clip move the points of a cache object. path: in the form of the blend file."""
    cache = cache_obj.modifiers.new(CACHE_NAME, "MESH_CACHE")
    cache.cache_format, cache.play_mode, cache.time_mode = "PC2", "SCENE", "FRAME"
    cache.deform_mode, cache.interpolation = "OVERWRITE", "LINEAR"
    # The Mesh Cache modifier reads sample number frame * scale - start.
    cache.frame_start, cache.frame_scale = float(manifest.start * manifest.samples), float(manifest.samples)
    cache.filepath = path
    return cache


def mesh_cache(cache_obj: bpy.types.Object) -> bpy.types.MeshCacheModifier | None:
    """The Mesh Cache modifier of a cache object."""
    return next((m for m in cache_obj.modifiers if m.type == "MESH_CACHE"), None)


def take_out_of_scenes(hidden: Iterable[bpy.types.Object | None]) -> None:
    """Hidden objects belong to no collection, but Blender links appended or pasted objects without a collection to the
    scene."""
    for obj in hidden:
        for collection in obj.users_collection if obj is not None and compat.is_editable(obj) else ():
            if compat.is_editable(collection):
                collection.objects.unlink(obj)


def drop_unused_groups() -> None:
    """Remove node groups whose wrinkles were removed with Blender's own buttons."""
    _WRINKLED.drop_unused_groups()


def delete_hidden(hidden: bpy.types.Object) -> None:
    """Remove an output or cache object without references, and its mesh."""
    if not compat.is_editable(hidden):
        return
    mesh = hidden.data
    bpy.data.objects.remove(hidden)
    if mesh is not None and mesh.users == 0 and compat.is_editable(mesh):
        bpy.data.meshes.remove(mesh)


def remove(obj: bpy.types.Object) -> None:
    """Remove the modifier, and the node group if this was the last one. The caller removes the hidden objects."""
    modifier = find(obj)
    if modifier is None:
        return
    _WRINKLED.remove(obj, modifier, (*_HIDDEN, wrinkle_tree.BODY, wrinkle_tree.BODIES))
