# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted maps: the button that paints a map, and operations on a whole map.

bpy.ops.object.rumple_paint(group="radius"), rumple_paint_clear(group="radius"), rumple_paint_invert(group="radius"),
rumple_paint_from_border(group="radius", distance=0.05, falloff="SMOOTH", reverse=False),
rumple_paint_from_texture(group="radius", image="Mask", channel="LUMINANCE"),
rumple_paint_from_material(group="follow", material="Skin", weight=1.0).
"""
from __future__ import annotations

import bpy
import numpy as np

from ...core.base.wording import UserError
from ...core.paint import paint_maps
from .. import compat, ui_base
from ..objects import mesh_reader, painted_maps, properties, shared_mesh, units
from ..objects.painted_maps import PaintedMap
from ..translation import said
from . import paint_words

_MAPS = tuple((key, painted_maps.LABELS[key], "") for key in painted_maps.KEYS)
_FALLOFFS = (("SMOOTH", "Smooth", "Flat at the border and beyond the distance"),
             ("LINEAR", "Linear", "Evenly from the border on"))
_CHANNELS = (("LUMINANCE", "Luminance", "How bright the colour is"), ("ALPHA", "Alpha", "How opaque it is"),
             ("RED", "Red", ""), ("GREEN", "Green", ""), ("BLUE", "Blue", ""))
DISTANCE = 0.05  # metres, the default


class _OnMap(ui_base.OnWrinkled):
    """Operators for one map of an object with an editable mesh."""

    group: bpy.props.EnumProperty(name="Paint", items=_MAPS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        why = _refusal(context.object)
        return ui_base.may_run(cls, why)

    def map_of(self, obj: bpy.types.Object) -> PaintedMap:
        """The chosen map, if it is editable. Raises UserError."""
        painted = painted_maps.find(obj, self.group)
        if painted is None:
            raise UserError(f"{obj.name}: its wrinkles have no {self.group} to paint: choose another map")
        if painted.exists and obj.vertex_groups[painted.name].lock_weight:
            raise UserError(f"{obj.name}: the vertex group {painted.name} is locked: unlock it in the object data")
        return painted


def _refusal(obj: bpy.types.Object) -> str:
    if not compat.is_editable(obj.data):
        return ui_base.LINKED_MESH
    if obj.data.override_library is not None:
        return "This mesh is a library override, which keeps no paint: make it local"
    return ""


# ---------------------------------------------------------------- the brush
class OBJECT_OT_rumple_paint(_OnMap, bpy.types.Operator):
    """Paint where this setting acts, from nothing (0) to all of it (1), in Weight Paint mode. Again: leave the mode"""

    bl_idname = "object.rumple_paint"
    bl_label = "Paint"

    @classmethod
    def description(cls, _context: bpy.types.Context, chosen: bpy.types.OperatorProperties) -> str:
        """The tooltip, which differs for maps that are painted from 1 to 0."""
        tip = paint_words.TIPS.get(chosen.group, "")
        return said(tip) if tip else ""

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        painted = painted_maps.find(obj, self.group)
        if painted is None:
            return ui_base.refuse(self, f"{obj.name}: its wrinkles have no {self.group} to paint: choose another map")
        active = obj.vertex_groups.active
        if obj.mode == "WEIGHT_PAINT" and active is not None and active.name == painted.name:
            bpy.ops.object.mode_set(mode="OBJECT")
            return {"FINISHED"}
        if not painted.exists:
            painted_maps.write(obj, painted, painted_maps.start(obj, painted))
        obj.vertex_groups.active_index = obj.vertex_groups[painted.name].index
        painted_maps.touch(obj)
        if obj.mode != "WEIGHT_PAINT" and not bpy.app.background:
            bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        if not painted.exists:
            # Most new groups already have full weight.
            _set_brush_weight(context, 1.0 if self.group in paint_words.HOW else 0.0)
            self.report({"INFO"}, paint_words.how(painted))
        ui_base.warn(self, shared_mesh.note(obj))
        return {"FINISHED"}


def _set_brush_weight(context: bpy.types.Context, weight: float) -> None:
    """Set the weight of the Weight Paint brush, and the shared weight if brushes share it."""
    tools = context.tool_settings
    paint = tools.weight_paint  # None before the mode was entered for the first time
    shared = getattr(tools, "unified_paint_settings", None) or getattr(paint, "unified_paint_settings", None)  # 5.0
    brush = None if paint is None else paint.brush
    if brush is not None and compat.is_editable(brush):
        brush.weight = weight
    elif shared is not None:
        shared.use_unified_weight = True  # the brush is one of Blender's assets, or not created yet
    if shared is not None:
        shared.weight = weight


# ---------------------------------------------------------------- the whole map
class _WholeMap(_OnMap):
    """Operators that make new weights of a map: for all vertices, or for the selected ones if Weight Paint's mask is
    on."""

    needs_map = False

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not super().poll(context):
            return False
        painting = context.object.mode in ("OBJECT", "WEIGHT_PAINT")
        return ui_base.may_run(cls, "" if painting else "Go to Object Mode or Weight Paint first")

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.object
        try:
            painted = self.map_of(obj)
            if self.needs_map and not painted.exists:
                raise UserError(f"{obj.name}: nothing is painted in {painted.name} yet: paint first")
            self.change(obj, painted)
        except UserError as error:
            return ui_base.refuse(self, error)
        ui_base.warn(self, shared_mesh.note(obj))
        return {"FINISHED"}

    def change(self, obj: bpy.types.Object, painted: PaintedMap) -> None:
        """Write the new weights. Raises UserError."""
        raise NotImplementedError


class OBJECT_OT_rumple_paint_clear(_WholeMap, bpy.types.Operator):
    """Take this map away: as if it had never been painted. With a mask of Weight Paint: of the selected vertices"""

    bl_idname = "object.rumple_paint_clear"
    bl_label = "Clear Map"
    needs_map = True

    def change(self, obj: bpy.types.Object, painted: PaintedMap) -> None:
        if painted_maps.selected(obj) is not None:
            painted_maps.write(obj, painted, painted_maps.start(obj, painted))
            return
        if obj.mode == "WEIGHT_PAINT" and obj.vertex_groups.active.name == painted.name:
            bpy.ops.object.mode_set(mode="OBJECT")  # otherwise the next stroke would paint another group, e.g. a bone's
        painted_maps.remove(obj, painted)


class OBJECT_OT_rumple_paint_invert(_WholeMap, bpy.types.Operator):
    """Turn this map round: 0 becomes 1, and 1 becomes 0"""

    bl_idname = "object.rumple_paint_invert"
    bl_label = "Invert Map"
    needs_map = True

    def change(self, obj: bpy.types.Object, painted: PaintedMap) -> None:
        painted_maps.write(obj, painted, np.float32(1.0) - painted_maps.weights(obj, painted))


class OBJECT_OT_rumple_paint_from_border(_WholeMap, bpy.types.Operator):
    """Make this map a gradient that grows from the open borders of the garment: hems, cuffs, collars"""

    bl_idname = "object.rumple_paint_from_border"
    bl_label = "Map from Border"

    distance: bpy.props.FloatProperty(name="Distance", subtype="DISTANCE", unit="LENGTH", default=DISTANCE, min=0.0,
                                      soft_max=5.0 * DISTANCE, step=0.02, precision=4,
                                      options={"SKIP_SAVE"}, description="From the border to where the gradient ends")
    falloff: bpy.props.EnumProperty(name="Falloff", items=_FALLOFFS, description="How it grows from the border on")
    reverse: bpy.props.BoolProperty(name="Reverse", options={"SKIP_SAVE"},
                                    description="1 at the border and 0 beyond the distance. On for maps that are 0 "
                                                "where nothing is painted")

    def change(self, obj: bpy.types.Object, painted: PaintedMap) -> None:
        metres = units.scene_of(obj).unit_settings.scale_length
        if not self.properties.is_property_set("distance"):
            self.distance = DISTANCE / metres
        if not self.properties.is_property_set("reverse"):
            self.reverse = painted.rest == 0.0
        away = _from_border(obj, self.distance)
        grown = paint_maps.gradient(away, self.distance, self.falloff == "SMOOTH")
        painted_maps.write(obj, painted, np.float32(1.0) - grown if self.reverse else grown)


def _from_border(obj: bpy.types.Object, most: float) -> np.ndarray:
    """(n,) distances to the open border on the undeformed mesh, in the scene's unit. Raises UserError."""
    mesh = obj.data
    positions = mesh_reader.basis_positions(mesh) @ _in_scene(obj).T
    edges, of_corners = compat.edge_vertices(mesh), compat.indices(mesh.loops, "edge_index")
    border, same = paint_maps.open_edges(edges, np.bincount(of_corners, minlength=len(edges)), positions,
                                         properties.group_of(obj).weld)
    if not len(border):
        raise UserError(f"{obj.name}: it has no open border to start from: paint it by hand")
    return paint_maps.border_distance(positions, same[edges], same[edges[border]], most)[same]


