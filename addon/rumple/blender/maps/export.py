# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports Wrinkle Maps for game engines: the rig as JSON (core/systems/poses.py), the maps as PNG, influences by frame.

bpy.ops.rumple.maps_export(filepath="face.json", frames=True), maps_weights(). docs/wrinkle_maps.md says what an engine
does with them.
"""
from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy

from ...core.base.wording import UserError
from ...core.files import clip_folder
from ...core.systems.poses import PoseComparison, PoseRig, SkinWeights
from ...core.systems.poses_json import from_json
from .. import ui_base
from ..nodes import maps_mask_tree, maps_shader
from ..objects import saved_images
from ..objects.clip_place import stored_path
from ..translation import said
from . import modifier as maps_modifier, operators as maps_operators, rig as maps_rig


def save_image(image: bpy.types.Image, folder: Path, deep: bool) -> Path:
    """Save an image as PNG with 8 or 16 bits per channel, with unchanged values. The image then refers to the file.
    Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{_file_name(image)}.png"
    _write_png(image, path, deep)
    if image.packed_file is not None:
        image.unpack(method="REMOVE")
    image.source, image.filepath = "FILE", stored_path(path)
    image.reload()
    return path


def _file_name(image: bpy.types.Image) -> str:
    """A file name that no other image of this blend file has, also on disks where "A" and "a" are the same name."""
    plain = bpy.path.clean_name(image.name)
    others = [bpy.path.clean_name(other.name).casefold() for other in bpy.data.images if other != image]
    if plain.casefold() in others:
        plain = f"{plain}-{clip_folder.digest(image.name)}"
    return "-".join(filter(None, (bpy.path.clean_name(Path(bpy.data.filepath).stem), plain)))


def _write_png(image: bpy.types.Image, path: Path, deep: bool) -> None:
    with saved_images.raw_scene("PNG", "16" if deep else "8") as scene:
        image.save_render(str(path), scene=scene)
    if not path.is_file():
        raise OSError(f"{path} cannot be written")


def export(obj: bpy.types.Object, path: Path, images: bool) -> list[Path]:
    """Write the rig and, beside it, every map with the file name in the rig. Raises UserError, OSError.

    The neutral map is the image that is connected to the node group in the object's first material with it.
    """
    rig, _ = maps_rig.rig_of(obj)
    rig.check()
    written = [path]
    neutral = next(filter(None, (maps_shader.neutral_image(slot.material) for slot in obj.material_slots
                                 if slot.material is not None)), None)
    if neutral is not None and not tuple(neutral.size)[0]:
        neutral = None
    _name_maps(obj, rig, path.stem, neutral)
    if images and neutral is not None:
        _refuse_tiles(obj, neutral)
        written.append(path.with_name(rig.neutral_map))
        _write_png(neutral, written[-1], neutral.is_float)
    for pose, stored in zip(rig.poses, obj.rumple_maps.poses):
        if images and stored.image is not None:
            if not tuple(stored.image.size)[0]:
                raise UserError(f"{obj.name}: the wrinkle map {stored.image.name} of pose {pose.name} cannot be found: "
                                "choose its file, or bake it again")
            _refuse_tiles(obj, stored.image)
            written.append(path.with_name(pose.map))
            _write_png(stored.image, written[-1], stored.image.is_float)
    text = rig.to_json()
    from_json(text)  # check that it can be read again
    path.write_text(text, encoding="utf-8")
    return written


def _refuse_tiles(obj: bpy.types.Object, image: bpy.types.Image) -> None:
    """Raise UserError for an image of several tiles (UDIM), because Blender saves those as several files."""
    if image.source == "TILED":
        raise UserError(f"{obj.name}: the map {image.name} has tiles (UDIM), and the export writes one file for each "
                        "map: choose an image without tiles, or switch Maps off")


def _name_maps(obj: bpy.types.Object, rig: PoseRig, stem: str, neutral: bpy.types.Image | None) -> None:
    """Give each map a file name. Raises UserError if two names are equal, without regard to case."""
    owners: dict[str, str] = {}
    if neutral is not None:
        rig.neutral_map = f"{stem}_neutral.png"
        owners[rig.neutral_map.casefold()] = neutral.name
    for pose, stored in zip(rig.poses, obj.rumple_maps.poses):
        pose.map = f"{stem}_{bpy.path.clean_name(pose.name)}.png" if stored.image is not None else ""
        if pose.map.casefold() in owners:
            other = owners[pose.map.casefold()]
            raise UserError(f"{obj.name}: the maps of {other} and {pose.name} would be one file: rename one of them")
        if pose.map:
            owners[pose.map.casefold()] = pose.name


