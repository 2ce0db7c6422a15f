# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the heading of docs/user_guide.md that describes a setting, a button or a message."""
from __future__ import annotations

import os
import re
from pathlib import Path

WEBSITE = ""  # address of the site that scripts/site makes; empty while there is none. The same as in the manifest
_ADDON = Path(os.path.abspath(__file__)).parents[2]
# packages have the first, scripts/site makes the second
FOLDERS = (_ADDON / "guide", _ADDON.parents[1] / "out" / "site")
PAGE = "user_guide.html"

# A heading's anchor -> settings and operators described below it. Names are patterns of fnmatch; the first one counts.
# mesh., field., paths., object., brush., pose., bone. and maps. are groups of properties, ops. is bpy.ops.
_PLACES = {
    "one-click": "ops.object.rumple_add object.method",
    "presets": "*.preset ops.object.rumple_preset ops.object.rumple_save_settings ops.object.rumple_use_settings "
               "ops.object.rumple_copy_settings",
    "the-panel": "object.most_vertices ops.wm.rumple_rebuild_wait ops.wm.rumple_held_mouse object.mesh object.field "
                 "object.paths",
    "user-guide": "ops.wm.rumple_open_example",
    "where-it-stands": "ops.object.rumple_apply ops.object.rumple_remove ops.object.rumple_select_healed "
                       "*.rigid_parts object.incoming",
    "gpu-preview": "*.gpu_preview",
    "swing": "*.mass *.swing_damping *.substeps *.locomotion *.drag",
    "pinned-to-the-animation": "*.up object.up_places",
    "cloth": "*.base_cloth *.drape *.slack *.gravity *.room *.slide_room *.free_room *.bending_length mesh.layers "
             "mesh.folds mesh.detail",
    "body": "*.thickness *.friction object.body object.body_collection",
    "guides": "guide.* ops.object.rumple_guide_add ops.object.rumple_guide_remove",
    "paint": "ops.object.rumple_paint*",
    "rest-shape": "mesh.reference mesh.rest_shape field.reference field.rest_shape paths.rest_shape *.window "
                  "*.relaxation *.growth object.captured object.rest_key object.rest_frame "
                  "ops.object.rumple_capture_rest",
    "attachment-constraints": "mesh.attachment mesh.radius mesh.prestretch mesh.bending mesh.collision mesh.inside "
                              "mesh.stretch_relief mesh.buckling_threshold mesh.compression_limit mesh.hem_rings",
    "solver-and-stored-frames": "*.stateless mesh.iterations mesh.start_iterations mesh.damping mesh.offset_space "
                                "mesh.nudge mesh.seed object.memory_limit object.keep_frames object.disk_limit "
                                "ops.object.rumple_clear_frames",
    "bake": "object.bake_* ops.object.rumple_bake* ops.object.rumple_publish ops.object.rumple_vat",
    "status": "object.message",
    "fine-mesh": "mesh.source mesh.density mesh.wavelength mesh.level mesh.segments mesh.edge_length "
                 "mesh.display_steps mesh.weld object.own_mesh object.viewport_steps",
    "waves-and-relaxation": "field.* object.profile_curve",
    "wrinkle-field": "ops.object.rumple_shade ops.object.rumple_unshade",
    "rest-wrinkles": "brush.* ops.object.rumple_brush* ops.object.rumple_scatter "
                     "ops.object.rumple_clear_rest_wrinkles",
    "curves-and-overlay": "paths.show_overlay paths.overlay_opacity ops.object.rumple_curves_*",
    "wrinkle-paths": "ops.object.rumple_width_from_height",
    "folds-and-persistence": "paths.*",
    "wrinkle-maps": "ops.rumple.maps_add ops.rumple.maps_remove",
    "poses-bones-and-shading": "pose.* posed.* bone.* keyed.* key.* maps.* ops.rumple.*",
}
_GROUPS = {"mesh": "rumple_meshsettings", "field": "rumple_fieldsettings", "paths": "rumple_pathssettings",
           "object": "rumple_object", "brush": "rumple_brush", "pose": "rumple_referencepose",
           "posed": "rumple_posedbone", "bone": "rumple_trackedbone", "maps": "rumple_maps", "keyed": "rumple_keyvalue",
           "key": "rumple_trackedkey", "guide": "rumple_guide", "*": "rumple_*settings"}

