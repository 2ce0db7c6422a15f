# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties of the Wrinkle Maps, `object.rumple_maps`. Reference poses are stored bone by bone, by name."""
from __future__ import annotations

import bpy

from ...core.systems.poses import GAINS, MOST_POSES
from .. import compat
from ..objects.properties import METHODS
from . import changes as maps_changes, comparison, runtimes as maps_runtimes

_OVERRIDE = {"LIBRARY_OVERRIDABLE", "USE_INSERTION"}
_TRACKED = (
    ("BOTH", "Both", "Head and tail: a joint that turns and one that moves are both seen"),
    ("HEAD", "Head", "The head only, as in the paper: a joint that turns in place is not seen"),
    ("TAIL", "Tail", "The tail only"),
)
_MAPS = (
    ("WRINKLES", "Wrinkles Only", "The maps are flat where there is no wrinkle: they add to the neutral normal map"),
    ("WHOLE", "Whole Skin", "The maps contain the details of the neutral normal map: they take its place"),
)


def _rig_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Update function of properties that change the comparison: poses, bones, weights."""
    maps_changes.rig_changed(group.id_data)


def _frame_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Update function of properties that only change the masks."""
    group.id_data.update_tag()


def _maps_changed(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Update function of properties that change the images or their blending."""
    maps_changes.maps_changed(group.id_data)


def _pose_renamed(pose: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    """Make the name unique, as everywhere in Blender: the renamed pose gets a number."""
    others = [other.name for other in pose.id_data.rumple_maps.poses if other != pose]
    free = unused_name(pose.name, others)
    if free != pose.name:
        pose.name = free  # calls this function again
        return
    _rig_changed(pose, context)


def unused_name(wanted: str, taken: list[str]) -> str:
    """wanted, or the first of wanted.001, wanted.002, ... that is free."""
    wanted = wanted or "Pose"
    name, number = wanted, 0
    while name in taken:
        number += 1
        name = f"{wanted}.{number:03d}"
    return name


def _presence(pose: bpy.types.PropertyGroup) -> float:
    return comparison.presence(pose.id_data, pose.name)


def _message(settings: bpy.types.PropertyGroup) -> str:
    return maps_runtimes.message(settings.id_data)


class RUMPLE_PosedBone(bpy.types.PropertyGroup):
    """A bone in a stored pose, by its name. Armature space, object units."""

    head: bpy.props.FloatVectorProperty(size=3, override={"LIBRARY_OVERRIDABLE"})
    tail: bpy.props.FloatVectorProperty(size=3, override={"LIBRARY_OVERRIDABLE"})
    matrix: bpy.props.FloatVectorProperty(size=16, override={"LIBRARY_OVERRIDABLE"},
                                          description="Armature space; the root's is the space of comparison")
    basis: bpy.props.FloatVectorProperty(size=16, override={"LIBRARY_OVERRIDABLE"},
                                         description="The bone's own channels, for Go to Pose")
    rest: bpy.props.FloatVectorProperty(size=9, override={"LIBRARY_OVERRIDABLE"},
                                        description="Where the bone was at rest when the pose was stored: head, tail "
                                                    "and a point on its x axis")  # zeros: not known


class RUMPLE_KeyValue(bpy.types.PropertyGroup):
    """A shape key in a stored pose, by its name."""

    value: bpy.props.FloatProperty(override={"LIBRARY_OVERRIDABLE"}, description="As it counted: 0 where it was muted")


class RUMPLE_ReferencePose(bpy.types.PropertyGroup):
    """A pose of all bones and shape keys, and the wrinkle map that belongs to it."""

    name: bpy.props.StringProperty(name="Name", maxlen=48, options=set(), override={"LIBRARY_OVERRIDABLE"},
                                   update=_pose_renamed,
                                   description="The masks come to shaders and nodes as rumple_pose_ and this name")
    image: bpy.props.PointerProperty(type=bpy.types.Image, name="Wrinkle Map", override={"LIBRARY_OVERRIDABLE"},
                                     update=_maps_changed,
                                     description="Tangent-space normal map with the wrinkles of this pose")
    strength: bpy.props.FloatProperty(name="Strength", default=1.0, min=0.0, max=1.0, subtype="FACTOR",
                                      override={"LIBRARY_OVERRIDABLE"}, update=_frame_changed,
                                      description="Share of this pose's wrinkles that is shown")
    muted: bpy.props.BoolProperty(name="Mute", override={"LIBRARY_OVERRIDABLE"}, update=_frame_changed,
                                  description="Do not show the wrinkles of this pose")
    solo: bpy.props.BoolProperty(name="Solo", override={"LIBRARY_OVERRIDABLE"}, update=_frame_changed,
                                 description="Show the wrinkles of this pose (and of others that are solo) only")
    present: bpy.props.FloatProperty(name="Present", min=0.0, max=1.0, subtype="FACTOR", get=_presence,
                                     description="How far the present pose has come to this one: mean over its bones "
                                                 "and shape keys")
    bones: bpy.props.CollectionProperty(type=RUMPLE_PosedBone, override=_OVERRIDE)
    keys: bpy.props.CollectionProperty(type=RUMPLE_KeyValue, override=_OVERRIDE)


class RUMPLE_TrackedBone(bpy.types.PropertyGroup):
    """A bone that is compared, by its name."""

    tracked: bpy.props.EnumProperty(name="Follow", items=_TRACKED, default="BOTH", options=set(),
                                    override={"LIBRARY_OVERRIDABLE"}, update=_rig_changed,
                                    description="Which end of the bone is compared")
    group: bpy.props.StringProperty(name="Group", options=set(), override={"LIBRARY_OVERRIDABLE"}, update=_rig_changed,
                                    description="Bones of one group share the mean of their influences, so that a "
                                                "wrinkle across them does not break")


class RUMPLE_TrackedKey(bpy.types.PropertyGroup):
    """A shape key that is compared, by its name."""

    group: bpy.props.StringProperty(name="Group", options=set(), override={"LIBRARY_OVERRIDABLE"}, update=_rig_changed,
                                    description="Shape keys and bones of one group share the mean of their influences, "
                                                "so that a wrinkle across them does not break")


class RUMPLE_Maps(bpy.types.PropertyGroup):
    """Reference poses, the bones and shape keys that are compared, and how the maps are blended and baked."""

    root: bpy.props.StringProperty(name="Root Bone", options=set(), override={"LIBRARY_OVERRIDABLE"},
                                   update=_rig_changed,
                                   description="Poses are compared in the space of this bone: its motion has no effect."
                                               " Empty: the armature itself")
    bones: bpy.props.CollectionProperty(type=RUMPLE_TrackedBone, override=_OVERRIDE)
    active_bone: bpy.props.IntProperty(options=set(), override={"LIBRARY_OVERRIDABLE"})
    keys: bpy.props.CollectionProperty(type=RUMPLE_TrackedKey, override=_OVERRIDE)
    active_key: bpy.props.IntProperty(options=set(), override={"LIBRARY_OVERRIDABLE"})
    neutral: bpy.props.CollectionProperty(type=RUMPLE_PosedBone, override=_OVERRIDE,
                                          description="The neutral pose where one is captured; else the rest pose")
    neutral_keys: bpy.props.CollectionProperty(type=RUMPLE_KeyValue, override=_OVERRIDE,
                                               description="The neutral face where one is captured; else all are 0")
    poses: bpy.props.CollectionProperty(type=RUMPLE_ReferencePose, override=_OVERRIDE,
                                        description=f"At most {MOST_POSES}")
    active: bpy.props.IntProperty(name="Active Pose", options=set(), override={"LIBRARY_OVERRIDABLE"})
    maps: bpy.props.EnumProperty(name="Maps Contain", items=_MAPS, default="WRINKLES", options=set(),
                                 override={"LIBRARY_OVERRIDABLE"}, update=_maps_changed,
                                 description="How the maps are blended with the neutral normal map")
    gain: bpy.props.FloatProperty(name="Gain", default=1.0, min=GAINS[0], max=GAINS[1], soft_max=10.0,
                                  override={"LIBRARY_OVERRIDABLE"}, update=_frame_changed,
                                  description="Above 1 wrinkles fade less where the skin weight of their bones is low, "
                                              "or where their shape keys move the skin less")
    uv_map: bpy.props.StringProperty(name="UV Map", options=set(), override={"LIBRARY_OVERRIDABLE"},
                                     update=_maps_changed, description="Of the wrinkle maps; empty: the active one")
    show_influences: bpy.props.BoolProperty(name="Influences as Colors", options=set(),
                                            override={"LIBRARY_OVERRIDABLE"}, update=_frame_changed,
                                            description="Color the mesh in the viewport by the masks: a hue for each "
                                                        "pose")
    bake_source: bpy.props.EnumProperty(name="Wrinkles", items=METHODS[1:], default="MESH", options=set(),
                                        override={"LIBRARY_OVERRIDABLE"},
                                        description="What makes the wrinkles that are baked, with its settings as they "
                                                    "are set on this object")
    bake_size: bpy.props.IntProperty(name="Size", default=1024, min=16, max=16384, subtype="PIXEL", options=set(),
                                     override={"LIBRARY_OVERRIDABLE"}, description="Texels along each side of the map")
    bake_margin: bpy.props.IntProperty(name="Margin", default=16, min=0, max=256, subtype="PIXEL", options=set(),
                                       override={"LIBRARY_OVERRIDABLE"},
                                       description="Texels by which the map reaches beyond the islands of the UV map")
    bake_cage: bpy.props.FloatProperty(name="Cage", default=0.0, min=0.0, soft_max=0.1, subtype="DISTANCE",
                                       unit="LENGTH", step=0.02, precision=4, options=set(),
                                       override={"LIBRARY_OVERRIDABLE"},
                                       description="How far outside the coarse mesh the baker looks for wrinkles. 0: "
                                                   "from the height of the folds")
    bake_deep: bpy.props.BoolProperty(name="16 Bit", options=set(), override={"LIBRARY_OVERRIDABLE"},
                                      description="More than eight bits a channel: no steps in broad shallow wrinkles")
    bake_folder: bpy.props.StringProperty(name="Folder", options=compat.FOLDER_OPTIONS,
                                          override={"LIBRARY_OVERRIDABLE"}, subtype="DIR_PATH",
                                          description="Where maps are saved. Empty: packed into the blend file")
    message: bpy.props.StringProperty(name="Message", get=_message,
                                      description="What is wrong; empty when nothing is")
    group: bpy.props.PointerProperty(type=bpy.types.NodeTree, override={"LIBRARY_OVERRIDABLE"},
                                     description="The node group Rumple Maps of this object")


CLASSES = (RUMPLE_PosedBone, RUMPLE_KeyValue, RUMPLE_ReferencePose, RUMPLE_TrackedBone, RUMPLE_TrackedKey, RUMPLE_Maps)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.rumple_maps = bpy.props.PointerProperty(type=RUMPLE_Maps, override={"LIBRARY_OVERRIDABLE"})


def unregister() -> None:
    del bpy.types.Object.rumple_maps
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