def sampled(context: bpy.types.Context, obj: bpy.types.Object, rig: PoseRig, first: int, last: int) -> dict[str, Any]:
    """{fps, first, poses, bones, influence[frame][bone][pose], presence[frame][pose]} of whole frames, to 1e-5. With
    shape keys also {keys, key_influence[frame][key][pose]}."""
    scene = context.scene
    comparison = PoseComparison.build(rig, SkinWeights.none())
    now = scene.frame_current, scene.frame_subframe
    influence, presence = [], []
    count = len(rig.bones)
    try:
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            # then keys and bones may not be updated
            if not obj.evaluated_get(context.evaluated_depsgraph_get()).is_evaluated:
                raise UserError(f"{obj.name}: nothing of it is shown at frame {frame}, it is hidden: show it")
            bones, keys = maps_rig.present(obj, rig)
            found = comparison.frame(bones, keys=keys)
            influence.append(found.influence.round(5).tolist())
            presence.append(found.presence.round(5).tolist())
    finally:
        scene.frame_set(now[0], subframe=now[1])
    clip = dict(fps=scene.render.fps / scene.render.fps_base, first=first, poses=[pose.name for pose in rig.poses],
                bones=[bone.name for bone in rig.bones], influence=[rows[:count] for rows in influence],
                presence=presence)
    if rig.keys:
        clip |= dict(keys=[key.name for key in rig.keys], key_influence=[rows[count:] for rows in influence])
    return clip


def weighted_copy(obj: bpy.types.Object, clip: dict[str, Any]) -> bpy.types.Object:
    """A copy of obj with a shape key without displacement for each pose. Its animated value is the presence of the
    pose: a morph weight."""
    copy = obj.copy()
    copy.data = obj.data.copy()
    copy.name = copy.data.name = f"{obj.name} weights"
    copy.modifiers.remove(maps_modifier.find(copy))
    for collection in obj.users_collection:
        collection.objects.link(copy)
    if copy.data.shape_keys is None:
        copy.shape_key_add(name="Basis")
    about = copy.data.shape_keys.animation_data
    if about is not None and about.action is not None:
        about.action = about.action.copy()  # Blender copies the shape keys, but not their action
    for number, name in enumerate(clip["poses"]):
        key = copy.shape_key_add(name=maps_mask_tree.MASK.format(name), from_mix=False)
        for frame, values in enumerate(clip["presence"], clip["first"]):
            key.value = values[number]
            key.keyframe_insert("value", frame=frame)
    return copy


class RUMPLE_OT_maps_weights(maps_operators.OnPose, bpy.types.Operator):
    """Make a copy with a morph weight for each pose, keyed at every frame: for glTF, which knows no other values"""

    bl_idname = "rumple.maps_weights"
    bl_label = "Copy with Weights"

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj, scene = maps_operators.target(context), context.scene
        try:
            clip = sampled(context, obj, maps_rig.rig_of(obj)[0], scene.frame_start, scene.frame_end)
        except UserError as error:
            return ui_base.refuse(self, error)
        copy = weighted_copy(obj, clip)
        self.report({"INFO"}, said(f"{copy.name}: {len(clip['poses'])} weights, {len(clip['presence'])} frames"))
        return {"FINISHED"}


class RUMPLE_OT_maps_export(maps_operators.OnPose, bpy.types.Operator):
    """Write the reference poses as JSON for a game engine, with the maps and, if wanted, influences by frame"""

    bl_idname = "rumple.maps_export"
    bl_label = "Export Wrinkle Maps"
    bl_options = {"REGISTER"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})  # the file browser needs it
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})
    images: bpy.props.BoolProperty(name="Maps", default=True, description="Save the wrinkle maps beside the file")
    frames: bpy.props.BoolProperty(name="Influences by Frame", description="Also write the influences of the scene's "
                                   "frames, for engines that play the clip and compare no poses")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        self.filepath = f"{bpy.path.clean_name(maps_operators.target(context).name)}.json"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj, path = maps_operators.target(context), Path(bpy.path.abspath(self.filepath))
        if path.suffix.lower() != ".json":
            path = path.with_name(f"{path.name}.json")
        try:
            clip = sampled(context, obj, maps_rig.rig_of(obj)[0], context.scene.frame_start,
                           context.scene.frame_end) if self.frames else None
            written = export(obj, path, self.images)
            if clip is not None:
                written.append(path.with_suffix(".frames.json"))
                written[-1].write_text(json.dumps(clip) + "\n", encoding="utf-8")
        except (UserError, OSError) as error:
            return ui_base.refuse(self, error)
        self.report({"INFO"}, said(f"Wrote {', '.join(file.name for file in written)}"))
        return {"FINISHED"}


CLASSES = (RUMPLE_OT_maps_weights, RUMPLE_OT_maps_export)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