# A pattern of a message -> the heading of the guide that says what to do. The first match counts.
MESSAGES = tuple((re.compile(pattern), anchor) for pattern, anchor in (
    (r": unexpected ", "when-something-is-wrong"),
    (r"worn over|its body|of its bodies|was reached by a jump|clip begins|Step of the scene|Overwrite is off"
     r"|linked from a file of an older Rumple"
     r"|fewer than two openings|taken for a body|its ends are closed"
     r"|it is a sheet that the bone|all of its materials name|one bone moves it", "body-and-cloth"),
    (r"outside the bake|[Bb]aked clip|of it is damaged|the disk of|nothing can be written|the folder .* is gone"
     r"|changed since the bake|is too long for Windows|: bake again|nothing (?:of it )?is \w+ at frame"
     r"|choose another folder|Time Stretching is on|another file was opened|while its mesh is edited", "bakes"),
    (r"modifier \"|faces the other way|more faces than two|lies on another face|uses a vertex twice"
     r"|deforms the mesh|no valid position|scale is zero|the fine mesh would have|of the own mesh|has no room for"
     r"|rest wrinkle of|away from the origin|other vertices in renders|leaves no faces"
     r"|is bound to it|is instanced on"
     r"|find their places|collides with it|parented to vertices|shows no waves|Use Limit Surface|has no faces"
     r"|differs by axes|so renders do not see|stand at one place|nothing to wrinkle|: seams: "
     r"|vertices without a face|meet only in a point|in units of the object|than can be counted|cannot be subdivided"
     r"|no fold can be computed|its size in metres|can start at more than"
     r"|of zero (?:length|area)|its mesh is also that of", "the-mesh-and-its-modifiers"),
    (r"renders show its folds one frame late|custom normals|lets lists grow only", "known-limits"),
    (r"nothing to bake|has no frame|is before the first|was never saved|clip is not deleted|is kept, |Bake cancelled",
     "bake"),
    (r"GPU Preview", "gpu-preview"),
    (r"stored frame|not enough memory", "solver-and-stored-frames"),
    (r"force field of this type|Independent Frames on, cloth", "swing"),
    (r"^Layers need", "cloth"),
    (r"of a guide|a guide is|the guide \"", "guides"),
    (r"this preset|these settings|not known here", "presets"),
    (r"profile curve|makes the waves geometry", "waves-and-relaxation"),
    (r"no height to go by", "wrinkle-paths"),
    (r"to rest at|no rest shape is captured", "rest-shape"),
    (r"to paint on|: apply it to paint|mesh was edited|is not a vector|are baked: free|switch the modifier on"
     r"|nothing is solved yet", "rest-wrinkles"),
    (r"open border|an image|no image|(no|the) material (\"|to paint)|the pixels of|the UV map has|to paint: choose"
     r"|is locked: unlock|is painted |no painted map|what was painted|^A mask of", "paint"),
    (r"pose .* every bone|to be the root|do not sum to 1|has no bone|has no shape key|the same value in every pose"
     r"|shape keys are absolute|cannot be set here: a driver|without .*: update it|was stretched or mirrored"
     r"|no armature deforms|is compared|does not come to where|it has no UV map \""
     r"|its material .* is linked|has tiles|lie outside of the first tile"
     r"|are compared|to be compared|reference pose|no vertex group|name of pose|cannot be read"
     r"|: expected|, .*: expected|has no name|are called", "reference-poses"),
    (r"^material |: its materials|no material|[Ww]rinkle map|Cycles bakes|UV map to bake|cannot be baked|the maps? "
     r"|no map shows|which bakes the maps|do not show in this pose|wrinkles cannot be made|masks are lost"
     r"|relative shape keys|they get no map", "poses-bones-and-shading"),
    (r"raise Most Vertices|finer folds are asked|Esc stopped|not made anew yet", "the-panel"),
    (r"fewer than the coarse|own fine mesh|are not attached", "fine-mesh"),
    (r"was healed|to be healed", "where-it-stands"),
    (r"these materials are not cloth", "rigid-parts-and-skin"),
    (r"installation of Rumple|Rumple's library", "what-the-packages-need"),
))


def address(anchor: str = "") -> str:
    """The address of the guide, at one of its headings. Empty if there is neither a site nor a local copy."""
    site = WEBSITE or next((folder.as_uri() for folder in FOLDERS if (folder / PAGE).is_file()), "")
    return f"{site}/{PAGE}" + (f"#{anchor}" if anchor else "") if site else ""


def anchors() -> set[str]:
    """All headings that this module names."""
    return {*_PLACES, *(anchor for _pattern, anchor in MESSAGES)}


def places() -> tuple[tuple[str, str], ...]:
    """(pattern of Blender's name of a property or operator, in lower case; anchor). Patterns for a single name come
    first."""
    found = [(_blender_name(word), anchor) for anchor, words in _PLACES.items() for word in words.split()]
    return tuple(sorted(found, key=lambda place: place[0].endswith("*")))


def _blender_name(word: str) -> str:
    group, _, name = word.partition(".")
    return f"bpy.ops.{name}" if group == "ops" else f"bpy.types.{_GROUPS[group]}.{name}"


def place_of_message(text: str) -> str:
    """The anchor of the heading that says what to do about a message; empty if there is none."""
    return next((anchor for pattern, anchor in MESSAGES if pattern.search(text)), "")
