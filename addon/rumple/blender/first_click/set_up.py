# SPDX-License-Identifier: GPL-3.0-or-later
"""What the first click sets: lengths that suit the mesh, cloth with what it is worn over, and painted maps. All of it
can be changed afterwards."""
from __future__ import annotations

from typing import NamedTuple

import bpy

from ...core.systems.all_systems import SYSTEMS
from ..nodes import wrinkle_tree
from ..objects import incoming_mesh, made_collections, mesh_reader, on_bone, painted_maps, properties, rig_scale
from . import (body_search, bone_sheets, cloth_defaults, figure, free_parts, moved_parts, named_skin, not_cloth,
               painted_skin, tucked_hems)

UNDER_MOST = 0.5  # least share of a garment over an object that is the body in it, and not its neighbour


def set_up(obj: bpy.types.Object, scene: bpy.types.Scene) -> list[str]:
    """Set all settings of the object's method, its bodies and its maps. What was set before a removal stays. Returns
    messages about them."""
    lengths = _set_defaults(obj, scene)
    with incoming_mesh.whole(body_search.candidates(obj, scene)):
        obj.rumple.figure = figure.height(obj, scene)
        found = _set_cloth(obj, scene, lengths)
        return _notes(obj, scene, found)


def _set_defaults(obj: bpy.types.Object, scene: bpy.types.Scene) -> set[str]:
    """Set the lengths that were never set to values for the mesh and the scene's unit. Returns their names."""
    settings = properties.group_of(obj)
    lengths = {name for name, f in properties.fields_of(obj).items()
               if f.metadata["unit"] == "LENGTH" and not settings.is_property_set(name)}
    values = properties.defaults(obj, lengths)
    system = SYSTEMS[obj.rumple.method].wrinkles
    incoming_mesh.update(obj)
    if settings.rest_shape == "FRAME" and wrinkle_tree.REST_POSITION not in incoming_mesh.of(obj).attributes:
        settings.property_unset("rest_shape")  # the captured shape was removed with the former wrinkles
    if system.SUGGESTED in lengths and len(incoming_mesh.of(obj).polygons):
        base = mesh_reader.base_mesh(obj, "REST_POSE", "")
        values[system.SUGGESTED] = system.suggested_length(base, rig_scale.metres_at_rest(obj, scene))
    properties.apply_values(obj, scene, values)
    if obj.rumple.bake_scene_range or not obj.rumple.is_property_set("bake_scene_range"):
        obj.rumple.bake_scene_range = True
    return lengths


class _Found(NamedTuple):
    """What _set_cloth() found."""

    worn_over: body_search.WornOver
    refusal: str  # a message why it is no cloth although it has the shape, or ""
    skin: list[str]  # materials of the skin that was painted
    closed: bool  # whether it is cloth whose ends are closed
    held: str  # a message where a sheet is held that a bone moves, or ""


def _set_cloth(obj: bpy.types.Object, scene: bpy.types.Scene, lengths: set[str]) -> _Found:
    """Set the cloth settings if the object is a garment, find its bodies, and paint its maps. lengths: from
    _set_defaults()."""
    worn_over, skin, held = body_search.find(obj, scene), [], ""
    is_sheet, closed = _shape_of(obj, scene, worn_over)
    refusal = _refusal(obj, scene, is_sheet, closed)
    if not refusal and _may_be_cloth(obj, worn_over):
        cloth_defaults.apply(obj, scene, lengths, is_sheet, closed, _has_body(worn_over))
    if cloth_defaults.is_cloth(obj):
        if is_sheet and on_bone.bone_of(obj) is not None:
            worn_over.garments += [other for other in bone_sheets.beside(obj, worn_over)
                                   if other not in (worn_over.body, *worn_over.garments)]
        if not closed:  # what goes into a closed end would push the end out of itself
            _set_bodies(obj, worn_over)
        was_painted = _is_painted(obj, "follow")
        skin = painted_skin.paint(obj)
        moved_parts.paint(obj)
        held = bone_sheets.hold(obj, scene) if is_sheet else ""
        free_parts.give_room(obj, scene, worn_over.trees, is_sheet, "room" not in lengths)
        tucked_hems.paint(obj, scene, worn_over, is_sheet, not was_painted)
    return _Found(worn_over, refusal, skin, closed and cloth_defaults.is_cloth(obj), held)


def _may_be_cloth(obj: bpy.types.Object, worn_over: body_search.WornOver) -> bool:
    """Whether an object is no body. A sheet that a bone moves is none, whatever lies over it: a weapon on a cape."""
    return not worn_over.is_body or named_skin.is_dressed(obj) or on_bone.bone_of(obj) is not None


def _is_painted(obj: bpy.types.Object, key: str) -> bool:
    painted = painted_maps.find(obj, key)
    return painted is not None and painted.exists