def _in_scene(obj: bpy.types.Object) -> np.ndarray:
    """(3, 3) float32 from its lengths to those of the scene. Where it is flattened now, it has the scale that its
    wrinkles are made for. Raises UserError."""
    world, scene = obj.matrix_world.to_3x3(), units.scene_of(obj)
    if world.determinant() != 0.0:
        return np.array(world, np.float32)
    scale = units.metres_per_unit(obj, scene) / scene.unit_settings.scale_length
    if scale == 0.0:
        raise UserError(f"{obj.name}: its scale is zero, so lengths in metres have no meaning: give it one")
    return np.eye(3, dtype=np.float32) * np.float32(scale)


class OBJECT_OT_rumple_paint_from_texture(_WholeMap, bpy.types.Operator):
    """Make this map of an image, which is looked up by the active UV map"""

    bl_idname = "object.rumple_paint_from_texture"
    bl_label = "Map from Texture"

    image: bpy.props.StringProperty(name="Image", description="Its values count as they are stored, from 0 to 1")
    channel: bpy.props.EnumProperty(name="Channel", items=_CHANNELS, description="What of its colours is taken")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        if self.image not in bpy.data.images:
            self.image = _likely_image(context.object)
        try:
            _uv_map(context.object)
            _image(context.object, self.image)  # without an image there is nothing to choose
        except UserError as error:
            return ui_base.refuse(self, error)
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, _context: bpy.types.Context) -> None:
        column = ui_base.property_column(self.layout)
        column.prop_search(self, "image", bpy.data, "images")
        column.prop(self, "channel")

    def change(self, obj: bpy.types.Object, painted: PaintedMap) -> None:
        corners, uv = compat.corner_vertices(obj.data), _uv_map(obj)
        values = paint_maps.channel_of(_pixels(obj, _image(obj, self.image)), self.channel)
        painted_maps.write(obj, painted, paint_maps.on_vertices(
            paint_maps.sampled(values, uv), corners, len(obj.data.vertices), painted_maps.start(obj, painted)))


