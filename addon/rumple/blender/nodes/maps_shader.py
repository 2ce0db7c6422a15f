# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader node group "Rumple Maps": blends wrinkle maps with a material's normal map, pixel by pixel.

It works on colours, as normal maps are stored, between the image of the neutral details and the Normal Map node, so
that everything is blended in one tangent space (section 5.3 of Dutreve et al.; the formulas are those of
shaders/shared/wrinkle_maps.glsl). The masks are point attributes, three poses in a vector:
    rumple_poses_0 .. rumple_poses_5    FLOAT_VECTOR    masks of poses 1 to 3, 4 to 6, ...
"""
from __future__ import annotations

from typing import Iterator, Sequence

import bpy

from ...core.base.wording import UserError
from ...core.systems.poses import PACKED
from .. import compat
from . import builder, use_nodes

NAME = "Rumple Maps"
KEY = "rumple_maps"  # custom property of our node groups, and of the Normal Map nodes made by insert()
MASKS = "rumple_poses_{}"
INPUT, OUTPUT = "Normal Map", "Color"
FLAT = (0.5, 0.5, 1.0, 1.0)


def is_ours(group: bpy.types.NodeTree | None) -> bool:
    """Whether it is a "Rumple Maps" group, independent of its name."""
    return group is not None and KEY in group


# ---------------------------------------------------------------- the group
def new_group(name: str) -> bpy.types.NodeTree:
    """A group that outputs the neutral map unchanged. fill() adds its nodes."""
    group = bpy.data.node_groups.new(f"{NAME} {name}", "ShaderNodeTree")
    group[KEY] = True
    compat.new_group_socket(group, INPUT, "INPUT", "NodeSocketColor")
    compat.new_group_socket(group, OUTPUT, "OUTPUT", "NodeSocketColor")
    fill(group, (), "WRINKLES", "")
    return group


def fill(group: bpy.types.NodeTree, images: Sequence[bpy.types.Image | None], maps: str, uv_map: str) -> None:
    """Rebuild the nodes. Sockets and links outside stay.

    images: the map of every pose; a pose without one is ignored. maps: WHOLE or WRINKLES. uv_map: its name; empty: the
    active one.
    """
    group.nodes.clear()
    _Builder(group).build(images, maps, uv_map)


class _Builder(builder.Nodes):
    """The nodes of the group."""

    ROWS = 5
    WIDTH, HEIGHT = 200.0, 300.0

    def decoded(self, color: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        return self.vector("MULTIPLY_ADD", color, (2.0,) * 3, (-1.0,) * 3)

    def masks(self, poses: Sequence[int]) -> dict[int, bpy.types.NodeSocket]:
        """The mask of every pose, with one Attribute node for three poses."""
        packs = {}
        for pack in sorted({pose // PACKED for pose in poses}):
            attribute = self.node("ShaderNodeAttribute", attribute_name=MASKS.format(pack))
            packs[pack] = self.components(attribute.outputs["Vector"])
        return {pose: packs[pose // PACKED][pose % PACKED] for pose in poses}

    def texture(self, image: bpy.types.Image, place: bpy.types.NodeSocket | None) -> bpy.types.NodeSocket:
        node = self.node("ShaderNodeTexImage", image=image)
        if place is not None:
            self.put(place, node.inputs["Vector"])
        return node.outputs["Color"]

    def build(self, images: Sequence[bpy.types.Image | None], maps: str, uv_map: str) -> None:
        neutral = self.decoded(self.node("NodeGroupInput").outputs[INPUT])
        place = self.node("ShaderNodeUVMap", uv_map=uv_map).outputs[0] if uv_map else None
        poses = [pose for pose, image in enumerate(images) if image is not None]
        total, summed = 0.0, (0.0,) * 3
        for pose, mask in self.masks(poses).items():
            total = self.math("ADD", total, mask)
            summed = self.vector("MULTIPLY_ADD", self.decoded(self.texture(images[pose], place)), mask, summed)
        rest = self.math("MAXIMUM", 0.0, self.math("SUBTRACT", 1.0, total))
        blend = self.blend_whole if maps == "WHOLE" else self.blend_wrinkles
        encoded = self.vector("MULTIPLY_ADD", blend(summed, rest, neutral), (0.5,) * 3, (0.5,) * 3)
        self.put(encoded, self.node("NodeGroupOutput").inputs[OUTPUT])

    def blend_whole(self, summed: object, rest: bpy.types.NodeSocket, neutral: bpy.types.NodeSocket
                    ) -> bpy.types.NodeSocket:
        """As blend_whole() of wrinkle_maps.glsl."""
        return self.vector("NORMALIZE", self.vector("MULTIPLY_ADD", neutral, rest, summed))

    def blend_wrinkles(self, summed: object, rest: bpy.types.NodeSocket, neutral: bpy.types.NodeSocket
                       ) -> bpy.types.NodeSocket:
        """As blend_wrinkles() of wrinkle_maps.glsl."""
        wrinkles = self.vector("NORMALIZE", self.vector("ADD", summed, self.combined(0.0, 0.0, rest)))
        w, n = self.components(wrinkles), self.components(neutral)
        return self.vector("NORMALIZE", self.combined(self.math("ADD", w[0], n[0]), self.math("ADD", w[1], n[1]),
                                                      self.math("MULTIPLY", w[2], n[2])))


# ---------------------------------------------------------------- in a material
def insert(material: bpy.types.Material, group: bpy.types.NodeTree) -> None:
    """Insert the group in front of every Normal Map node that the material's shaders use. If there is none, make one.

    Raises UserError and changes nothing if a normal comes from a node that is not a tangent-space Normal Map.
    """
    if {node.node_tree for node in nodes_in(material)} - {group}:
        raise UserError(f"material {material.name} shows the maps of another object: make it single-user first")
    use_nodes.switch_on(material)
    try:
        _insert(material, group)
    except UserError:
        use_nodes.switch_back(material)
        raise


def _insert(material: bpy.types.Material, group: bpy.types.NodeTree) -> None:
    """Insert it into the tree, unless it is there already."""
    if shown_in(material) is not None:
        return
    maps, bare = _normal_maps(material)
    if bare:
        made = material.node_tree.nodes.new("ShaderNodeNormalMap")
        made[KEY] = True
        made.location = bare[0].node.location.x - 200.0, bare[0].node.location.y - 300.0
        for target in bare:
            material.node_tree.links.new(made.outputs["Normal"], target)
        maps.append(made)
    for normal_map in maps:
        _insert_before(normal_map, group)


def remove(material: bpy.types.Material) -> bool:
    """Remove the nodes of insert(), and restore the former links. Returns whether there were any."""
    tree = material.node_tree
    ours = nodes_in(material)
    for node in ours:
        source = next((link.from_socket for link in node.inputs[INPUT].links), None)
        targets = [link.to_socket for link in node.outputs[OUTPUT].links]
        for target in targets:
            if source is not None:
                tree.links.new(source, target)
        tree.nodes.remove(node)
    for node in [node for node in tree.nodes if KEY in node] if ours else ():
        tree.nodes.remove(node)
    use_nodes.switch_back(material)
    return bool(ours)


def shown_in(material: bpy.types.Material) -> bpy.types.NodeTree | None:
    """The material's "Rumple Maps" group; None if it has none."""
    return next((node.node_tree for node in nodes_in(material)), None)


