# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that is stored on objects: `object.rumple`. The settings are made from core/settings/system_settings.py,
field by field."""
from __future__ import annotations

import math
from dataclasses import Field, fields, replace
from typing import Any, Callable, Iterable

import bpy

from ...core.frame import engine
from ...core.systems.all_systems import SYSTEMS, System
from .. import compat
from . import bodies, changes, clip_range, own_mesh_place, runtimes, units

METHODS = (("NONE", "None", "No wrinkles"), *((s.method, s.label, s.tip) for s in SYSTEMS.values()))
MAPS = ("MAPS", "Wrinkle Maps", "Normal maps of reference poses, blended by the pose of the bones")
DEFAULT_MOST_VERTICES = 250_000  # built in about two seconds
DEFAULT_MEMORY = 512  # megabytes; about 250 frames of a shirt at 50,000 points
DEFAULT_DISK = 2048  # megabytes
UP_PLACES = 10  # number of stored vertices that show how the mesh was rotated: see applied_transforms.py

MOST_STEPS = 200  # pixels of a drag over the usual range

_OVERRIDE = {"LIBRARY_OVERRIDABLE"}  # otherwise a linked character's garments could not be changed


def _changed(affects: str, name: str = "") -> Callable[[bpy.types.PropertyGroup, bpy.types.Context], None]:
    def update(group: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
        obj = group.id_data
        structural = affects == "MESH" or name in settings_of(obj, units.scene_of(obj)).structural()
        changes.settings_changed(obj, affects, structural)
    return update


def _redraw(_group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _property(f: Field) -> Any:
    """The Blender property of one field of the settings."""
    about = f.metadata
    options = {"ANIMATABLE"} if about["affects"] == "SOLVE" else set()
    common = dict(name=about["name"], description=about["tip"], default=f.default, options=options, override=_OVERRIDE,
                  update=_changed(about["affects"], f.name))
    if about["choices"]:
        return bpy.props.EnumProperty(items=about["choices"], **common)
    if isinstance(f.default, bool):
        return bpy.props.BoolProperty(**common)
    if isinstance(f.default, str):
        return bpy.props.StringProperty(**common)
    for key, names in (("low", ("min", "soft_min")), ("high", ("max",)), ("soft", ("soft_max",))):
        if about[key] is not None:
            common.update({name: about[key] for name in names})
    if about["unit"] == "LENGTH":  # stored in the scene's unit, which may be a millimetre or a kilometre
        # The slider has 200 pixels (ui_base.draw_setting), so a fold changes by about half a millimetre per pixel. The
        # step is for Ctrl and the mouse wheel: a millimetre.
        length: float = f.default  # type: ignore[assignment]
        common.update(soft_min=length / 20.0 if common["min"] > 0.0 else 0.0, soft_max=3.0 * length, step=0.02)
        common.update(min=common["min"] / 1000.0, max=1000.0 * common["max"])
    if isinstance(f.default, int):
        return bpy.props.IntProperty(**common)
    if about["unit"] == "NONE":
        common["step"] = 100.0 * _nice_step(f)
    if about["unit"] == "LENGTH":
        return bpy.props.FloatProperty(subtype="DISTANCE", unit="LENGTH", precision=4, **common)
    if about["unit"] == "SECONDS":
        return bpy.props.FloatProperty(subtype="TIME_ABSOLUTE", unit="TIME_ABSOLUTE", precision=3, **common)
    return bpy.props.FloatProperty(subtype="FACTOR" if about["unit"] == "FACTOR" else "NONE", precision=3, **common)


def _nice_step(f: Field) -> float:
    """How much a pixel of a drag changes a plain number: 1, 2 or 5 times a power of ten, some hundred steps in the
    usual range."""
    about = f.metadata
    default: float = f.default  # type: ignore[assignment]
    highest = about["high"] if about["soft"] is None else about["soft"]
    span = min(highest - about["low"], 10.0 * (default - about["low"]) or highest)
    decade = 10.0 ** math.floor(math.log10(span / MOST_STEPS))
    return max(step for step in (decade, 2.0 * decade, 5.0 * decade) if step <= 1.001 * span / MOST_STEPS)


def _settings_group(method: str, **others: Any) -> type:
    """others: properties that do not affect the solver."""
    system = SYSTEMS[method]
    annotations = {f.name: _property(f) for f in fields(system.settings)} | others
    if system.presets:
        annotations["preset"] = bpy.props.EnumProperty(
            name="Fabric", default=next(iter(system.presets)), items=preset_items(system), options=set(),
            override=_OVERRIDE, description="The fabric that was chosen last")
        annotations["preset_replaced"] = bpy.props.StringProperty(
            options={"HIDDEN"}, override=_OVERRIDE,
            description="Settings as they were before that choice, for the next one to bring back")
    return type(f"RUMPLE_{system.settings.__name__}", (bpy.types.PropertyGroup,),
                {"__annotations__": annotations, "__doc__": system.settings.__doc__})


def preset_items(system: System) -> tuple[tuple[str, str, str, str, int], ...]:
    """The presets of a system as items of a Blender enum."""
    return tuple((key, preset.label, preset.tip, "NONE", preset.number) for key, preset in system.presets.items())


def _gpu_preview(description: str) -> Any:
    return bpy.props.BoolProperty(name="GPU Preview", options=set(), override=_OVERRIDE, update=_redraw,
                                  description=description)


RUMPLE_MeshSettings = _settings_group("MESH", gpu_preview=_gpu_preview(
    "Solve and draw the wrinkles of Solid viewports on the graphics card, which is faster for dense meshes. It needs "
    "one layer, no base cloth and no body. Renders and other viewports show the fine mesh. Turn it off before viewport "
    "exports and Blender's own Apply"))
RUMPLE_FieldSettings = _settings_group("FIELD", gpu_preview=_gpu_preview(
    "Draw the waves in Solid viewports, on the graphics card"))
RUMPLE_PathsSettings = _settings_group("PATHS", gpu_preview=_gpu_preview(
    "Draw the folds in Solid viewports, on the graphics card, in place of the fine mesh, which plays faster. Renders "
    "and other viewports show the fine mesh. Turn it off before viewport exports and Blender's own Apply"),
    show_overlay=bpy.props.BoolProperty(
        name="Labels & Ellipses", options=set(), override=_OVERRIDE, update=_redraw,
        description="Draw over the coarse triangles what folds go by: blue is being compressed, red stretched, green "
                    "at rest. The ellipses were circles before the cloth was stretched"),
    overlay_opacity=bpy.props.FloatProperty(
        name="Opacity", default=0.3, min=0.0, max=1.0, subtype="FACTOR", options=set(), override=_OVERRIDE,
        update=_redraw, description="Of the labels; the ellipses have twice as much"))


def _range_edited(name: str) -> Callable[[bpy.types.PropertyGroup, bpy.types.Context], None]:
    return lambda group, _context: clip_range.edited(group, name)


def _range_switched(group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    clip_range.switched(group)
    _changed("SHOW")(group, context)


def _is_own_mesh(group: bpy.types.PropertyGroup, candidate: bpy.types.Object) -> bool:
    return candidate.type == "MESH" and candidate != group.id_data


def _own_mesh_chosen(group: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    own_mesh_place.forget(group.id_data)
    _changed("MESH")(group, context)


def _is_body(group: bpy.types.PropertyGroup, candidate: bpy.types.Object) -> bool:
    return candidate != group.id_data and bodies.can_be_body(candidate)


def _message(group: bpy.types.PropertyGroup) -> str:
    return runtimes.message(group.id_data)


class RUMPLE_Object(bpy.types.PropertyGroup):
    """Everything Rumple keeps with an object."""

    method: bpy.props.EnumProperty(name="Method", items=(*METHODS, MAPS), default="NONE", options=set(),
                                   override=_OVERRIDE,
                                   description="How wrinkles are made; set by adding and removing them. Beside "
                                               "Wrinkle Maps other wrinkles may stand: then it is theirs")
    mesh: bpy.props.PointerProperty(type=RUMPLE_MeshSettings, override=_OVERRIDE)
    field: bpy.props.PointerProperty(type=RUMPLE_FieldSettings, override=_OVERRIDE)
    paths: bpy.props.PointerProperty(type=RUMPLE_PathsSettings, override=_OVERRIDE)
    incoming: bpy.props.PointerProperty(type=bpy.types.Mesh, name="Incoming Mesh", override=_OVERRIDE,
                                        description="What modifiers above the wrinkles make of the mesh at rest")
    captured: bpy.props.PointerProperty(type=bpy.types.Mesh, name="Captured Mesh", override=_OVERRIDE,
                                        description="An incoming mesh that a rest shape was captured on, while the "
                                                    "modifiers that made it are off")
    own_mesh: bpy.props.PointerProperty(type=bpy.types.Object, name="Custom Mesh", override=_OVERRIDE,
                                        poll=_is_own_mesh, update=_own_mesh_chosen,
                                        description="Your own fine mesh, in place over the undeformed coarse mesh")
    body: bpy.props.PointerProperty(type=bpy.types.Object, name="Body", override=_OVERRIDE, poll=_is_body,
                                    update=_changed("BODY"),
                                    description="What this garment is worn over: cloth stays outside of it")
    body_collection: bpy.props.PointerProperty(type=bpy.types.Collection, name="Bodies", override=_OVERRIDE,
                                               update=_changed("BODY"),
                                               description="What this garment is worn over, where it is more than one "
                                                           "object: cloth stays outside of all of them")
    # Hidden. A click found no body, and none was chosen since. A separate property is needed because Blender marks a
    # pointer that was read as set.
    looks_again: bpy.props.BoolProperty(name="Body", options={"HIDDEN"}, override=_OVERRIDE)
    profile_curve: bpy.props.PointerProperty(type=bpy.types.NodeTree, name="Profile Curve", override=_OVERRIDE,
                                             description="The node group with the curve that was drawn as profile")
    rest_key: bpy.props.StringProperty(name="Rest Key", options=set(), override=_OVERRIDE, update=_changed("MESH"),
                                       description="The shape key that is the unwrinkled cloth")
    # Hidden. Undeformed positions of some vertices, and the number of vertices, of the mesh that Up At Rest belongs to.
    up_places: bpy.props.FloatVectorProperty(size=3 * UP_PLACES + 1, name="Up At Rest", override=_OVERRIDE)
    # Hidden. Height of the wearer at rest, in units of the object; 0: unknown. The first click finds it. It is stored,
    # so that lengths do not change when other objects do.
    figure: bpy.props.FloatProperty(name="Body", options={"HIDDEN"}, override=_OVERRIDE, min=0.0)
    rest_frame: bpy.props.IntProperty(name="Frame At Rest", default=1, options=set(), override=_OVERRIDE,
                                      description="The frame whose shape Capture takes as the unwrinkled cloth")
    viewport_steps: bpy.props.IntProperty(name="Viewport", default=0, min=0, max=2, options=set(), override=_OVERRIDE,
                                          update=_changed("MESH"),
                                          description="Smoothing steps in viewports, at most those of renders. Each "
                                                      "makes four times as many vertices, of the same folds")
    most_vertices: bpy.props.IntProperty(name="Most Vertices", default=DEFAULT_MOST_VERTICES, min=1000,
                                         soft_max=2_000_000, max=engine.MOST_VERTICES, options=set(),
                                         override=_OVERRIDE, update=_changed("MESH"),
                                         description="Folds become no finer than so many vertices allow, however short "
                                                     "the wavelength: a dragged slider never stops Blender")
    memory_limit: bpy.props.IntProperty(name="Memory Limit", default=DEFAULT_MEMORY, min=16, soft_max=8192, max=1 << 20,
                                        subtype="NONE", options=set(), override=_OVERRIDE, update=_changed("SHOW"),
                                        description="Most memory for stored frames, in megabytes. The farthest frames "
                                                    "go first")
    keep_frames: bpy.props.BoolProperty(name="Keep Stored Frames On Disk", default=False, options=set(),
                                        override=_OVERRIDE, update=_changed("SHOW"),
                                        description="Write frames that were played through into the bake's folder, "
                                                    "when the file is saved and while nothing moves: in a file that "
                                                    "is opened again a jump shows them")
    disk_limit: bpy.props.IntProperty(name="Disk Limit", default=DEFAULT_DISK, min=16, soft_max=65536, max=1 << 20,
                                      subtype="NONE", options=set(), override=_OVERRIDE, update=_changed("SHOW"),
                                      description="Most room for the stored frames of this object on disk, in "
                                                  "megabytes. The oldest go first")
    bake_scene_range: bpy.props.BoolProperty(name="Scene Range", default=False, options=set(), override=_OVERRIDE,
                                             update=_range_switched,
                                             description="Bake the frame range of the scene, whatever it becomes. The "
                                                         "clip begins at its Start")
    bake_start: bpy.props.IntProperty(name="Start", default=1, options=set(), override=_OVERRIDE,
                                      update=_range_edited("bake_start"), description="First frame that is baked")
    bake_end: bpy.props.IntProperty(name="End", default=250, options=set(), override=_OVERRIDE,
                                    update=_range_edited("bake_end"), description="Last frame that is baked")
    # The frames that the clip has while it follows the scene: see clip_range.py.
    bake_known_range: bpy.props.IntVectorProperty(size=2, name="Scene Range", options={"HIDDEN"}, override=_OVERRIDE)
    bake_samples: bpy.props.IntProperty(name="Samples", default=1, min=1, max=16, options=set(), override=_OVERRIDE,
                                        description="Solves for each frame. 1 is right for most; more make motion blur "
                                                    "follow fast turns")
    bake_whole_clip: bpy.props.BoolProperty(name="Whole Clip", default=True, options=set(), override=_OVERRIDE,
                                            update=_changed("BAKE"),
                                            description="Analyse the whole clip before it is solved: how the rest "
                                                        "shape changes is then chosen for all frames at once, not "
                                                        "frame by frame as in playback")
    bake_folder: bpy.props.StringProperty(name="Folder", options=compat.FOLDER_OPTIONS, override=_OVERRIDE,
                                          subtype="DIR_PATH",
                                          description="Where baked clips go. Empty: the folder rumple beside the file")
    message: bpy.props.StringProperty(name="Message", get=_message,
                                      description="What is wrong; empty when nothing is")


def group_of(obj: bpy.types.Object) -> bpy.types.PropertyGroup:
    """The settings of an object's method as properties. Without wrinkles: those of the Wrinkle Mesh."""
    return getattr(obj.rumple, system_of(obj).group)