def _likely_image(obj: bpy.types.Object) -> str:
    """The image of the active texture of its material, otherwise the first one of the file; empty if there is none."""
    material = obj.active_material
    tree = material.node_tree if material is not None else None
    node = tree.nodes.active if tree is not None else None
    of_node = getattr(node, "image", None)
    chosen = of_node or next((image for image in bpy.data.images if image.size[0] > 0), None)
    return "" if chosen is None else chosen.name


def _image(obj: bpy.types.Object, name: str) -> bpy.types.Image:
    if name in bpy.data.images:
        return bpy.data.images[name]
    raise UserError(f"{obj.name}: choose an image first: open or paint one in the Image Editor" if not name else
                    f"{obj.name}: there is no image \"{name}\": choose another one")


def _uv_map(obj: bpy.types.Object) -> np.ndarray:
    """(corners, 2) float32 of the active UV map."""
    layer = obj.data.uv_layers.active
    if layer is None:
        raise UserError(f"{obj.name}: it has no UV map to look an image up by: unwrap it in Edit Mode first")
    return compat.uv_values(layer)


def _pixels(obj: bpy.types.Object, image: bpy.types.Image) -> np.ndarray:
    """(height, width, channels) float32, as stored. Of a tiled image, the first tile."""
    width, height = image.size
    if width * height == 0 or len(image.pixels) != width * height * image.channels:
        raise UserError(f"{obj.name}: the pixels of \"{image.name}\" cannot be read: look for its file by File > "
                        "External Data > Find Missing Files")
    flat = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(flat)
    return flat.reshape(height, width, image.channels)