def nodes_in(material: bpy.types.Material) -> list[bpy.types.Node]:
    """The material's nodes with a "Rumple Maps" group."""
    return [node for node in material.node_tree.nodes if _is_our_node(node)] if material.node_tree is not None else []


def neutral_image(material: bpy.types.Material) -> bpy.types.Image | None:
    """The image of the neutral details, connected to the material's group; None if there is no image."""
    for node in nodes_in(material):
        _, source = _source_of(node.inputs[INPUT])
        if source is not None and source.type == "TEX_IMAGE":
            return source.image
    return None


def _is_our_node(node: bpy.types.Node) -> bool:
    return node.type == "GROUP" and is_ours(node.node_tree)


def _insert_before(normal_map: bpy.types.Node, group: bpy.types.NodeTree) -> None:
    tree, target = normal_map.id_data, normal_map.inputs["Color"]
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.location = normal_map.location.x - 200.0, normal_map.location.y
    node.inputs[INPUT].default_value = target.default_value
    if target.is_linked:
        tree.links.new(target.links[0].from_socket, node.inputs[INPUT])
    tree.links.new(node.outputs[OUTPUT], target)


def _normal_maps(material: bpy.types.Material) -> tuple[list[bpy.types.Node], list[bpy.types.NodeSocket]]:
    """The Normal Map nodes connected to the shaders' normals, and the normal inputs with no connection."""
    maps: list[bpy.types.Node] = []
    bare: list[bpy.types.NodeSocket] = []
    for shader in _shaders(material):
        target, source = _source_of(shader.inputs["Normal"])
        while source is not None and source.type == "BUMP":  # a Bump node adds to its input
            target, source = _source_of(source.inputs["Normal"])
        if source is None:
            if target not in bare:
                bare.append(target)
        elif source.type != "NORMAL_MAP" or source.space != "TANGENT":
            raise UserError(f"material {material.name}: the normal of {shader.name} comes from {source.name}, which is "
                            "no Normal Map in tangent space: connect one in between")
        elif source not in maps:
            maps.append(source)
    if not maps and not bare:
        raise UserError(f"material {material.name} has no shader that takes a normal: connect a Principled BSDF")
    return maps, bare


def _shaders(material: bpy.types.Material) -> Iterator[bpy.types.Node]:
    """The shader nodes with a normal that the material's surface uses."""
    output = material.node_tree.get_output_node("ALL")
    waiting = [output.inputs["Surface"]] if output is not None else []
    seen: set[bpy.types.Node] = set()
    while waiting:
        _, node = _source_of(waiting.pop())
        if node is None or node in seen:
            continue
        seen.add(node)
        if "Normal" in node.inputs:
            yield node
        waiting += [socket for socket in node.inputs if socket.type == "SHADER"]


def _source_of(target: bpy.types.NodeSocket) -> tuple[bpy.types.NodeSocket, bpy.types.Node | None]:
    """The input before any reroutes, and the node connected to it."""
    while target.is_linked:
        node = target.links[0].from_node
        if node.type != "REROUTE":
            return target, node
        target = node.inputs[0]
    return target, None