def system_of(obj: bpy.types.Object) -> System:
    """The system of an object's method. Without wrinkles: the Wrinkle Mesh."""
    return SYSTEMS.get(obj.rumple.method, SYSTEMS["MESH"])


def fields_of(obj: bpy.types.Object) -> dict[str, Field]:
    """The fields of the settings of an object's method."""
    return {f.name: f for f in fields(system_of(obj).settings)}


def settings_of(obj: bpy.types.Object, scene: bpy.types.Scene) -> Any:
    """The settings for the engine.

    obj may be an evaluated copy, which also has the right animated settings in renders. Blender stores lengths in its
    own units and multiplies them for display. The engine needs the displayed value: metres.
    """
    group = group_of(obj)
    metres = scene.unit_settings.scale_length
    values = {}
    for name, f in fields_of(obj).items():
        value = getattr(group, name)
        if f.metadata["unit"] == "LENGTH":  # an unset length may be newer than the file
            value = value * metres if group.is_property_set(name) else f.default
            value = min(max(value, f.metadata["low"]), f.metadata["high"])
        values[name] = value
    return system_of(obj).settings(**values)


def apply_values(obj: bpy.types.Object, scene: bpy.types.Scene, values: dict[str, Any]) -> None:
    """Set settings from values in metres and plain numbers (presets, or defaults in a scene in centimetres)."""
    metres = scene.unit_settings.scale_length
    for name, value in values.items():
        length = fields_of(obj)[name].metadata["unit"] == "LENGTH"
        setattr(group_of(obj), name, value / metres if length else value)


def defaults(obj: bpy.types.Object, names: Iterable[str]) -> dict[str, Any]:
    """Default values of these settings."""
    return {name: f.default for name, f in fields_of(obj).items() if name in names}


CLASSES = (RUMPLE_MeshSettings, RUMPLE_FieldSettings, RUMPLE_PathsSettings, RUMPLE_Object)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.rumple = bpy.props.PointerProperty(type=RUMPLE_Object, override=_OVERRIDE)


def unregister() -> None:
    del bpy.types.Object.rumple
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


def are_keyed(obj: bpy.types.Object) -> bool:
    """Whether settings of an object may differ between frames, because of keys, drivers or strips."""
    return any(path.startswith("rumple.") for path in compat.animated_paths(obj))


def still_settings(obj: bpy.types.Object, scene: bpy.types.Scene) -> Any:
    """As settings_of(), but with the defaults of animated settings, so that all frames have the same."""
    animated, group = compat.animated_paths(obj), system_of(obj).group
    still = {name: f.default for name, f in fields_of(obj).items() if f"rumple.{group}.{name}" in animated}
    return replace(settings_of(obj, scene), **still)