class OBJECT_OT_rumple_paint_from_material(_WholeMap, bpy.types.Operator):
    """Set the weight of this map on all faces of one material, such as skin or a belt. The rest of the map stays"""

    bl_idname = "object.rumple_paint_from_material"
    bl_label = "Map from Material"

    material: bpy.props.StringProperty(name="Material", description="Whose faces get the weight, with their border")
    weight: bpy.props.FloatProperty(name="Weight", min=0.0, max=1.0, default=1.0, options={"SKIP_SAVE"},
                                    description="Of these vertices. 0 for maps that are 1 where nothing is painted")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = context.object
        try:
            names = _materials(obj)  # without a material there is nothing to choose
        except UserError as error:
            return ui_base.refuse(self, error)
        self._choose_weight(painted_maps.find(obj, self.group))
        if self.material not in names and obj.active_material is not None:
            self.material = obj.active_material.name
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context: bpy.types.Context) -> None:
        column = ui_base.property_column(self.layout)
        column.prop_search(self, "material", context.object, "material_slots")
        column.prop(self, "weight", slider=True)

    def change(self, obj: bpy.types.Object, painted: PaintedMap) -> None:
        self._choose_weight(painted)
        values = painted_maps.weights(obj, painted)
        values[_vertices_with(obj, self.material)] = self.weight
        painted_maps.write(obj, painted, values)

    def _choose_weight(self, painted: PaintedMap | None) -> None:
        if painted is not None and not self.properties.is_property_set("weight"):
            self.weight = 1.0 - painted.rest


def _materials(obj: bpy.types.Object) -> list[str]:
    """The names of the materials in its slots, "" for an empty slot. Raises UserError if there is no material."""
    names = [slot.name for slot in obj.material_slots]
    if not any(names):
        raise UserError(f"{obj.name}: it has no material to paint by: give its faces one first")
    return names


def _vertices_with(obj: bpy.types.Object, material: str) -> np.ndarray:
    """(n,) bool: the vertices of the faces that have this material. Raises UserError."""
    slots = [number for number, name in enumerate(_materials(obj)) if name and name == material]
    if not slots:
        raise UserError(f"{obj.name}: it has no material \"{material}\": choose one of its materials")
    faces = np.isin(mesh_reader.material_slots(obj, obj.data), slots)
    if not faces.any():
        raise UserError(f"{obj.name}: no face has the material \"{material}\": choose another one")
    return painted_maps.vertices_of(obj.data, faces)


CLASSES = (OBJECT_OT_rumple_paint, OBJECT_OT_rumple_paint_clear, OBJECT_OT_rumple_paint_invert,
           OBJECT_OT_rumple_paint_from_border, OBJECT_OT_rumple_paint_from_texture,
           OBJECT_OT_rumple_paint_from_material)

_register, _unregister = bpy.utils.register_classes_factory(CLASSES)


def register() -> None:
    _register()


def unregister() -> None:
    painted_maps.stop()
    _unregister()