def slack_of_cut(obj: bpy.types.Object, scene: bpy.types.Scene) -> dict[str, float]:
    """The setting Slack if the first click would set it. Cost: for loose trousers that of body_search.find()."""
    values = cloth_defaults.defaults(obj, scene)
    if "slack" not in values:
        return {}
    with incoming_mesh.whole(body_search.candidates(obj, scene)):
        has_body = _has_body(body_search.find(obj, scene))
    return {} if has_body else {"slack": values["slack"]}


def _has_body(worn_over: body_search.WornOver) -> bool:
    """Whether a body is under most of a garment. Most figures are without skin under their clothes."""
    return worn_over.share >= UNDER_MOST


def becomes_cloth(obj: bpy.types.Object, scene: bpy.types.Scene) -> bool:
    """Whether set_up() would make an object cloth, or it is simulated. Nothing is changed. Cost: that of
    body_search.find()."""
    with incoming_mesh.whole(body_search.candidates(obj, scene)):
        worn_over = body_search.find(obj, scene)
        if not _may_be_cloth(obj, worn_over):
            return False
        shape = _shape_of(obj, scene, worn_over)
        return not _refusal(obj, scene, *shape) and bool(cloth_defaults.defaults(obj, scene, *shape))


def _shape_of(obj: bpy.types.Object, scene: bpy.types.Scene, worn_over: body_search.WornOver) -> tuple[bool, bool]:
    """Whether a garment is a sheet, and whether its ends are closed."""
    is_sheet = cloth_defaults.is_sheet(obj, worn_over.body) or bone_sheets.is_one(obj, scene)
    closed = not is_sheet and not _has_body(worn_over) and cloth_defaults.is_closed(obj, scene)
    return is_sheet, closed


def _refusal(obj: bpy.types.Object, scene: bpy.types.Scene, is_sheet: bool, closed: bool) -> str:
    """A message why an object with the shape of a garment is not made cloth; "" if it is made cloth, or does not have
    the shape. is_sheet, closed: from _shape_of()."""
    if cloth_defaults.is_simulated(obj) or not (cloth_defaults.is_skinned(obj) or on_bone.bone_of(obj)):
        return ""
    if not_cloth.is_skin(obj):
        message = (f"{obj.name}: all of its materials name skin, hair, shoes or metal, so it is not made cloth: if it "
                   "is, set Base Cloth to Hang")
    elif not is_sheet and not_cloth.is_rigid(obj, scene) and not cloth_defaults.is_skirt(obj):
        message = (f"{obj.name}: it is small and one bone moves it, so it is not made cloth: if it is, set Base Cloth "
                   "to Hang")
    else:
        return ""
    return message if cloth_defaults.defaults(obj, scene, is_sheet, closed) else ""


def _set_bodies(obj: bpy.types.Object, found: body_search.WornOver) -> None:
    """Set the bodies if none was ever set. Bodies from before a removal stay, also if the artist had cleared them. In a
    library override every pointer counts as set, even if it is empty."""
    about, names = obj.rumple, ("body", "body_collection")
    if about.looks_again or not any(about.is_property_set(name) and (
            obj.override_library is None or getattr(about, name) is not None) for name in names):
        if found.body is not None:
            about.body = found.body
        if found.garments:
            about.body_collection = made_collections.make(obj, found.garments)
        about.looks_again = found.body is None and not found.garments


def _notes(obj: bpy.types.Object, scene: bpy.types.Scene, found: _Found) -> list[str]:
    """What the artist should know: what is not made cloth, and why."""
    worn_over = found.worn_over
    if found.skin:
        names = ", ".join(found.skin)
        return [f"{obj.name}: by their names, these materials are not cloth, and stay as they are animated: {names}. "
                "To change that, paint Pinned and Keep Smooth"]
    if found.held:
        return [found.held]
    if found.closed:
        return [f"{obj.name}: its ends are closed, so it is cloth that is held by its upper end. If it is not cloth, "
                "set Base Cloth to Off"]
    if cloth_defaults.is_cloth(obj) or properties.group_of(obj).is_property_set("base_cloth"):
        return []
    if found.refusal:
        return [found.refusal]
    if worn_over.is_body and cloth_defaults.defaults(obj, scene):
        return [f"{obj.name}: {worn_over.clothes[0].name} lies over it, so it is taken for a body and is not made "
                "cloth: if it is a garment, set Base Cloth to Hang"]
    if worn_over.body is None:
        return []
    return [f"{obj.name}: it lies over {worn_over.body.name} but is no sheet, as a cape or a flag is, and has fewer "
            "than two openings, as hats and gloves have, so it is not made cloth: if it is, set Base Cloth to Hang"]
